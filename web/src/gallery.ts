import { keyedPicture, previewUrl, type ProgrammeEntry } from './api.ts';
import { element } from './dialog.ts';
import { hasKey } from './key.ts';
import { isFound, tagsOf } from './library.ts';

/** Pixels of a picture on the page; twice as many are there for those who can see them. */
const PIXELS = 256;

const counted = (count: number) => (count === 1 ? '1 programme' : `${count} programmes`);

/** The library as pictures to choose from. */
class Gallery {
  readonly #search = element('input', { id: 'gallery-search', type: 'search', placeholder: 'Search', autocomplete: 'off' });
  readonly #count = element('p', { className: 'hint' });
  readonly #about = element('p', { className: 'about' });
  readonly #use = element('button', { value: 'use', className: 'primary', disabled: true }, 'Use it');
  readonly #cancel = element('button', { type: 'button' }, 'Cancel');
  readonly #cards = new Map<ProgrammeEntry, { card: HTMLElement; radio: HTMLInputElement }>();
  readonly #tags = new Set<string>();
  readonly dialog: HTMLDialogElement;

  constructor(programmes: readonly ProgrammeEntry[]) {
    for (const entry of programmes) this.#cards.set(entry, this.#card(entry));
    const heading = element('h2', { id: 'gallery-title' }, 'Choose a programme');
    // Fingers would get a keyboard over half the gallery with the search field.
    if (matchMedia('(pointer: coarse)').matches) Object.assign(heading, { tabIndex: -1, autofocus: true });
    const label = element('label', { className: 'visually-hidden', htmlFor: this.#search.id }, 'Search the library');
    const chips = element('div', { className: 'chips', role: 'group', ariaLabel: 'Tags' });
    chips.append(...tagsOf(programmes).map((tag) => this.#chip(tag)));
    const cards = element('div', { className: 'choices', role: 'radiogroup', ariaLabel: 'Programmes' });
    cards.append(...[...this.#cards.values()].map(({ card }) => card));
    this.#count.setAttribute('role', 'status');
    this.#about.setAttribute('aria-live', 'polite');
    const form = element(
      'form',
      { method: 'dialog' },
      element('div', { className: 'gallery-head' }, heading, label, this.#search),
      chips,
      this.#count,
      cards,
      element('div', { className: 'gallery-foot' }, this.#about, element('div', { className: 'actions' }, this.#cancel, this.#use)),
    );
    this.dialog = element('dialog', { className: 'gallery' }, form);
    this.dialog.setAttribute('aria-labelledby', heading.id);
    this.#listen(form);
    this.#filter();
  }

  get chosen(): ProgrammeEntry | undefined {
    return [...this.#cards].find(([, { card, radio }]) => radio.checked && !card.hidden)?.[0];
  }

  #listen(form: HTMLFormElement): void {
    this.#search.addEventListener('input', () => this.#filter());
    this.#search.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter') return;
      event.preventDefault(); // or what was chosen before would be taken
      [...this.#cards.values()].find(({ card }) => !card.hidden)?.radio.focus();
    });
    this.#cancel.addEventListener('click', () => this.dialog.close());
    form.addEventListener('change', () => this.#showChosen());
    form.addEventListener('dblclick', (event) => {
      if (event.target instanceof Element && event.target.closest('.choice') && this.chosen) form.requestSubmit(this.#use);
    });
  }

  #card(entry: ProgrammeEntry): { card: HTMLElement; radio: HTMLInputElement } {
    const radio = element('input', { type: 'radio', name: 'programme', value: entry.name });
    const picture = element('img', { alt: '', width: PIXELS, height: PIXELS, loading: 'lazy', decoding: 'async' });
    if (hasKey()) {
      // A picture that does not come leaves its place empty, as one without a key does.
      picture.addEventListener('load', () => URL.revokeObjectURL(picture.src));
      void keyedPicture(previewUrl(entry, 2 * PIXELS)).then((url) => (picture.src = url), () => {});
    } else {
      picture.srcset = `${previewUrl(entry, PIXELS)}, ${previewUrl(entry, 2 * PIXELS)} 2x`;
      picture.src = previewUrl(entry, PIXELS);
    }
    const title = element('span', { className: 'choice-title' }, entry.title);
    const tags = element('span', { className: 'hint' }, entry.tags.join(', '));
    return { card: element('label', { className: 'choice' }, radio, picture, title, tags), radio };
  }

  #chip(tag: string): HTMLElement {
    const chip = element('button', { type: 'button', className: 'chip', ariaPressed: 'false' }, tag);
    chip.addEventListener('click', () => {
      const on = !this.#tags.delete(tag);
      if (on) this.#tags.add(tag);
      chip.ariaPressed = String(on);
      this.#filter();
    });
    return chip;
  }

  #filter(): void {
    let found = 0;
    for (const [entry, { card, radio }] of this.#cards) {
      card.hidden = !isFound(entry, this.#tags, this.#search.value);
      if (card.hidden) radio.checked = false; // what cannot be seen is not chosen
      else found++;
    }
    this.#count.textContent = found === this.#cards.size ? counted(found) : `${found} of ${counted(this.#cards.size)}`;
    this.#showChosen();
  }

  #showChosen(): void {
    const { chosen } = this;
    this.#use.disabled = !chosen;
    this.#about.textContent = chosen ? [chosen.description, chosen.origin && `(${chosen.origin})`].filter(Boolean).join(' ') : '';
  }
}

/** Shows the library; resolves to what was chosen, or to undefined when the user went away. */
export function chooseProgramme(programmes: readonly ProgrammeEntry[]): Promise<ProgrammeEntry | undefined> {
  const gallery = new Gallery(programmes);
  const { dialog } = gallery;
  document.body.append(dialog);
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => {
      const chosen = dialog.returnValue === 'use' ? gallery.chosen : undefined;
      dialog.remove();
      resolve(chosen);
    });
    dialog.showModal();
  });
}
