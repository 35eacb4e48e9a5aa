import { find } from './page.ts';
import type { Place } from './grid.ts';
import type { View } from './view.ts';
import { EYES, type Walker } from './walker.ts';

/** Further away nobody is pointed at. */
const REACH = 4000;

/** Pins over the heads of those who walk here, too. The figure of how many they are is said elsewhere. */
export class Others {
  readonly #layer = find('#others');
  readonly #pins = new Map<string, HTMLElement>();

  /** Puts the pins where the others are in this picture. */
  show(others: readonly { name: string; place: Place }[], view: View, { place, eye }: Walker, height: (place: Place) => number | undefined): void {
    for (const name of this.#pins.keys()) if (!others.some((other) => other.name === name)) this.#drop(name);
    for (const other of others) {
      const pin = this.#pin(other.name);
      const far = Math.hypot(other.place.east - place.east, other.place.south - place.south);
      const ground = height(other.place);
      const at = far > REACH || ground === undefined ? undefined : view.point(place, other.place, ground + EYES + 0.6 - eye);
      pin.hidden = !at;
      if (!at) continue;
      pin.style.left = `${100 * at[0]}%`;
      pin.style.top = `${100 * at[1]}%`;
      pin.textContent = far < 1000 ? `${other.name}, ${far.toFixed(0)} m` : `${other.name}, ${(far / 1000).toFixed(1)} km`;
    }
  }

  #pin(name: string): HTMLElement {
    const known = this.#pins.get(name);
    if (known) return known;
    const pin = document.createElement('span');
    pin.className = 'pin';
    this.#pins.set(name, pin);
    this.#layer.append(pin);
    return pin;
  }

  #drop(name: string): void {
    this.#pins.get(name)?.remove();
    this.#pins.delete(name);
  }
}
