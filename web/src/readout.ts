import { Marker, type MapMouseEvent, type PointLike } from 'maplibre-gl';
import type { TerrainMap } from './map.ts';
import { spacing, toMetres, type LonLat } from './mercator.ts';
import { Sampler } from './sampler.ts';

const fixed = (value: number, digits: number) =>
  value.toLocaleString('en', { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: true })
    .replaceAll(',', '\u2009')
    .replace('-', '\u2212');

const METRES_A_DEGREE = 111319.49079327358;

/** As many digits as it takes to tell apart what lies `step` apart. */
const digitsFor = (step: number, most: number) => Math.min(most, Math.max(0, Math.ceil(-Math.log10(step))));

/**
 * Elevation and coordinates of the place under the pointer, of the place tapped, or, when there is no pointer
 * over the map, of the middle of the view: so that it serves the keyboard too.
 */
export class Readout {
  readonly #sampler = new Sampler();
  readonly #marker: Marker;
  /** Where the pointer is, in pixels of the map. */
  #pointer: PointLike | undefined;
  #tapped: LonLat | undefined;
  /** A touch is followed by emulated mouse events, which are not to be taken for a pointer over the map. */
  #touching = false;
  #scheduled = false;
  #asked = 0;

  constructor(
    readonly element: HTMLElement,
    readonly terrain: TerrainMap,
  ) {
    const dot = document.createElement('div');
    dot.className = 'tap';
    this.#marker = new Marker({ element: dot });
    const map = terrain.map;
    for (const type of ['pointerdown', 'pointermove'] as const) {
      const note = (event: PointerEvent) => (this.#touching = event.pointerType === 'touch');
      map.getContainer().addEventListener(type, note, { capture: true, passive: true });
    }
    map.on('mousemove', (event) => this.#point(event));
    map.on('mouseout', () => this.#leave());
    map.on('click', (event) => this.#tap(event));
    for (const event of ['move', 'idle', 'style.load'] as const) map.on(event, () => this.#schedule());
    this.#schedule();
  }

  #point(event: MapMouseEvent): void {
    if (this.#touching) return;
    this.#forgetTap();
    this.#pointer = event.point;
    this.#schedule();
  }

  #leave(): void {
    this.#pointer = undefined;
    this.#schedule();
  }

  #tap(event: MapMouseEvent): void {
    if (!this.#touching) return;
    this.#pointer = undefined;
    this.#tapped = { lon: event.lngLat.lng, lat: event.lngLat.lat };
    this.#marker.setLngLat(event.lngLat).addTo(this.terrain.map);
    this.#schedule();
  }

  #forgetTap(): void {
    this.#tapped = undefined;
    this.#marker.remove();
  }

  /** At most once a frame. */
  #schedule(): void {
    if (this.#scheduled) return;
    this.#scheduled = true;
    requestAnimationFrame(() => {
      this.#scheduled = false;
      void this.#update();
    });
  }

  async #update(): Promise<void> {
    const [place, where] = this.#place();
    const tile = this.terrain.tileAt(place);
    if (!tile) return;
    const asked = ++this.#asked;
    const metres = toMetres(place);
    let elevation: number | undefined;
    try {
      elevation = await this.#sampler.sample(tile.template, tile.z, metres);
    } catch {
      elevation = undefined; // the map's own error handling says why
    }
    // An answer that was overtaken by a newer question is not shown.
    if (asked === this.#asked) this.#show(where, place, tile.z, elevation);
  }

  #place(): [LonLat, string] {
    const map = this.terrain.map;
    if (this.#tapped) return [this.#tapped, 'tap'];
    if (!this.#pointer) return [{ lon: map.getCenter().lng, lat: map.getCenter().lat }, 'centre'];
    const { lng, lat } = map.unproject(this.#pointer);
    return [{ lon: lng, lat }, 'pointer'];
  }

  #show(where: string, place: LonLat, z: number, elevation: number | undefined): void {
    const { x, y } = toMetres(place);
    const step = spacing(z);
    const set = (name: string, text: string) => {
      const part = this.element.querySelector(`[data-part="${name}"]`);
      if (part && part.textContent !== text) part.textContent = text;
    };
    const degrees = (value: number) => `${value.toFixed(digitsFor(step / METRES_A_DEGREE, 9))}°`.replace('-', '\u2212');
    set('where', { tap: 'at the mark', centre: 'in the middle', pointer: 'at the pointer' }[where] ?? '');
    set('elevation', elevation === undefined ? '\u2013' : fixed(elevation, digitsFor(step / 10, 2)));
    set('lonlat', `${degrees(place.lon)}, ${degrees(place.lat)}`);
    set('metres', `${fixed(x, digitsFor(step, 3))}, ${fixed(y, digitsFor(step, 3))} m`);
    this.element.hidden = false;
    const data = this.element.dataset;
    data['where'] = where;
    data['elevation'] = elevation === undefined ? '' : String(elevation);
    Object.assign(data, { x: String(x), y: String(y), zoom: String(z), spacing: String(step) });
  }
}
