import {
  Map as MapLibre,
  NavigationControl,
  setWorkerUrl,
  type LayerSpecification,
  type RasterDEMTileSource,
  type SourceSpecification,
  type StyleSpecification,
} from 'maplibre-gl';
import workerUrl from 'maplibre-gl/dist/maplibre-gl-worker.mjs?url';
import { authorization } from './key.ts';
import { OVERLAYS, type Camera, type Overlay } from './link.ts';
import { HALF, toMetres, type LonLat } from './mercator.ts';

setWorkerUrl(workerUrl);

/** The pitch that 3D starts with, and the steepest that still loads a sane number of tiles. */
const PITCH = 60;
const MAX_PITCH = 80;
/** MapLibre's own limit is 25; the server's tiles end at 24. */
const MAX_ZOOM = 24;

/** How a world is looked at; without a camera, from where its style says. */
export interface View {
  camera?: Camera | undefined;
  tilted: boolean;
  exaggeration: number;
  overlays?: readonly Overlay[] | undefined;
}

export interface ShownTile {
  template: string;
  z: number;
}

/** What lies over the world without being part of it. */
export interface Extra {
  sources: Record<string, SourceSpecification>;
  layers: LayerSpecification[];
}

/** The source whose tiles bend the terrain in 3D. */
const MESH = 'mesh';

function shadedSource(style: StyleSpecification): string {
  const layer = style.layers.find(({ type }) => type === 'hillshade');
  return layer && 'source' in layer ? layer.source : 'terrain';
}

/** Seen in 3D above the horizon, unless the style has a sky of its own. */
const SKY: NonNullable<StyleSpecification['sky']> = {
  'sky-color': '#8fb6d3',
  'horizon-color': '#e6edf0',
  'fog-color': '#dfe8ea',
  'sky-horizon-blend': 0.7,
  'horizon-fog-blend': 0.7,
  'fog-ground-blend': 0.9,
};

const hasSource = (layer: LayerSpecification) => 'source' in layer;

/** Which overlay a layer of the server's style belongs to. */
const overlayOf = (layer: LayerSpecification) => OVERLAYS.find((overlay) => 'source' in layer && layer.source === overlay);

/**
 * The server's style as the map shows it. `mark` makes the ids of its sources and layers its own, so that two
 * revisions can be on the map at once. MapLibre loads coarser tiles for the mesh of 3D than for painting, hence the
 * mesh has a source that paints nothing.
 */
function adapt(style: StyleSpecification, mark: string, overlays: readonly Overlay[]): StyleSpecification {
  const sources = { ...style.sources, [MESH]: style.sources[shadedSource(style)] };
  const layers = style.layers.map((layer) => {
    if (!('source' in layer)) return layer;
    const marked = { ...layer, id: layer.id + mark, source: layer.source + mark };
    const overlay = overlayOf(layer);
    return overlay ? { ...marked, layout: { ...layer.layout, visibility: visibility(overlays, overlay) } } : marked;
  });
  const marked = Object.entries(sources).map(([id, source]) => [id + mark, source]);
  // Without its own center and zoom: MapLibre would prefer them to a link that points to lon 0, lat 0 at zoom 0.
  const { center: _center, zoom: _zoom, ...rest } = style;
  return { sky: SKY, ...rest, sources: Object.fromEntries(marked), layers: layers as LayerSpecification[] };
}

const visibility = (overlays: readonly Overlay[], overlay: Overlay) => (overlays.includes(overlay) ? 'visible' : 'none');

/** The new style painted over the old one, which shows through until the new tiles are there. */
function overlay(old: StyleSpecification, renewed: StyleSpecification): StyleSpecification {
  const ground = renewed.layers.filter((layer) => !hasSource(layer));
  const painted = [old, renewed].flatMap(({ layers }) => layers.filter(hasSource));
  return { ...renewed, sources: { ...old.sources, ...renewed.sources }, layers: [...ground, ...painted] };
}

/** The map of one world at a time, flat or tilted. */
export class TerrainMap {
  readonly map: MapLibre;
  /** As the server gave it, and as the map shows it. */
  #given: StyleSpecification;
  #style: StyleSpecification;
  #mark = '';
  #tilted: boolean;
  #exaggeration: number;
  #overlays: readonly Overlay[];
  #extra: Extra = { sources: {}, layers: [] };
  #renewals = 0;
  #renewing = false;

  constructor(container: HTMLElement, style: StyleSpecification, view: View) {
    this.#given = style;
    this.#overlays = view.overlays ?? [];
    this.#style = this.#adapt(style);
    this.#tilted = view.tilted;
    this.#exaggeration = view.exaggeration;
    this.map = new MapLibre({
      container,
      style: this.#complete(),
      ...this.#opening(style, view.camera),
      maxZoom: MAX_ZOOM,
      maxPitch: MAX_PITCH,
      renderWorldCopies: false, // the plane does not repeat
      attributionControl: false, // the viewer puts it where nothing lies over it
      fadeDuration: 0,
      // The key is for no other server.
      transformRequest: (url) => ({ url, headers: new URL(url, location.href).origin === location.origin ? authorization() : {} }),
    });
    this.map.addControl(new NavigationControl({ visualizePitch: true }), 'top-right');
    this.map.on('style.load', () => this.#applyTerrain());
    this.#allowPitch();
  }

  /** Whether the picture will change once more although the map is idle. */
  get renewing(): boolean {
    return this.#renewing;
  }

  get tilted(): boolean {
    return this.#tilted;
  }

  get exaggeration(): number {
    return this.#exaggeration;
  }

  /** What can be laid over this world, and what of it is shown. */
  get overlays(): { there: Overlay[]; shown: Overlay[] } {
    const there = OVERLAYS.filter((overlay) => overlay in this.#given.sources);
    return { there, shown: [...this.#overlays] };
  }

  setOverlays(overlays: readonly Overlay[]): void {
    this.#overlays = overlays;
    this.#style = adapt(this.#given, this.#mark, overlays);
    for (const layer of this.#given.layers) {
      const overlay = overlayOf(layer);
      const id = layer.id + this.#mark;
      if (overlay && this.map.getLayer(id)) this.map.setLayoutProperty(id, 'visibility', visibility(overlays, overlay));
    }
  }

  /** Lays something over this world and those that come after it; without `now`, when the style is next set. */
  setExtra(extra: Extra, now = true): void {
    this.#extra = extra;
    if (now && this.map.getStyle()) this.map.setStyle(this.#complete());
  }

  get camera(): Camera {
    const { lng, lat } = this.map.getCenter();
    return {
      lon: lng,
      lat,
      zoom: this.map.getZoom(),
      bearing: this.map.getBearing(),
      pitch: this.map.getPitch(),
    };
  }

  /** Shows another world. */
  show(style: StyleSpecification, view: View): void {
    this.#given = style;
    this.#overlays = view.overlays ?? [];
    this.#style = this.#adapt(style);
    this.#tilted = view.tilted;
    this.#exaggeration = view.exaggeration;
    this.#renewing = false;
    this.#allowPitch();
    this.map.setStyle(this.#complete(), { diff: false });
    this.map.jumpTo(this.#opening(style, view.camera));
  }

  /**
   * Shows a new revision of the same world, seen from where we are. Giving the sources new addresses would not do:
   * MapLibre then fits the edges of the first new tiles to their old neighbours, and never again, which shows as seams.
   */
  renew(style: StyleSpecification): void {
    const old = this.#complete();
    this.#given = style;
    this.#style = this.#adapt(style);
    this.#renewing = true;
    const mark = this.#mark;
    this.map.setStyle({ ...overlay(old, this.#style), ...(old.terrain ? { terrain: old.terrain } : {}) });
    this.map.once('idle', () => {
      if (mark !== this.#mark) return; // overtaken by the next one
      this.#renewing = false;
      this.map.setStyle(this.#complete());
    });
  }

  /** Asks again for every tile in view that is not in the browser's cache. */
  reload(): void {
    this.renew(this.#given);
  }

  /** Goes where a link says. */
  moveTo(view: View): void {
    this.setOverlays(view.overlays ?? []);
    this.#tilted = view.tilted;
    this.#exaggeration = view.exaggeration;
    this.#allowPitch();
    this.#applyTerrain();
    this.map.jumpTo(this.#opening(this.#given, view.camera));
  }

  setTilted(tilted: boolean): void {
    this.#tilted = tilted;
    if (tilted) this.map.setMaxPitch(MAX_PITCH);
    else this.map.once('moveend', () => this.#allowPitch());
    this.#applyTerrain();
    this.map.easeTo({ pitch: tilted ? PITCH : 0, duration: 500 });
  }

  setExaggeration(exaggeration: number): void {
    this.#exaggeration = exaggeration;
    this.#applyTerrain();
  }

  /** The tile that shows this place: MapLibre's own choice, which in a tilted view depends on the distance. */
  tileAt(place: LonLat): ShownTile | undefined {
    const source = this.map.getSource<RasterDEMTileSource>(shadedSource(this.#style));
    const template = source?.tiles?.[0];
    if (!source || !template) return undefined;
    const { minzoom, maxzoom, tileSize, roundZoom } = source;
    let z = Math.min(maxzoom, Math.max(minzoom, Math.round(this.map.getZoom())));
    const { x, y } = toMetres(place);
    const options = { minzoom, maxzoom, tileSize, roundZoom, ...(this.map.terrain ? { terrain: this.map.terrain } : {}) };
    for (const { canonical } of this.map.coveringTiles(options)) {
      const side = (2 * HALF) / 2 ** canonical.z;
      const column = Math.floor((x + HALF) / side);
      const row = Math.floor((HALF - y) / side);
      if (canonical.x === column && canonical.y === row) z = canonical.z;
    }
    return { template, z };
  }

  #terrain() {
    return this.#tilted ? { source: MESH + this.#mark, exaggeration: this.#exaggeration } : undefined;
  }

  #adapt(style: StyleSpecification): StyleSpecification {
    this.#mark = `-${++this.#renewals}`;
    return adapt(style, this.#mark, this.#overlays);
  }

  #complete(): StyleSpecification {
    const terrain = this.#terrain();
    const { sources, layers } = this.#extra;
    const style = { ...this.#style, sources: { ...this.#style.sources, ...sources }, layers: [...this.#style.layers, ...layers] };
    return terrain ? { ...style, terrain } : style;
  }

  #opening(style: StyleSpecification, camera?: Camera) {
    const [lon, lat] = style.center ?? [0, 0];
    const at = camera ?? { lon: lon ?? 0, lat: lat ?? 0, zoom: style.zoom ?? 0, bearing: 0, pitch: this.#tilted ? PITCH : 0 };
    return { center: [at.lon, at.lat] as [number, number], zoom: at.zoom, bearing: at.bearing, pitch: at.pitch };
  }

  /** Flat means flat: gestures tilt the map in 3D only. */
  #allowPitch(): void {
    this.map.setMaxPitch(this.#tilted ? MAX_PITCH : 0);
  }

  #applyTerrain(): void {
    // While a style is being loaded there is none to change; 'style.load' comes back here.
    if (this.map.getStyle()) this.map.setTerrain(this.#terrain() ?? null);
  }
}
