import type { GeoJSONSource, GeoJSONSourceSpecification, LayerSpecification, MapMouseEvent, MapTouchEvent, SourceSpecification } from 'maplibre-gl';
import type { TerrainMap } from '../map.ts';
import { toLonLat, toMetres, type Metres } from '../mercator.ts';
import { LEAST_POINTS, type Kind, type Stroke } from './model.ts';

export interface PenEvents {
  /** A stroke is finished. */
  drawn(kind: Kind, points: Metres[]): void;
  /** A corner of a stroke was moved; `settled` when it is let go. */
  bent(stroke: number, points: Metres[], settled: boolean): void;
  chosen(stroke: number | undefined): void;
  /** What is being drawn has so many corners; undefined when nothing is. */
  drawing(corners: number | undefined): void;
}

/** Where a picture lies on the plane. */
export interface Picture {
  url: string;
  bbox: [number, number, number, number];
}

const SOURCE = 'sketch';
const PICTURE = 'sketch-preview';
/** How near a finger must come to a corner, in pixels. */
const NEAR = 14;

const INK = '#c2410c';
const CHOSEN = '#1d4ed8';

const LAYERS: LayerSpecification[] = [
  { id: 'sketch-areas', type: 'fill', source: SOURCE, filter: ['==', ['get', 'part'], 'area'], paint: { 'fill-color': INK, 'fill-opacity': 0.18 } },
  {
    id: 'sketch-casing', type: 'line', source: SOURCE, filter: ['==', ['get', 'part'], 'line'],
    layout: { 'line-join': 'round', 'line-cap': 'round' }, paint: { 'line-color': '#fff', 'line-width': 6, 'line-opacity': 0.85 },
  },
  {
    id: 'sketch-lines', type: 'line', source: SOURCE, filter: ['==', ['get', 'part'], 'line'],
    layout: { 'line-join': 'round', 'line-cap': 'round' }, paint: { 'line-color': ['case', ['get', 'chosen'], CHOSEN, INK], 'line-width': 3 },
  },
  {
    id: 'sketch-corners', type: 'circle', source: SOURCE, filter: ['==', ['get', 'part'], 'corner'],
    paint: {
      'circle-radius': 6, 'circle-color': '#fff', 'circle-stroke-width': 3, 'circle-stroke-color': ['case', ['get', 'chosen'], CHOSEN, INK],
    },
  },
];

type Feature = { type: 'Feature'; properties: Record<string, unknown>; geometry: { type: string; coordinates: unknown } };

const lonLat = (point: Metres): [number, number] => {
  const { lon, lat } = toLonLat(point);
  return [lon, lat];
};

/** What stands for a stroke on the map. */
function featuresOf({ kind, points }: Pick<Stroke, 'kind' | 'points'>, stroke: number, chosen: boolean): Feature[] {
  const line = points.map(lonLat);
  const closed = kind === 'area' && line.length > 2 ? [...line, line[0]] : line;
  const make = (part: string, type: string, coordinates: unknown): Feature => ({ type: 'Feature', properties: { part, stroke, chosen }, geometry: { type, coordinates } });
  return [
    ...(kind === 'area' && line.length > 2 ? [make('area', 'Polygon', [closed])] : []),
    ...(closed.length > 1 ? [make('line', 'LineString', closed)] : []),
    ...(chosen || kind === 'point' ? line.map((corner) => make('corner', 'Point', corner)) : []),
  ];
}

/** Strokes on the map: drawn corner by corner, chosen, bent. */
export class Pen {
  #strokes: readonly Stroke[] = [];
  #chosen: number | undefined;
  #kind: Kind | undefined;
  #corners: Metres[] = [];
  #picture: Picture | undefined;
  #shown = false;
  #taken: { stroke: number; corner: number; points: Metres[] } | undefined;

  constructor(
    readonly terrain: TerrainMap,
    readonly events: PenEvents,
  ) {
    const { map } = terrain;
    map.on('click', (event) => this.#click(event));
    map.on('dblclick', (event) => {
      if (!this.#kind) return;
      event.preventDefault(); // it ends a stroke, it does not zoom
      this.finish();
    });
    map.on('mousedown', (event) => this.#take(event));
    map.on('touchstart', (event) => this.#take(event));
    map.on('mousemove', (event) => this.#move(event));
    map.on('touchmove', (event) => this.#move(event));
    map.on('mouseup', () => this.#release());
    map.on('touchend', () => this.#release());
  }

  /** Puts strokes on the map, or takes all away. */
  show(strokes: readonly Stroke[], chosen: number | undefined): void {
    this.#strokes = strokes;
    this.#chosen = chosen;
    this.#shown = true;
    this.#draw();
  }

  hide(): void {
    this.use(undefined);
    this.#shown = false;
    this.#picture = undefined;
    this.terrain.setExtra({ sources: {}, layers: [] });
  }

  /** What the next clicks draw; undefined: they choose. */
  use(kind: Kind | undefined): void {
    this.#kind = kind;
    this.#corners = [];
    this.terrain.map.getCanvas().style.cursor = kind ? 'crosshair' : '';
    this.events.drawing(kind ? 0 : undefined);
    if (this.#shown) this.#draw();
  }

  /** Adds a corner in the middle of the view, for those without a pointer. */
  addAtCentre(): void {
    const { lng, lat } = this.terrain.map.getCenter();
    this.#add(toMetres({ lon: lng, lat }));
  }

  /** Takes back the last corner; false if there is none. */
  back(): boolean {
    if (!this.#corners.pop()) return false;
    this.events.drawing(this.#corners.length);
    this.#draw();
    return true;
  }

  /** Ends the stroke that is being drawn, if it has corners enough. */
  finish(): void {
    const kind = this.#kind;
    if (!kind || this.#corners.length < LEAST_POINTS[kind]) return;
    const points = this.#corners;
    this.#corners = [];
    this.events.drawing(0);
    this.events.drawn(kind, points);
  }

  preview(picture: Picture | undefined): void {
    this.#picture = picture;
    if (this.#shown) this.#install();
  }

  #click(event: MapMouseEvent): void {
    if (!this.#shown) return;
    if (this.#kind) return this.#add(toMetres({ lon: event.lngLat.lng, lat: event.lngLat.lat }));
    const { x, y } = event.point;
    const layers = ['sketch-corners', 'sketch-lines', 'sketch-areas'].filter((id) => this.terrain.map.getLayer(id));
    const [found] = this.terrain.map.queryRenderedFeatures([[x - NEAR / 2, y - NEAR / 2], [x + NEAR / 2, y + NEAR / 2]], { layers });
    this.events.chosen(found ? Number(found.properties['stroke']) : undefined);
  }

  #add(point: Metres): void {
    const last = this.#corners.at(-1);
    // The second click of a double click ends a stroke, it adds no corner.
    if (last) {
      const a = this.terrain.map.project(lonLat(last));
      const b = this.terrain.map.project(lonLat(point));
      if (Math.hypot(a.x - b.x, a.y - b.y) < 4) return;
    }
    this.#corners.push(point);
    if (this.#kind === 'point') return this.finish();
    this.events.drawing(this.#corners.length);
    this.#draw();
  }

  #take(event: MapMouseEvent | MapTouchEvent): void {
    if (this.#kind || this.#chosen === undefined || !this.#shown) return;
    const points = this.#strokes[this.#chosen]?.points ?? [];
    const distances = points.map((point) => this.terrain.map.project(lonLat(point)).dist(event.point));
    const corner = distances.indexOf(Math.min(...distances));
    if (!((distances[corner] ?? Infinity) <= NEAR)) return;
    event.preventDefault(); // the map stays
    this.#taken = { stroke: this.#chosen, corner, points: [...points] };
  }

  #move(event: MapMouseEvent | MapTouchEvent): void {
    const taken = this.#taken;
    if (!taken) return;
    taken.points[taken.corner] = toMetres({ lon: event.lngLat.lng, lat: event.lngLat.lat });
    this.events.bent(taken.stroke, [...taken.points], false);
  }

  #release(): void {
    const taken = this.#taken;
    this.#taken = undefined;
    if (taken) this.events.bent(taken.stroke, taken.points, true);
  }

  #data(): GeoJSONSourceSpecification['data'] {
    const drawn = this.#strokes.flatMap((stroke, i) => featuresOf(stroke, i, i === this.#chosen));
    const fresh = this.#kind && this.#corners.length > 0 ? featuresOf({ kind: this.#kind, points: this.#corners }, -1, true) : [];
    return { type: 'FeatureCollection', features: [...drawn, ...fresh] } as GeoJSONSourceSpecification['data'];
  }

  /** While a corner is dragged this is called for every frame: the style is left alone. */
  #draw(): void {
    const source = this.terrain.map.getSource<GeoJSONSource>(SOURCE);
    this.#install(source === undefined);
    source?.setData(this.#data() as Parameters<GeoJSONSource['setData']>[0]);
  }

  #install(now = true): void {
    const sources: Record<string, SourceSpecification> = { [SOURCE]: { type: 'geojson', data: this.#data() } };
    const layers: LayerSpecification[] = [];
    if (this.#picture) {
      const [west, south, east, north] = this.#picture.bbox;
      const corners = [[west, north], [east, north], [east, south], [west, south]].map(([x, y]) => lonLat({ x: x ?? 0, y: y ?? 0 }));
      sources[PICTURE] = { type: 'image', url: this.#picture.url, coordinates: corners as [[number, number], [number, number], [number, number], [number, number]] };
      layers.push({ id: PICTURE, type: 'raster', source: PICTURE, paint: { 'raster-fade-duration': 0 } });
    }
    this.terrain.setExtra({ sources, layers: [...layers, ...LAYERS] }, now);
  }
}
