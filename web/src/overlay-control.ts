import type { IControl } from 'maplibre-gl';
import { OVERLAYS, type Overlay } from './link.ts';

interface Face {
  label: string;
  key: string;
  /** Strokes of the icon in a square of 24 units. */
  icon: string;
}

const FACES: Record<Overlay, Face> = {
  contours: {
    label: 'Contour lines',
    key: 'c',
    icon: 'M3 14c0-6 4-10 9-10s9 3 9 8-4 8-10 8-8-2-8-6ZM7 13c0-3 2-6 5-6s5 2 5 5-2 4-5 4-5-1-5-3Z',
  },
  features: {
    label: 'Features: ridges, rivers, lakes',
    key: 'f',
    icon: 'M4 19l5-6 4 2 7-10M4 17.5v3h3v-3ZM18.5 3.5v3h3v-3ZM7.5 11.5v3h3v-3ZM11.5 13.5v3h3v-3Z',
  },
};

/** The buttons that show and hide what can be laid over the terrain. */
export class OverlayControl implements IControl {
  readonly #group = document.createElement('div');
  readonly #buttons = new Map<Overlay, HTMLButtonElement>();

  constructor(readonly change: (overlays: Overlay[]) => void) {
    this.#group.className = 'maplibregl-ctrl maplibregl-ctrl-group';
    for (const overlay of OVERLAYS) {
      const { label, key, icon } = FACES[overlay];
      const button = document.createElement('button');
      button.type = 'button';
      button.id = overlay;
      button.className = 'overlay';
      button.setAttribute('aria-label', label);
      button.setAttribute('aria-keyshortcuts', key);
      button.title = `${label} (${key.toUpperCase()})`;
      button.innerHTML = `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${icon}"/></svg>`;
      button.addEventListener('click', () => this.toggle(overlay));
      this.#buttons.set(overlay, button);
      this.#group.append(button);
    }
  }

  onAdd(): HTMLElement {
    return this.#group;
  }

  onRemove(): void {
    this.#group.remove();
  }

  /** The overlay that a key stands for. */
  overlayOf(key: string): Overlay | undefined {
    return OVERLAYS.find((overlay) => FACES[overlay].key === key.toLowerCase());
  }

  toggle(overlay: Overlay): void {
    const button = this.#buttons.get(overlay);
    if (!button || button.hidden) return;
    const pressed = (other: Overlay) => this.#buttons.get(other)?.getAttribute('aria-pressed') === 'true';
    this.change(OVERLAYS.filter((other) => pressed(other) !== (other === overlay)));
  }

  /** `there` is what the world has, `shown` what of it is on the map. */
  show(there: readonly Overlay[], shown: readonly Overlay[]): void {
    for (const [overlay, button] of this.#buttons) {
      button.hidden = !there.includes(overlay);
      button.setAttribute('aria-pressed', String(shown.includes(overlay)));
    }
    this.#group.hidden = there.length === 0;
  }
}
