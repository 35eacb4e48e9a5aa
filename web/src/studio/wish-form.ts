import { catalog, statistics, type Fault } from '../api.ts';
import { element } from '../dialog.ts';
import { BREEDING, CRITERIA, GROUND, emptyWish, fieldOf, type AimField, type Wish } from './aim.ts';

type Control = HTMLInputElement | HTMLTextAreaElement;

/** The form in which an evolution is asked for. */
export class WishForm {
  readonly element = element('form', { id: 'evolve-form', className: 'wish', noValidate: true });
  readonly #controls = new Map<string, Control>();
  readonly #errors = new Map<string, HTMLElement>();
  readonly #boxes = new Map<string, HTMLInputElement>();
  readonly #world = element('select', { id: 'likeness-world' });
  readonly #measured = element('span', { className: 'hint' });

  constructor(run: () => void, place: () => { x: number; y: number }) {
    const wanted = CRITERIA.map(({ name, label, hint, fields }) => {
      const box = element('input', { type: 'checkbox', id: `want-${name}` });
      this.#boxes.set(name, box);
      const inner = element('div', { className: 'wish-fields', hidden: true }, ...fields.map((field) => this.#row(field)));
      if (name === 'likeness') inner.append(this.#measure(place));
      box.addEventListener('change', () => (inner.hidden = !box.checked));
      const said = element('p', { className: 'hint', id: `want-${name}-hint`, textContent: hint });
      box.setAttribute('aria-describedby', said.id);
      return element('fieldset', {}, element('legend', {}, element('label', { htmlFor: box.id }, box, ` ${label}`)), said, inner);
    });
    const rows = (fields: readonly AimField[]) => element('div', { className: 'wish-fields' }, ...fields.map((field) => this.#row(field)));
    const start = element('button', { id: 'evolve-start', className: 'primary', textContent: 'Start evolution' });
    this.element.append(
      element('div', { className: 'wish-wanted' }, element('h3', { textContent: 'What is wanted' }), ...wanted),
      element('div', { className: 'wish-rest' }, element('h3', { textContent: 'Where' }), rows(GROUND), element('h3', { textContent: 'How it is bred' }), rows(BREEDING), start),
    );
    this.element.addEventListener('submit', (event) => {
      event.preventDefault();
      run();
    });
    this.wish = emptyWish();
  }

  get wish(): Wish {
    const values = Object.fromEntries([...this.#controls].map(([id, control]) => [id, control.value]));
    return { values, wanted: [...this.#boxes].filter(([, box]) => box.checked).map(([name]) => name) };
  }

  set wish({ values, wanted }: Wish) {
    for (const [id, control] of this.#controls) control.value = values[id] ?? '';
    for (const [name, box] of this.#boxes) {
      box.checked = wanted.includes(name);
      box.dispatchEvent(new Event('change'));
    }
    this.showFaults([]);
  }

  /** Shows faults at their fields, goes to the first, and answers those that no field is about. */
  showFaults(faults: readonly Fault[]): Fault[] {
    for (const [id, control] of this.#controls) {
      control.removeAttribute('aria-invalid');
      this.#errors.get(id)?.replaceChildren();
    }
    let first: Control | undefined;
    const others: Fault[] = [];
    for (const fault of faults) {
      const id = fieldOf(fault, this.wish);
      const control = id === undefined ? undefined : this.#controls.get(id);
      if (!control || id === undefined) {
        others.push(fault);
        continue;
      }
      control.setAttribute('aria-invalid', 'true');
      this.#errors.get(id)?.append(fault.detail);
      first ??= control;
    }
    first?.focus();
    return others;
  }

  #row({ id, label, unit, min, max, step, hint, isText }: AimField): HTMLElement {
    const control = isText ? element('textarea', { rows: 3, spellcheck: false, className: 'code' }) : element('input', { type: 'number', inputMode: 'decimal' });
    control.id = `evolve-${id}`;
    control.autocomplete = 'off';
    if (control instanceof HTMLInputElement) {
      if (min !== undefined) control.min = String(min);
      if (max !== undefined) control.max = String(max);
      control.step = String(step ?? 'any');
    }
    this.#controls.set(id, control);
    const error = element('div', { className: 'error', id: `${control.id}-error` });
    error.setAttribute('role', 'alert');
    this.#errors.set(id, error);
    control.addEventListener('input', () => {
      control.removeAttribute('aria-invalid');
      error.replaceChildren();
    });
    const caption = element('label', { htmlFor: control.id }, label, ...(unit ? [element('span', { className: 'unit', textContent: unit })] : []));
    const said = hint ? [element('span', { className: 'hint', id: `${control.id}-hint`, textContent: hint })] : [];
    control.setAttribute('aria-describedby', [error.id, ...said.map(({ id }) => id)].join(' '));
    return element('div', { className: isText ? 'field wide' : 'field' }, caption, control, ...said, error);
  }

  /** Takes the statistics of a world here, about where the map looks. */
  #measure(place: () => { x: number; y: number }): HTMLElement {
    const button = element('button', { type: 'button', id: 'likeness-measure', textContent: 'Measure about the map’s centre' });
    button.addEventListener('click', () => void this.#take(place()));
    this.#world.setAttribute('aria-label', 'World to measure');
    return element('div', { className: 'field wide' }, element('div', { className: 'measure' }, this.#world, button), this.#measured);
  }

  /** The worlds to measure; the one on the map first. */
  async listWorlds(shown: string | undefined): Promise<void> {
    const worlds = await catalog();
    this.#world.replaceChildren(...worlds.map(({ name, title }) => new Option(title ?? name, name)));
    if (shown && worlds.some(({ name }) => name === shown)) this.#world.value = shown;
  }

  async #take(place: { x: number; y: number }): Promise<void> {
    const [side, samples] = ['side', 'samples'].map((id) => Number(this.#controls.get(id)?.value));
    const sample = this.#controls.get('likeness-sample');
    if (!side || !samples || !sample) return;
    this.#measured.className = 'hint';
    this.#measured.textContent = 'Measuring…';
    try {
      sample.value = JSON.stringify(await statistics(this.#world.value, place, side, side / samples));
      sample.dispatchEvent(new Event('input'));
      this.#measured.textContent = `${side} m of ${this.#world.value} about x ${Math.round(place.x)}, y ${Math.round(place.y)}.`;
    } catch (error) {
      this.#measured.className = 'error';
      this.#measured.textContent = error instanceof Error ? error.message : String(error);
    }
  }
}
