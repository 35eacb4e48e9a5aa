/** Colours of the land by height, those of the server's relief, as far as the world's vertical range reaches. */

export type Colour = readonly [red: number, green: number, blue: number];

export interface Stop {
  elevation: number;
  /** Linear, 0 … 1. */
  colour: Colour;
}

/** Share of the way from the land's foot to its top, and sRGB. */
const LAND: readonly (readonly [at: number, colour: Colour])[] = [
  [0, [0x5f, 0x8a, 0x5a]],
  [0.12, [0x86, 0xa8, 0x67]],
  [0.3, [0xc2, 0xc1, 0x84]],
  [0.5, [0xb8, 0x9a, 0x6b]],
  [0.7, [0x8f, 0x75, 0x60]],
  [0.86, [0xb7, 0xac, 0xa6]],
  [1, [0xf7, 0xf7, 0xf5]],
];

/** Metres above the sea where the colours end in snow. */
export const SNOW = 2600;
const LEAST_COLOURS = 0.45;

/** How much darker ground is close by than on a map. */
const NEAR = 0.52;

const linear = (byte: number) => (byte / 255) ** 2.2 * NEAR;

function between(at: number): Colour {
  const above = Math.max(1, LAND.findIndex(([place]) => place >= at));
  const [[from, low], [to, high]] = [LAND[above - 1] ?? LAND[0], LAND[above] ?? LAND[0]] as [(typeof LAND)[number], (typeof LAND)[number]];
  const t = Math.min(1, Math.max(0, (at - from) / (to - from)));
  const mix = (i: 0 | 1 | 2) => linear(low[i] + t * (high[i] - low[i]));
  return [mix(0), mix(1), mix(2)];
}

/** Seven stops over the land between the sea and the top of what the relief tells apart. */
export function landStops(sea: number, [low, high]: readonly [number, number]): Stop[] {
  const top = Math.max(low, Math.min(high, sea + SNOW));
  const foot = Math.max(low, sea);
  const height = Math.max(1, top - foot);
  const first = Math.min((foot - sea) / SNOW, 1 - LEAST_COLOURS);
  const used = Math.max(LEAST_COLOURS, Math.min(height / SNOW, 1 - first));
  return LAND.map(([at]) => ({ elevation: foot + height * at, colour: between(first + at * used) }));
}
