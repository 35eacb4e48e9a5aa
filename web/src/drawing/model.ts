import type { Json, JsonObject } from '../api.ts';
import type { Metres } from '../mercator.ts';

/** What a user draws, and how it becomes a drawing as the server reads it (docs/paths.md) and comes back. */

export type Kind = 'line' | 'point' | 'area';

/** A crest: terrain falls off from it on all sides. Metres. */
export interface Stroke {
  kind: Kind;
  /** Corners; the ring of an area is not closed. */
  points: Metres[];
  /** The name of its profile. */
  profile: string;
  height: number;
  /** From the crest to the foot. */
  width: number;
}

/** (share of the way from the crest to the foot, share of the height): from (0, 1) to (1, 0), never rising. */
export type Curve = [number, number][];

export type Detail = 'draft' | 'normal' | 'fine';

export interface Sketch {
  title: string;
  strokes: Stroke[];
  profiles: Record<string, Curve>;
  /** 0 … 0.9: how unlike the steps of a path are. */
  roughness: number;
  /** 0 … 20: how sharply the higher of two strokes wins. */
  bias: number;
  /** Side ridges of each stroke. */
  ridges: number;
  detail: Detail;
  seed: number;
}

export const PROFILES: Record<string, Curve> = {
  mountain: [[0, 1], [0.08, 0.87], [0.2, 0.69], [0.36, 0.47], [0.55, 0.27], [0.76, 0.11], [1, 0]],
  ridge: [[0, 1], [0.06, 0.86], [0.14, 0.68], [0.26, 0.47], [0.42, 0.27], [0.62, 0.12], [0.82, 0.035], [1, 0]],
  hill: [[0, 1], [0.12, 0.97], [0.27, 0.86], [0.42, 0.67], [0.57, 0.43], [0.72, 0.22], [0.86, 0.08], [1, 0]],
  cone: [[0, 1], [1, 0]],
  mesa: [[0, 1], [0.35, 0.98], [0.42, 0.55], [0.55, 0.35], [0.75, 0.15], [1, 0]],
  terraces: [[0, 1], [0.14, 0.98], [0.2, 0.72], [0.4, 0.68], [0.46, 0.4], [0.68, 0.36], [0.74, 0.1], [1, 0]],
};

/** Nodes that the lattice should have, with what strokes reach. */
const NODES: Record<Detail, number> = { draft: 250_000, normal: 1_000_000, fine: 3_000_000 };

/** The farthest that a path may go, in nodes, with room to spare. */
const MOST_REACH = 900;

/** Corners that a kind needs. */
export const LEAST_POINTS: Record<Kind, number> = { line: 2, point: 1, area: 3 };

export const emptySketch = (): Sketch => ({
  title: '',
  strokes: [],
  profiles: structuredClone(PROFILES),
  roughness: 0.5,
  bias: 3,
  ridges: 6,
  detail: 'normal',
  seed: 1,
});

const isWhole = ({ kind, points }: Stroke) => points.length >= LEAST_POINTS[kind];

/** A length as a person would write it: three digits, rounded up. */
function rounded(length: number): number {
  const unit = 10 ** (Math.floor(Math.log10(length)) - 2);
  // Units below 1 are no exact numbers: what follows the third digit is cut off.
  return Number((Math.ceil(length / unit) * unit).toPrecision(3));
}

/** The lattice: over all strokes and their flanks, where side ridges begin, and as fine as the wish for detail allows with what paths may reach beyond. */
function lattice({ strokes, roughness, detail }: Sketch): { origin: [number, number]; spacing: number; size: [number, number] } {
  const points = strokes.flatMap(({ points }) => points);
  const [xs, ys] = [points.map(({ x }) => x), points.map(({ y }) => y)];
  const flank = Math.max(...strokes.map((stroke) => stroke.width));
  const [x, y] = [Math.min(...xs) - flank, Math.min(...ys) - flank];
  const [width, height] = [Math.max(...xs) + flank - x, Math.max(...ys) + flank - y];
  // The easiest way down goes farther than the mean one.
  const reach = flank / (1 - roughness);
  const area = (width + 2 * reach) * (height + 2 * reach);
  const spacing = rounded(Math.max(Math.sqrt(area / NODES[detail]), reach / MOST_REACH));
  const nodes = (length: number) => Math.max(2, Math.ceil(length / spacing) + 1);
  return { origin: [x, y], spacing, size: [nodes(width), nodes(height)] };
}

function geometry(strokes: readonly Stroke[], kind: Kind, [x, y]: [number, number]): JsonObject {
  const at = (point: Metres): Json => [point.x - x, point.y - y];
  const lines = strokes.map(({ points }) => points.map(at));
  if (kind === 'point') return { type: 'MultiPoint', coordinates: lines.map(([point]) => point ?? null) };
  if (kind === 'line') return { type: 'MultiLineString', coordinates: lines };
  return { type: 'MultiPolygon', coordinates: lines.map((ring) => [[...ring, ring[0] ?? null]]) };
}

/** What a job is asked for; undefined as long as nothing is drawn. */
export function toWork(sketch: Sketch): JsonObject | undefined {
  const strokes = sketch.strokes.filter(isWhole);
  if (strokes.length === 0) return undefined;
  const { origin, spacing, size } = lattice({ ...sketch, strokes });
  const most = Math.max(...strokes.map(({ height }) => height));
  const groups = new Map<string, Stroke[]>();
  for (const stroke of strokes) {
    const { kind, profile, height, width } = stroke;
    const key = JSON.stringify([kind, profile, height, width]);
    groups.set(key, [...(groups.get(key) ?? []), stroke]);
  }
  const profiles: JsonObject = {};
  const drawn = [...groups.values()].map((group, i): JsonObject => {
    const { kind, profile, height, width } = group[0] as Stroke;
    const name = `${profile}-${i + 1}`;
    // A profile is as wide as for the highest crest there can be, and lower ones have a part of it.
    profiles[name] = { points: sketch.profiles[profile] ?? PROFILES['cone'] ?? [], width: (width * most) / height };
    return { shape: { geometry: geometry(group, kind, origin) }, profiles: [name], cost: most - height };
  });
  const count = Math.round(sketch.ridges * strokes.length);
  return {
    paths: {
      drawing: {
        ...(sketch.title ? { title: sketch.title } : {}),
        origin,
        spacing,
        size,
        seed: sketch.seed,
        edges: { random: { mean: 1, deviation: sketch.roughness } },
        sea_level: { cost: most },
        sea_threshold: most / 200,
        bias: sketch.bias,
        profiles,
        strokes: drawn,
        ...(count > 0 ? { ridges: [{ count, share: 0.5, within: Math.max(...strokes.map(({ width }) => width)) }] } : {}),
      },
    },
  };
}

interface Drawn {
  title?: string;
  origin: [number, number];
  spacing: number;
  size: [number, number];
  seed: number;
  edges: { random?: { deviation: number } };
  sea_level: { cost?: number };
  bias: unknown;
  profiles: Record<string, { points?: Curve; width: number }>;
  strokes: { shape: { geometry?: { type: string; coordinates: unknown } }; profiles: string[]; cost: unknown }[];
  ridges?: { count: number }[];
}

function strokesOf(drawing: Drawn, most: number): Stroke[] | undefined {
  const [x, y] = drawing.origin;
  const at = ([east, north]: [number, number]): Metres => ({ x: x + east, y: y + north });
  const strokes: Stroke[] = [];
  for (const { shape, profiles, cost } of drawing.strokes) {
    const [name] = profiles;
    const profile = name === undefined ? undefined : drawing.profiles[name];
    if (!shape.geometry || name === undefined || !profile || typeof cost !== 'number') return undefined;
    const height = most - cost;
    const rest = { profile: name.replace(/-\d+$/, ''), height, width: Number(((profile.width * height) / most).toPrecision(12)) };
    const { type, coordinates } = shape.geometry;
    if (type === 'MultiPoint') strokes.push(...(coordinates as [number, number][]).map((point) => ({ kind: 'point' as const, points: [at(point)], ...rest })));
    else if (type === 'MultiLineString') strokes.push(...(coordinates as [number, number][][]).map((line) => ({ kind: 'line' as const, points: line.map(at), ...rest })));
    else if (type === 'MultiPolygon') strokes.push(...(coordinates as [number, number][][][]).map(([ring]) => ({ kind: 'area' as const, points: (ring ?? []).slice(0, -1).map(at), ...rest })));
    else return undefined;
  }
  return strokes;
}

/** The sketch that a job was asked for; undefined if it is not one that can be drawn here. */
export function fromWork(work: JsonObject): Sketch | undefined {
  const drawing = (work['paths'] as { drawing?: Drawn } | undefined)?.drawing;
  const most = drawing?.sea_level.cost;
  if (!drawing || most === undefined || !drawing.edges.random || typeof drawing.bias !== 'number') return undefined;
  const strokes = strokesOf(drawing, most);
  if (!strokes || strokes.length === 0) return undefined;
  const own = Object.entries(drawing.profiles).map(([name, { points }]) => [name.replace(/-\d+$/, ''), points] as const);
  if (own.some(([, points]) => !points)) return undefined;
  const sketch: Sketch = {
    title: drawing.title ?? '',
    strokes,
    profiles: { ...structuredClone(PROFILES), ...(Object.fromEntries(own) as Record<string, Curve>) },
    roughness: drawing.edges.random.deviation,
    bias: drawing.bias,
    ridges: (drawing.ridges?.[0]?.count ?? 0) / strokes.length,
    detail: 'normal',
    seed: drawing.seed,
  };
  const details = Object.keys(NODES) as Detail[];
  const found = details.find((detail) => lattice({ ...sketch, detail }).spacing === drawing.spacing);
  return { ...sketch, detail: found ?? 'normal' };
}

/** A curve with one point moved, kept between its neighbours so that it never rises. */
export function moved(curve: Curve, i: number, [distance, height]: [number, number]): Curve {
  const [before, after] = [curve[i - 1], curve[i + 1]];
  const clamp = (value: number, low: number, high: number) => Math.min(high, Math.max(low, value));
  const gap = 0.01;
  const place: [number, number] = [
    before && after ? clamp(distance, before[0] + gap, after[0] - gap) : (curve[i]?.[0] ?? 0),
    before && after ? clamp(height, after[1], before[1]) : (curve[i]?.[1] ?? 0),
  ];
  return curve.map((point, other) => (other === i ? place : point));
}

/** A curve with another point in the middle of the widest gap, or where it is wished for. */
export function withPoint(curve: Curve, at?: number): Curve {
  const gaps = curve.slice(1).map(([d], i) => d - (curve[i]?.[0] ?? 0));
  const widest = gaps.indexOf(Math.max(...gaps));
  const distance = at ?? ((curve[widest]?.[0] ?? 0) + (curve[widest + 1]?.[0] ?? 1)) / 2;
  const next = curve.findIndex(([d]) => d > distance);
  const [a, b] = [curve[next - 1], curve[next]];
  if (!a || !b || distance - a[0] < 0.01 || b[0] - distance < 0.01) return curve;
  const height = a[1] + ((b[1] - a[1]) * (distance - a[0])) / (b[0] - a[0]);
  return [...curve.slice(0, next), [distance, height], ...curve.slice(next)];
}

/** A curve without one of its inner points. */
export const withoutPoint = (curve: Curve, i: number): Curve =>
  i > 0 && i < curve.length - 1 ? curve.filter((_, other) => other !== i) : curve;
