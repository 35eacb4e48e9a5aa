import { element } from '../dialog.ts';

/** What both ways of breeding tell the page and ask of it. */
export interface StudioEvents {
  /** A world was made of what was bred. */
  created(name: string): void;
  /** Breeding by eye is wanted, perhaps of this session. */
  breed(session?: string): void;
  /** Breeding towards what is wanted is. */
  evolve(): void;
  /** The world on the map. */
  world(): string | undefined;
  /** What the map looks at, in metres. */
  place(): { x: number; y: number };
}

/** The two ways of breeding side by side: one leads to the other. */
export function switcher(here: 'breed' | 'evolve', other: () => void): HTMLElement {
  const labels = { breed: 'By eye', evolve: 'Towards an aim' } as const;
  const buttons = (['breed', 'evolve'] as const).map((way) => {
    const button = element('button', { type: 'button', id: `way-${way}`, textContent: labels[way] });
    if (way === here) button.setAttribute('aria-current', 'page');
    else button.addEventListener('click', other);
    return button;
  });
  const made = element('nav', { className: 'ways' }, ...buttons);
  made.setAttribute('aria-label', 'Ways of breeding');
  return made;
}
