import type { IControl } from 'maplibre-gl';
import { EXAGGERATION } from './link.ts';

/** The button between the flat and the tilted view, and the height slider that belongs to the tilted one. */
export class ViewControl implements IControl {
  readonly #group = document.createElement('div');
  readonly #button = document.createElement('button');
  readonly #slider: HTMLInputElement;
  readonly #output: HTMLOutputElement;

  constructor(
    readonly height: HTMLElement,
    readonly change: (view: { tilted?: boolean; exaggeration?: number }) => void,
  ) {
    this.#group.className = 'maplibregl-ctrl maplibregl-ctrl-group';
    this.#button.type = 'button';
    this.#button.id = 'tilt';
    this.#button.textContent = '3D';
    this.#button.setAttribute('aria-label', '3D view');
    this.#button.setAttribute('aria-keyshortcuts', 't');
    this.#button.title = '3D view (T)';
    this.#button.addEventListener('click', () => this.toggle());
    this.#group.append(this.#button);
    this.#slider = height.querySelector('input') as HTMLInputElement;
    this.#output = height.querySelector('output') as HTMLOutputElement;
    this.#slider.min = String(EXAGGERATION.min);
    this.#slider.max = String(EXAGGERATION.max);
    this.#slider.addEventListener('input', () => {
      this.#label();
      this.change({ exaggeration: Number(this.#slider.value) });
    });
  }

  onAdd(): HTMLElement {
    return this.#group;
  }

  onRemove(): void {
    this.#group.remove();
  }

  toggle(): void {
    this.change({ tilted: this.#button.getAttribute('aria-pressed') !== 'true' });
  }

  show(tilted: boolean, exaggeration: number): void {
    this.#button.setAttribute('aria-pressed', String(tilted));
    this.height.hidden = !tilted;
    this.#slider.value = String(exaggeration);
    this.#label();
  }

  #label(): void {
    this.#output.textContent = `× ${Number(this.#slider.value).toFixed(1)}`;
  }
}
