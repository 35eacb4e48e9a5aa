/** Terrarium: elevation in metres as three bytes, in steps of 1/256 m. */

export function decode(red: number, green: number, blue: number): number {
  return red * 256 + green + blue / 256 - 32768;
}

/** Decodes RGBA pixels, row by row. */
export function decodePixels(rgba: ArrayLike<number>): Float32Array {
  const elevations = new Float32Array(rgba.length / 4);
  for (let i = 0; i < elevations.length; i++) {
    elevations[i] = decode(rgba[4 * i] ?? 0, rgba[4 * i + 1] ?? 0, rgba[4 * i + 2] ?? 0);
  }
  return elevations;
}

export type Four = readonly [northWest: number, northEast: number, southWest: number, southEast: number];

export function bilinear([nw, ne, sw, se]: Four, east: number, south: number): number {
  const north = nw + (ne - nw) * east;
  return north + (sw + (se - sw) * east - north) * south;
}
