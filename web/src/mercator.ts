/** The plane is Web Mercator's: metres east and north of longitude 0, latitude 0. */

const RADIUS = 6378137;
/** Half the side of tile 0/0/0, in metres. */
export const HALF = Math.PI * RADIUS;
/** Samples a tile side. */
export const TILE_SIZE = 512;

export interface LonLat {
  lon: number;
  lat: number;
}

export interface Metres {
  x: number;
  y: number;
}

const radians = (degrees: number) => (degrees * Math.PI) / 180;
const degrees = (angle: number) => (angle * 180) / Math.PI;

export function toMetres({ lon, lat }: LonLat): Metres {
  return { x: RADIUS * radians(lon), y: RADIUS * Math.asinh(Math.tan(radians(lat))) };
}

export function toLonLat({ x, y }: Metres): LonLat {
  return { lon: degrees(x / RADIUS), lat: degrees(Math.atan(Math.sinh(y / RADIUS))) };
}

/** Metres between neighbouring samples of a tile of level `z`. */
export function spacing(z: number): number {
  return (2 * HALF) / TILE_SIZE / 2 ** z;
}

/** A sample, counted over the whole level: eastward and southward from the north-west corner of tile 0/0. */
export interface Sample {
  column: number;
  row: number;
}

export interface Neighbourhood {
  /** The north-west one of the four samples around the point. */
  corner: Sample;
  /** How far the point lies towards the east and towards the south, 0 … 1. */
  east: number;
  south: number;
}

/** The four samples around a point. Samples stand at pixel centres, hence the half. */
export function around({ x, y }: Metres, z: number): Neighbourhood {
  const column = (x + HALF) / spacing(z) - 0.5;
  const row = (HALF - y) / spacing(z) - 0.5;
  const corner = { column: Math.floor(column), row: Math.floor(row) };
  return { corner, east: column - corner.column, south: row - corner.row };
}

export interface Address {
  x: number;
  y: number;
  /** Index of the sample inside its tile, row by row. */
  index: number;
}

/** Where a sample is stored. Tiles outside the level's own range have negative or larger indices. */
export function address({ column, row }: Sample): Address {
  const x = Math.floor(column / TILE_SIZE);
  const y = Math.floor(row / TILE_SIZE);
  return { x, y, index: (row - y * TILE_SIZE) * TILE_SIZE + (column - x * TILE_SIZE) };
}
