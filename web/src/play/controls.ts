import type { Wish } from './walker.ts';

/** What hands do: keys, mouse and thumbs become a wish to move, turns of the head and deeds. */

export type Deed = 'shape' | 'fly' | 'help' | 'map' | 'ahead' | 'lock';

export interface Doings {
  turn(heading: number, pitch: number): void;
  /** Something is to be done; at a point of the picture (0 … 1 from its left and top), or at its middle. */
  deed(deed: Deed, at?: readonly [number, number]): void;
}

/** Which way a key moves; what they do to `Wish` and to the head. */
const MOVES: Record<string, Partial<Record<'forward' | 'right' | 'up' | 'heading' | 'pitch', number>>> = {
  KeyW: { forward: 1 },
  KeyS: { forward: -1 },
  KeyA: { right: -1 },
  KeyD: { right: 1 },
  ArrowUp: { forward: 1 },
  ArrowDown: { forward: -1 },
  ArrowLeft: { heading: -1 },
  ArrowRight: { heading: 1 },
  KeyQ: { heading: -1 },
  KeyE: { heading: 1 },
  PageUp: { pitch: 1 },
  PageDown: { pitch: -1 },
  KeyR: { up: 1 },
  KeyC: { up: -1 },
};

const DEEDS: Record<string, Deed> = { Space: 'shape', Enter: 'shape', KeyF: 'fly', KeyH: 'help', KeyM: 'map', KeyG: 'ahead', KeyL: 'lock' };

/** Radians a second by keys, a pixel by mouse and thumb. */
const TURN = 1.6;
const LOOK = 0.0042;
const LOCKED_LOOK = 0.0022;
/** A press that moves less than this many pixels is a click. */
const CLICK = 6;
/** Pixels that a thumb moves for full speed. */
const STICK = 56;

interface Press {
  start: readonly [number, number];
  last: readonly [number, number];
  role: 'look' | 'move';
  moved: boolean;
}

const typing = (target: EventTarget | null) =>
  target instanceof Element && target.closest('input, select, textarea, dialog, summary, button, a[href]') !== null;

export class Controls {
  readonly #held = new Set<string>();
  readonly #presses = new Map<number, Press>();
  #fast = false;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly stick: HTMLElement,
    readonly doings: Doings,
  ) {
    document.addEventListener('keydown', (event) => this.#down(event));
    document.addEventListener('keyup', (event) => this.#up(event));
    window.addEventListener('blur', () => this.release());
    canvas.addEventListener('pointerdown', (event) => this.#press(event));
    canvas.addEventListener('pointermove', (event) => this.#drag(event));
    for (const type of ['pointerup', 'pointercancel'] as const) canvas.addEventListener(type, (event) => this.#lift(event));
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  }

  get locked(): boolean {
    return document.pointerLockElement === this.canvas;
  }

  /** Whether anything is held that moves. */
  get active(): boolean {
    return this.#held.size > 0 || this.#thumb() !== undefined;
  }

  /** Lets go of everything. */
  release(): void {
    this.#held.clear();
    this.#presses.clear();
    this.#fast = false;
    this.stick.hidden = true;
  }

  /** What is wished now; turns the head as far as keys ask for in this time. */
  wish(seconds: number): Wish {
    const sum = { forward: 0, right: 0, up: 0, heading: 0, pitch: 0 };
    for (const key of this.#held) {
      for (const [way, by] of Object.entries(MOVES[key] ?? {}) as [keyof typeof sum, number][]) sum[way] += by;
    }
    const thumb = this.#thumb();
    if (thumb) {
      sum.right += thumb[0];
      sum.forward -= thumb[1];
    }
    if (sum.heading || sum.pitch) this.doings.turn(sum.heading * TURN * seconds, sum.pitch * TURN * 0.7 * seconds);
    const limit = (value: number) => Math.max(-1, Math.min(1, value));
    return { forward: limit(sum.forward), right: limit(sum.right), up: limit(sum.up), fast: this.#fast || (thumb ? Math.hypot(...thumb) > 1.35 : false) };
  }

  /** The left thumb's way, 1 for full speed. */
  #thumb(): [number, number] | undefined {
    for (const { role, start, last } of this.#presses.values()) {
      if (role === 'move') return [(last[0] - start[0]) / STICK, (last[1] - start[1]) / STICK];
    }
    return undefined;
  }

  #down(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const deed = DEEDS[event.code];
    // A focused button takes Enter and Space for itself, a slider the arrows.
    const own = typing(event.target) && (/^(Space|Enter|Arrow|Page)/.test(event.code) || !(event.target instanceof HTMLButtonElement));
    if (own) return;
    this.#fast = event.shiftKey;
    if (MOVES[event.code]) {
      this.#held.add(event.code);
      event.preventDefault();
    } else if (deed && !event.repeat) {
      event.preventDefault();
      this.doings.deed(deed);
    }
  }

  #up(event: KeyboardEvent): void {
    this.#fast = event.shiftKey;
    this.#held.delete(event.code);
  }

  #press(event: PointerEvent): void {
    this.canvas.focus({ preventScroll: true });
    if (this.locked) return;
    const at = [event.clientX, event.clientY] as const;
    const role = event.pointerType === 'touch' && event.clientX < this.canvas.clientWidth / 2 && !this.#thumb() ? 'move' : 'look';
    this.#presses.set(event.pointerId, { start: at, last: at, role, moved: false });
    this.canvas.setPointerCapture(event.pointerId);
  }

  #drag(event: PointerEvent): void {
    if (this.locked) return this.doings.turn(event.movementX * LOCKED_LOOK, -event.movementY * LOCKED_LOOK);
    const press = this.#presses.get(event.pointerId);
    if (!press) return;
    const at = [event.clientX, event.clientY] as const;
    if (Math.hypot(at[0] - press.start[0], at[1] - press.start[1]) > CLICK) press.moved = true;
    // As if one took hold of the picture.
    if (press.role === 'look' && press.moved) this.doings.turn((press.last[0] - at[0]) * LOOK, (at[1] - press.last[1]) * LOOK);
    press.last = at;
    if (press.role === 'move' && press.moved) this.#showStick(press);
  }

  #lift(event: PointerEvent): void {
    if (this.locked) {
      if (event.type === 'pointerup') this.doings.deed('shape');
      return;
    }
    const press = this.#presses.get(event.pointerId);
    this.#presses.delete(event.pointerId);
    if (press?.role === 'move') this.stick.hidden = true;
    if (!press || press.moved || event.type !== 'pointerup' || event.button > 0) return;
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    this.doings.deed('shape', [(event.clientX - left) / width, (event.clientY - top) / height]);
  }

  #showStick({ start, last }: Press): void {
    const [dx, dy] = [last[0] - start[0], last[1] - start[1]];
    const length = Math.max(1, Math.hypot(dx, dy) / STICK);
    this.stick.hidden = false;
    this.stick.style.left = `${start[0]}px`;
    this.stick.style.top = `${start[1]}px`;
    this.stick.style.setProperty('--dx', `${dx / length}px`);
    this.stick.style.setProperty('--dy', `${dy / length}px`);
  }
}
