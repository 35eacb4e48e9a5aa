import { authorization } from '../key.ts';
import { CELLS, VERTICES, keyOf, type Address } from './grid.ts';

/** What the server answered to a question for a block's heights. */
export interface Heights {
  /** Undefined where they are those of the tag that was sent along. */
  heights: Float32Array<ArrayBuffer> | undefined;
  tag: string;
}

/** Questions at a time: browsers let six through to a server of HTTP/1.1, and one is for its events. */
export const AT_ONCE = 5;
const BUSY = [429, 503];
const BUSY_WAIT_MS = 1000;

/** Reads blocks of one world: each revision's from its own address, where they never change. */
export class Loader {
  #open = 0;
  #pausedUntil = 0;
  readonly #asked = new Set<string>();

  constructor(
    readonly world: string,
    readonly failed: (error: Error) => void,
  ) {}

  /** Whether another question may be asked now. */
  get free(): boolean {
    return this.#open < AT_ONCE && performance.now() >= this.#pausedUntil;
  }

  get idle(): boolean {
    return this.#open === 0;
  }

  asks(revision: string, address: Address): boolean {
    return this.#asked.has(`${revision}/${keyOf(address)}`);
  }

  /** Asks for the heights of a block, or whether they are still those of `tag`, and hands over the answer, or nothing when there was none. */
  async ask(revision: string, address: Address, tag: string, take: (answer: Heights | undefined) => void): Promise<void> {
    const key = `${revision}/${keyOf(address)}`;
    this.#asked.add(key);
    this.#open++;
    try {
      take(await this.#read(revision, address, tag));
    } catch (error) {
      this.#pausedUntil = performance.now() + BUSY_WAIT_MS;
      this.failed(error instanceof Error ? error : new Error(String(error)));
      take(undefined);
    } finally {
      this.#open--;
      this.#asked.delete(key);
    }
  }

  async #read(revision: string, { z, x, y }: Address, tag: string): Promise<Heights | undefined> {
    const url = `worlds/${this.world}@${revision}/metric/r32/${z}/${x}/${y}@${VERTICES}.bin`;
    const condition: Record<string, string> = tag ? { 'If-None-Match': tag } : {};
    const response = await fetch(url, { headers: { ...condition, ...authorization() } });
    if (response.status === 304) {
      await response.arrayBuffer(); // nothing, but browsers call an answer cancelled that nobody has read
      return { heights: undefined, tag };
    }
    if (BUSY.includes(response.status)) {
      this.#pausedUntil = performance.now() + BUSY_WAIT_MS;
      return undefined;
    }
    if (!response.ok) throw new Error(`Parts of the ground could not be loaded (${response.status}).`);
    const bytes = await response.arrayBuffer();
    if (bytes.byteLength !== 4 * (CELLS + 1) ** 2) throw new Error(`${url} has ${bytes.byteLength} bytes`);
    // Samples are little-endian, as every machine with a browser is.
    return { heights: new Float32Array(bytes), tag: response.headers.get('ETag') ?? '' };
  }
}
