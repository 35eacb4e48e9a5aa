/** The part of the address after `#`: which world is shown, from where and how. */

export interface Camera {
  lon: number;
  lat: number;
  zoom: number;
  bearing: number;
  pitch: number;
}

/** What can be laid over the terrain: the names of the sources in the server's style. */
export const OVERLAYS = ['contours', 'features'] as const;
export type Overlay = (typeof OVERLAYS)[number];

export interface Link {
  world?: string | undefined;
  camera?: Camera | undefined;
  tilted: boolean;
  exaggeration: number;
  overlays?: Overlay[] | undefined;
}

export const EXAGGERATION = { min: 0.5, max: 5, default: 1.5 };

const clamp = (value: number, min: number, max: number) => Math.min(max, Math.max(min, value));

function number(text: string | null | undefined): number | undefined {
  if (text === null || text === undefined || text.trim() === '') return undefined;
  const value = Number(text);
  return Number.isFinite(value) ? value : undefined;
}

/** Reads what is there and forgives the rest: a mangled link still opens something. */
export function parseLink(hash: string): Link {
  const part = new URLSearchParams(hash.replace(/^#/, ''));
  const link: Link = {
    tilted: part.get('view') === '3d',
    exaggeration: clamp(number(part.get('height')) ?? EXAGGERATION.default, EXAGGERATION.min, EXAGGERATION.max),
  };
  const shown = part.get('show')?.split(',') ?? [];
  link.overlays = OVERLAYS.filter((overlay) => shown.includes(overlay));
  const world = part.get('world');
  if (world && /^[a-z0-9][a-z0-9-]{0,62}$/.test(world)) link.world = world;
  const [lon, lat] = (part.get('at') ?? '').split(',').map(number);
  const zoom = number(part.get('zoom'));
  if (lon !== undefined && lat !== undefined && zoom !== undefined) {
    link.camera = {
      lon: clamp(lon, -180, 180),
      lat: clamp(lat, -85.051129, 85.051129),
      zoom: clamp(zoom, 0, 24),
      bearing: number(part.get('bearing')) ?? 0,
      pitch: link.tilted ? clamp(number(part.get('pitch')) ?? 60, 0, 80) : 0,
    };
  }
  return link;
}

const round = (value: number, digits: number) => String(Number(value.toFixed(digits)));

/** As short as the zoom allows: a tenth of a pixel is kept. */
export function formatLink(link: Link): string {
  const part: string[] = [];
  if (link.world) part.push(`world=${link.world}`);
  const camera = link.camera;
  if (camera) {
    const digits = Math.ceil(Math.log10((10 * 512 * 2 ** camera.zoom) / 360));
    part.push(`at=${round(camera.lon, Math.max(2, digits))},${round(camera.lat, Math.max(2, digits))}`);
    part.push(`zoom=${round(camera.zoom, 3)}`);
    if (round(camera.bearing, 1) !== '0') part.push(`bearing=${round(camera.bearing, 1)}`);
  }
  if (link.tilted) {
    if (camera) part.push(`pitch=${round(camera.pitch, 1)}`);
    part.push('view=3d');
    if (link.exaggeration !== EXAGGERATION.default) part.push(`height=${round(link.exaggeration, 2)}`);
  }
  if (link.overlays?.length) part.push(`show=${link.overlays.join(',')}`);
  return `#${part.join('&')}`;
}
