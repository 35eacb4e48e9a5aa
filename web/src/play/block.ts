import { CELLS, VERTICES, heightIn, parentOf, sideOf, type Address } from './grid.ts';

/** Texels of a layer's side: the vertices and one beyond every edge, for the normals there. */
export const TEXELS = VERTICES + 2;
/** Numbers of a layer: per texel the height before and its parent's, the height now and its parent's. */
export const LAYER = TEXELS * TEXELS * 4;

/** Heights, and the least and the greatest of them. */
export interface Measured {
  heights: Float32Array;
  low: number;
  high: number;
}

export function measured(heights: Float32Array): Measured {
  let [low, high] = [Infinity, -Infinity];
  for (const height of heights) {
    if (height < low) low = height;
    if (height > high) high = height;
  }
  return { heights, low, high };
}

/** A square of ground: its heights before and after the newest change, and its place in the texture. */
export class Block {
  #now: Measured;
  #before: Measured;
  /** Heights of the next revision once they are known, those of now where nothing changes. */
  next: Measured | undefined;
  nextTag = '';
  /** Last frame in which it was needed. */
  used = 0;

  constructor(
    readonly address: Address,
    heights: Float32Array,
    public tag: string,
    readonly layer: number,
    readonly parent: Block | undefined,
  ) {
    this.#now = this.#before = measured(heights);
  }

  get side(): number {
    return sideOf(this.address.z);
  }

  /** Heights of the revision that is shown. */
  get now(): Float32Array {
    return this.#now.heights;
  }

  /** Heights of the revision from which the ground moves to this one. */
  get before(): Float32Array {
    return this.#before.heights;
  }

  /** Least and greatest height, before and now. */
  get low(): number {
    return Math.min(this.#now.low, this.#before.low);
  }

  get high(): number {
    return Math.max(this.#now.high, this.#before.high);
  }

  get moves(): boolean {
    return this.#before !== this.#now;
  }

  /** The next heights are known: others, or those of now. */
  expect(heights: Float32Array | undefined, tag: string): void {
    this.next = heights ? measured(heights) : this.#now;
    this.nextTag = tag;
  }

  /** What is now becomes what was before; what is next, if it is known, is now. */
  turn(): void {
    this.#before = this.#now;
    if (!this.next) return;
    this.#now = this.next;
    this.tag = this.nextTag;
    this.next = undefined;
  }

  /** It has arrived. */
  settle(): void {
    this.#before = this.#now;
  }

  /** The height at a place of the block while `share` of the way from before to now is done. */
  height(east: number, south: number, share: number): number {
    const { x, y } = this.address;
    const spacing = this.side / CELLS;
    const [column, row] = [(east - x * this.side) / spacing, (south - y * this.side) / spacing];
    const now = heightIn(this.now, column, row);
    return this.moves ? now * share + heightIn(this.before, column, row) * (1 - share) : now;
  }
}

/** Which heights of a block: those before the change or those now. */
export type Time = 'before' | 'now';

/** Finds the block of an address, if it is there. */
export type Neighbours = (address: Address) => Block | undefined;

/** Writes one vertex's height and, of half as many vertices, its parent's. */
function put(layer: Float32Array, column: number, row: number, channel: number, height: number, coarse: number): void {
  const at = 4 * ((row + 1) * TEXELS + column + 1) + channel;
  layer[at] = height;
  layer[at + 1] = coarse;
}

/** A height beyond an edge: the neighbour's where it is there, or the ground goes on as steep as it ends. */
function beyond(block: Block, time: Time, column: number, row: number, find: Neighbours): number {
  const [dx, dy] = [column < 0 ? -1 : column > CELLS ? 1 : 0, row < 0 ? -1 : row > CELLS ? 1 : 0];
  const { z, x, y } = block.address;
  const other = find({ z, x: x + dx, y: y + dy });
  if (!other) return heightIn(block[time], column, row);
  return other[time][(row - dy * CELLS) * VERTICES + column - dx * CELLS] ?? 0;
}

/** Fills the two channels of a time in a block's layer of the texture. */
export function fill(layer: Float32Array, block: Block, time: Time, find: Neighbours): void {
  const channel = time === 'before' ? 0 : 2;
  const heights = block[time];
  const parent = block.parent?.[time];
  const { x, y } = block.address;
  const above = parentOf(block.address);
  const [left, top] = [(x - 2 * above.x) * (CELLS / 2), (y - 2 * above.y) * (CELLS / 2)];
  for (let row = -1; row <= VERTICES; row++) {
    const outside = row < 0 || row > CELLS;
    for (let column = -1; column <= VERTICES; column++) {
      const inside = !outside && column >= 0 && column <= CELLS;
      const height = inside ? (heights[row * VERTICES + column] ?? 0) : beyond(block, time, column, row, find);
      put(layer, column, row, channel, height, parent ? heightIn(parent, left + column / 2, top + row / 2) : height);
    }
  }
}
