import type { Place } from './grid.ts';

/** Where a look meets the ground. */

const REACH = 6000;
const FIRST_STEP = 0.5;
const HALVINGS = 18;

export interface Direction {
  east: number;
  south: number;
  up: number;
}

/** The first place on a ray whose ground is above the ray, within reach. */
export function meet(from: Place, eye: number, to: Direction, ground: (place: Place) => number | undefined): Place | undefined {
  const at = (far: number): Place => ({ east: from.east + to.east * far, south: from.south + to.south * far });
  const below = (far: number) => eye + to.up * far < (ground(at(far)) ?? -Infinity);
  let [near, far] = [0, FIRST_STEP];
  while (!below(far)) {
    if (far > REACH) return undefined;
    near = far;
    far += Math.max(FIRST_STEP, far * 0.015);
  }
  for (let i = 0; i < HALVINGS; i++) {
    const middle = (near + far) / 2;
    if (below(middle)) far = middle;
    else near = middle;
  }
  return at(far);
}
