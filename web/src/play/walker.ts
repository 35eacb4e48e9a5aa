import type { Place } from './grid.ts';

/** How somebody moves through the world, in metres, seconds and radians. Knows no page and no server. */

/** Height of the eyes above the ground. */
export const EYES = 1.7;
const WALK = 7;
const RUN = 18;
const GRAVITY = 20;
/** Falls end at this speed. */
const TERMINAL = 60;
/** Least speed of flight, and what is added for every metre above the ground. */
const FLIGHT = 22;
const FLIGHT_BY_HEIGHT = 0.7;
const FAST = 4;
/** Flight keeps this far above the ground, and this far below the ceiling. */
const CLEARANCE = 2;
const CEILING = 20_000;
/** Steeper than this (rise over run) nobody walks up. */
const STEEPEST = 1.6;
const PITCH_LIMIT = 1.5;
/** How fast speed follows what is wished, per second. */
const RESPONSE = 9;

/** What the keys, the mouse or the thumbs ask for; the first three are -1 … 1. */
export interface Wish {
  forward: number;
  right: number;
  up: number;
  fast: boolean;
}

export interface Ground {
  /** Metres above the datum where one can stand: the ground, or the water above it. */
  at(place: Place): number | undefined;
}

export class Walker {
  place: Place = { east: 0, south: 0 };
  /** Elevation of the eyes. */
  eye = 0;
  /** Clockwise from the north, and up from the horizon. */
  heading = 0;
  pitch = 0;
  flying = false;
  #falling = 0;
  #velocity = { east: 0, south: 0, up: 0 };

  turn(heading: number, pitch: number): void {
    this.heading = (this.heading + heading) % (2 * Math.PI);
    this.pitch = Math.min(PITCH_LIMIT, Math.max(-PITCH_LIMIT, this.pitch + pitch));
  }

  /** The unit vector of the view: east, south and up. */
  get direction(): { east: number; south: number; up: number } {
    const level = Math.cos(this.pitch);
    return { east: Math.sin(this.heading) * level, south: -Math.cos(this.heading) * level, up: Math.sin(this.pitch) };
  }

  get speed(): number {
    return Math.hypot(this.#velocity.east, this.#velocity.south, this.#velocity.up);
  }

  /** Moves on by some seconds; without ground below, nowhere. */
  step(wish: Wish, seconds: number, ground: Ground): void {
    const below = ground.at(this.place);
    if (below === undefined) return;
    this.#follow(wish, seconds, this.eye - below);
    const { east, south, up } = this.#velocity;
    const to = { east: this.place.east + east * seconds, south: this.place.south + south * seconds };
    const there = ground.at(to);
    if (there === undefined) return;
    if (this.flying) {
      this.place = to;
      this.eye = Math.min(CEILING, Math.max(there + CLEARANCE, this.eye + up * seconds));
      return;
    }
    this.#walk(to, below, there, seconds);
  }

  /** Slowly towards the speed that is wished. */
  #follow(wish: Wish, seconds: number, height: number): void {
    const length = Math.max(1, Math.hypot(wish.forward, wish.right));
    const [forward, right] = [wish.forward / length, wish.right / length];
    const speed = this.flying ? (FLIGHT + FLIGHT_BY_HEIGHT * Math.max(0, height)) * (wish.fast ? FAST : 1) : wish.fast ? RUN : WALK;
    const [sin, cos] = [Math.sin(this.heading), Math.cos(this.heading)];
    const level = this.flying ? Math.cos(this.pitch) : 1;
    const wanted = {
      east: (forward * level * sin + right * cos) * speed,
      south: (-forward * level * cos + right * sin) * speed,
      up: this.flying ? (forward * Math.sin(this.pitch) + wish.up) * speed : 0,
    };
    const share = 1 - Math.exp(-RESPONSE * seconds);
    for (const axis of ['east', 'south', 'up'] as const) this.#velocity[axis] += (wanted[axis] - this.#velocity[axis]) * share;
  }

  /** On foot: slopes slow, what is too steep stops, and nothing holds one in the air. */
  #walk(to: Place, below: number, there: number, seconds: number): void {
    const run = Math.hypot(to.east - this.place.east, to.south - this.place.south);
    const rise = run > 0 ? (there - below) / run : 0;
    const pace = rise > STEEPEST ? 0 : 1 / (1 + Math.max(0, rise) * 1.5 + Math.max(0, -rise - 0.5) * 0.5);
    this.place = {
      east: this.place.east + (to.east - this.place.east) * pace,
      south: this.place.south + (to.south - this.place.south) * pace,
    };
    const stand = below + (there - below) * pace + EYES;
    this.#falling = Math.min(TERMINAL, this.#falling + GRAVITY * seconds);
    const fallen = this.eye - this.#falling * seconds;
    if (fallen > stand) {
      this.eye = fallen;
      return;
    }
    this.#falling = 0;
    this.eye = stand;
  }

  /** Down to the ground, or up from it. */
  fly(flying: boolean): void {
    this.flying = flying;
    this.#falling = 0;
    if (flying) this.eye += 6;
  }
}
