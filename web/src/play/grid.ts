/** The `metric` grid as the game uses it: metres east and south of the plane's origin, blocks of 64 × 64 cells with both edges. */

/** Vertices of a block's side, and cells. */
export const VERTICES = 65;
export const CELLS = VERTICES - 1;
/** Levels of the largest blocks (16,384 m) and the smallest (32 m, vertices half a metre apart). */
export const COARSEST = 11;
export const FINEST = 20;

/** Metres east and south. */
export interface Place {
  east: number;
  south: number;
}

export interface Address {
  z: number;
  x: number;
  y: number;
}

/** A rectangle of the plane as the server writes it: least x and y, greatest x and y, y to the north. */
export type Rectangle = readonly [west: number, south: number, east: number, north: number];

export const sideOf = (z: number): number => 2 ** (25 - z);

export const keyOf = ({ z, x, y }: Address): string => `${z}/${x}/${y}`;

/** The block of a level that a place lies in. */
export function blockAt({ east, south }: Place, z: number): Address {
  const side = sideOf(z);
  return { z, x: Math.floor(east / side), y: Math.floor(south / side) };
}

export const parentOf = ({ z, x, y }: Address): Address => ({ z: z - 1, x: Math.floor(x / 2), y: Math.floor(y / 2) });

/** Metres from a place to the nearest point of a block, along the plane. */
export function distanceTo({ z, x, y }: Address, { east, south }: Place): number {
  const side = sideOf(z);
  const beyond = (at: number, from: number) => Math.max(from - at, at - from - side, 0);
  return Math.hypot(beyond(east, x * side), beyond(south, y * side));
}

/** Whether what changed within a rectangle can be seen in a block: its samples are filtered over some of their spacings. */
export function meets({ z, x, y }: Address, [west, south, east, north]: Rectangle): boolean {
  const side = sideOf(z);
  const margin = side / 4;
  return (
    x * side - margin <= east && (x + 1) * side + margin >= west && -(y + 1) * side - margin <= north && -y * side + margin >= south
  );
}

/** The rectangle around two. */
export function union(a: Rectangle, b: Rectangle): Rectangle {
  return [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[2], b[2]), Math.max(a[3], b[3])];
}

/**
 * A height between vertices, as the triangles show it: every cell is cut from north-east to south-west. `row` and
 * `column` may lie beyond the edges; the ground then goes on as steep as it ends.
 */
export function heightIn(heights: ArrayLike<number>, column: number, row: number): number {
  const i = Math.min(CELLS - 1, Math.max(0, Math.floor(column)));
  const j = Math.min(CELLS - 1, Math.max(0, Math.floor(row)));
  const [u, v] = [column - i, row - j];
  const at = j * VERTICES + i;
  const northEast = heights[at + 1] ?? 0;
  const southWest = heights[at + VERTICES] ?? 0;
  if (u + v <= 1) {
    const northWest = heights[at] ?? 0;
    return northWest + u * (northEast - northWest) + v * (southWest - northWest);
  }
  const southEast = heights[at + VERTICES + 1] ?? 0;
  return southEast + (1 - u) * (southWest - southEast) + (1 - v) * (northEast - southEast);
}
