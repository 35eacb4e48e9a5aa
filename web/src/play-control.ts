import type { IControl } from 'maplibre-gl';

/** Somebody who walks. */
const ICON = '<svg viewBox="0 0 20 20" aria-hidden="true"><circle cx="11" cy="3.2" r="1.7"/><path d="M10.5 7 9 12l3 2.5 1 4M9 12l-1.5 3L5 17.5M6 10l1.5-3 3-.5 2 2.5 2.5 1"/></svg>';

/** The button that leads from the map into the world. */
export class PlayControl implements IControl {
  readonly #group = document.createElement('div');

  constructor(readonly play: () => void) {
    this.#group.className = 'maplibregl-ctrl maplibregl-ctrl-group';
    const button = document.createElement('button');
    button.type = 'button';
    button.id = 'play';
    button.className = 'overlay';
    button.innerHTML = ICON;
    button.title = 'Walk here (P)';
    button.setAttribute('aria-label', 'Walk here');
    button.setAttribute('aria-keyshortcuts', 'p');
    button.addEventListener('click', () => this.play());
    this.#group.append(button);
  }

  onAdd(): HTMLElement {
    return this.#group;
  }

  onRemove(): void {
    this.#group.remove();
  }
}
