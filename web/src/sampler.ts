import { authorization } from './key.ts';
import { Lru } from './lru.ts';
import { TILE_SIZE, address, around, type Metres, type Sample } from './mercator.ts';
import { bilinear, decodePixels } from './terrarium.ts';

/** Elevations read from the very tiles that the map shows. */

/** A decoded tile is 1 MiB. */
const TILES_KEPT = 24;

async function fetchTile(url: string): Promise<Float32Array> {
  // The same Accept as MapLibre's, or a cache that varies by it would fetch the tile a second time.
  const response = await fetch(url, { headers: { accept: 'image/webp,*/*', ...authorization() } });
  if (!response.ok) throw new Error(`${response.status} ${url}`);
  const image = await createImageBitmap(await response.blob(), {
    colorSpaceConversion: 'none',
    premultiplyAlpha: 'none',
  });
  if (image.width !== TILE_SIZE || image.height !== TILE_SIZE) throw new Error(`not ${TILE_SIZE} px: ${url}`);
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = TILE_SIZE;
  const context = canvas.getContext('2d', { willReadFrequently: true });
  if (!context) throw new Error('no 2D canvas');
  context.drawImage(image, 0, 0);
  image.close();
  return decodePixels(context.getImageData(0, 0, TILE_SIZE, TILE_SIZE).data);
}

export class Sampler {
  readonly #tiles = new Lru<Promise<Float32Array>>(TILES_KEPT);

  /** The elevation at a point as tiles of level `z` show it: bilinear between the four pixel centres around it. */
  async sample(template: string, z: number, point: Metres): Promise<number> {
    const { corner, east, south } = around(point, z);
    const read = (column: number, row: number) => this.#read(template, z, { column, row });
    const { column, row } = corner;
    const four = await Promise.all([
      read(column, row),
      read(column + 1, row),
      read(column, row + 1),
      read(column + 1, row + 1),
    ]);
    return bilinear(four, east, south);
  }

  async #read(template: string, z: number, sample: Sample): Promise<number> {
    const { x, y, index } = address(sample);
    const url = template.replace('{z}', String(z)).replace('{x}', String(x)).replace('{y}', String(y));
    const elevation = (await this.#tile(url))[index];
    if (elevation === undefined) throw new Error(`no sample ${index} in ${url}`);
    return elevation;
  }

  #tile(url: string): Promise<Float32Array> {
    const known = this.#tiles.get(url);
    if (known) return known;
    const tile = fetchTile(url);
    this.#tiles.set(url, tile);
    // A failure is not remembered: the next look asks again.
    tile.catch(() => this.#tiles.delete(url));
    return tile;
  }
}
