import assert from 'node:assert/strict';
import { test } from 'node:test';
import { PROFILES, emptySketch, fromWork, moved, toWork, withPoint, withoutPoint, type Curve, type Sketch } from '../src/drawing/model.ts';

const sketch = (change: Partial<Sketch> = {}): Sketch => ({
  ...emptySketch(),
  title: 'Two ranges',
  strokes: [
    { kind: 'line', points: [{ x: 1000, y: 2000 }, { x: 5000, y: 2600 }], profile: 'mountain', height: 900, width: 2500 },
    { kind: 'line', points: [{ x: 1000, y: 9000 }, { x: 3000, y: 9500 }, { x: 3500, y: 9100 }], profile: 'mountain', height: 900, width: 2500 },
    { kind: 'point', points: [{ x: -200, y: 4000 }], profile: 'own', height: 300, width: 800 },
    { kind: 'area', points: [{ x: 0, y: 0 }, { x: 900, y: 0 }, { x: 900, y: 700 }], profile: 'mesa', height: 120, width: 400 },
  ],
  profiles: { ...PROFILES, own: [[0, 1], [0.3, 0.2], [1, 0]] },
  ...change,
});

interface Drawing {
  origin: [number, number];
  spacing: number;
  size: [number, number];
  sea_level: { cost: number };
  profiles: Record<string, { points: Curve; width: number }>;
  strokes: { shape: { geometry: { type: string; coordinates: unknown[] } }; profiles: [string]; cost: number }[];
  ridges?: { count: number }[];
}
const drawingOf = (of: Sketch): Drawing => (toWork(of) as unknown as { paths: { drawing: Drawing } }).paths.drawing;

test('heights and widths are those of each stroke, whatever the highest is', () => {
  const drawing = drawingOf(sketch());
  assert.equal(drawing.strokes.length, 3, 'strokes that are alike are one group');
  for (const [i, { height, width }] of [{ height: 900, width: 2500 }, { height: 300, width: 800 }, { height: 120, width: 400 }].entries()) {
    const { cost, profiles } = drawing.strokes[i]!;
    assert.equal(drawing.sea_level.cost - cost, height);
    // A crest has the part k of the profile that its height is of the greatest (docs/paths.md).
    const k = height / drawing.sea_level.cost;
    assert.ok(Math.abs(drawing.profiles[profiles[0]]!.width * k - width) < 1e-9);
  }
});

test('the lattice holds every corner and is as fine as wished for', () => {
  for (const detail of ['draft', 'normal', 'fine'] as const) {
    const { origin, spacing, size, strokes } = drawingOf(sketch({ detail }));
    assert.deepEqual(origin, [-2700, -2500], 'flanks belong to it');
    const corners = strokes.flatMap(({ shape }) => (shape.geometry.coordinates.flat(3) as number[]));
    for (let i = 0; i < corners.length; i += 2) {
      assert.ok(corners[i]! >= 0 && corners[i]! <= (size[0] - 1) * spacing, `x ${corners[i]}`);
      assert.ok(corners[i + 1]! >= 0 && corners[i + 1]! <= (size[1] - 1) * spacing, `y ${corners[i + 1]}`);
    }
    const reach = 2500 / (1 - 0.5);
    const nodes = ((size[0] * spacing + 2 * reach) * (size[1] * spacing + 2 * reach)) / spacing ** 2;
    const most = { draft: 250_000, normal: 1_000_000, fine: 3_000_000 }[detail];
    assert.ok(nodes > most * 0.8 && nodes < most * 1.1, `${detail}: ${nodes}`);
  }
  assert.ok(drawingOf(sketch({ roughness: 0.9, detail: 'fine' })).spacing >= 2500 / 0.1 / 900, 'no path goes too far');
});

test('a sketch comes back as it was', () => {
  for (const change of [{}, { detail: 'draft', ridges: 0, bias: 7.5, seed: 99 }] as Partial<Sketch>[]) {
    const before = sketch(change);
    assert.deepEqual(fromWork(toWork(before)!), before);
  }
  assert.equal(fromWork({ paths: { drawing: { strokes: [], sea_level: { scale: 1.1 }, edges: {}, profiles: {} } } }), undefined);
  assert.equal(toWork(emptySketch()), undefined, 'nothing is drawn');
  const unfinished = emptySketch();
  unfinished.strokes.push({ kind: 'line', points: [{ x: 0, y: 0 }], profile: 'hill', height: 10, width: 10 });
  assert.equal(toWork(unfinished), undefined);
});

test('profiles never rise, whatever is done to them', () => {
  let curve = PROFILES['terraces']!;
  const falls = (of: Curve) => of.every(([d, h], i) => i === 0 || (d > of[i - 1]![0] && h <= of[i - 1]![1]));
  for (let i = 0; i < 500; i++) {
    const at = (i * 7919) % curve.length;
    if (i % 3 === 0) curve = withPoint(curve, ((i * 31) % 100) / 100);
    else if (i % 7 === 0 && curve.length > 4) curve = withoutPoint(curve, at);
    else curve = moved(curve, at, [((i * 37) % 140) / 100 - 0.2, ((i * 53) % 140) / 100 - 0.2]);
    assert.ok(falls(curve), JSON.stringify(curve));
    assert.deepEqual([curve[0], curve.at(-1)], [[0, 1], [1, 0]], 'the ends stay');
  }
  assert.ok(curve.length > 4);
});
