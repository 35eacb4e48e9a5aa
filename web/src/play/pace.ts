/** How much is drawn, so that pictures come in time: fewer pixels first, coarser ground then. */

/** Slower pictures than this (milliseconds, mean of many) ask for less, quicker ones for more. */
const SLOW_MS = 26;
const QUICK_MS = 18;
const PICTURES = 24;
/** Where pictures are very slow, fewer of them tell. */
const ENOUGH_MS = 1200;
const LEAST_PIXELS = 0.55;
/** Below it neighbours may be two levels apart, which shows. */
const LEAST_REFINEMENT = 1.45;
/** Rounds without slow pictures before more is tried. */
const PATIENCE = 8;

export class Pace {
  #sum = 0;
  #count = 0;
  #quick = 0;
  /** Share of the screen's pixels a side. */
  pixels = 1;
  refinement: number;

  constructor(readonly most: number) {
    this.refinement = most;
  }

  /** Takes the time between two pictures, both drawn in a row. */
  tell(milliseconds: number): void {
    this.#sum += Math.min(milliseconds, 250);
    if (++this.#count < PICTURES && this.#sum < ENOUGH_MS) return;
    const mean = this.#sum / this.#count;
    this.#sum = this.#count = 0;
    this.#quick = mean < QUICK_MS ? this.#quick + 1 : 0;
    if (mean > SLOW_MS) this.#less(Math.max(0.6, Math.min(0.85, SLOW_MS / mean)));
    else if (this.#quick >= PATIENCE) this.#more();
  }

  #less(by: number): void {
    if (this.pixels > LEAST_PIXELS) this.pixels = Math.max(LEAST_PIXELS, this.pixels * by);
    else this.refinement = Math.max(LEAST_REFINEMENT, this.refinement - 0.15);
  }

  #more(): void {
    this.#quick = 0;
    if (this.refinement < this.most) this.refinement = Math.min(this.most, this.refinement + 0.15);
    else this.pixels = Math.min(1, this.pixels * 1.1);
  }
}
