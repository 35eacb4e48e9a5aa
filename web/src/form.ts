import type { Fault } from './api.ts';
import { FIELDS, type Field, type Values } from './fields.ts';
import { ProgrammeField } from './programme.ts';

type Control = HTMLInputElement | HTMLTextAreaElement;

const idOf = (field: Field) => `field${field.pointer.replaceAll('/', '-')}`;

/** The form's elements: one control, one label and one place for errors a field of the document. */
export class Form {
  readonly #controls = new Map<string, Control>();
  readonly #programmes = new Map<string, ProgrammeField>();

  constructor(readonly element: HTMLFormElement) {
    for (const field of FIELDS) {
      const parent = this.#find(field.more ? '#more-fields' : '#fields');
      parent.append(this.#row(field));
      if (field.kind !== 'programme') continue;
      const area = this.#controls.get(field.pointer) as HTMLTextAreaElement;
      this.#programmes.set(field.pointer, new ProgrammeField(area, this.#errors(field)));
      parent.append(document.querySelector<HTMLTemplateElement>('#programme-help')?.content.cloneNode(true) ?? '');
    }
  }

  get values(): Values {
    return Object.fromEntries([...this.#controls].map(([pointer, control]) => [pointer, control.value]));
  }

  set values(values: Values) {
    for (const [pointer, control] of this.#controls) {
      const value = values[pointer] ?? '';
      if (control.value === value) continue; // keeps the caret where it is
      control.value = value;
      this.#programmes.get(pointer)?.mark([]);
    }
  }

  title(text: string): void {
    this.#find('#panel-title').textContent = text;
  }

  changed(changed: boolean): void {
    this.#find('#changed').hidden = !changed;
  }

  status(text: string, kind: 'info' | 'error' = 'info', action?: { label: string; run: () => void }): void {
    const status = this.#find('#editor-status');
    status.className = kind;
    status.textContent = text;
    if (!action) return;
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = action.label;
    button.addEventListener('click', action.run);
    status.append(' ', button);
  }

  /** Shows faults at their fields and goes to the first one. */
  showFaults(faults: ReadonlyMap<string, Fault[]>): void {
    let first: Control | undefined;
    for (const field of FIELDS) {
      const found = faults.get(field.pointer);
      const control = this.#controls.get(field.pointer);
      if (!found || !control) continue;
      first ??= control;
      const programme = this.#programmes.get(field.pointer);
      if (programme) {
        programme.mark(found);
        continue;
      }
      control.setAttribute('aria-invalid', 'true');
      const within = (fault: Fault) => fault.pointer.slice(field.pointer.length);
      this.#errors(field).textContent = found.map((fault) => `${within(fault)} ${fault.detail}`.trim()).join('. ');
    }
    first?.closest('details')?.setAttribute('open', '');
    first?.focus();
  }

  clearFaults(): void {
    for (const field of FIELDS) this.#clearFault(field);
  }

  #clearFault(field: Field): void {
    this.#programmes.get(field.pointer)?.mark([]);
    this.#controls.get(field.pointer)?.removeAttribute('aria-invalid');
    this.#errors(field).replaceChildren();
  }

  #row(field: Field): HTMLElement {
    const row = document.createElement('div');
    row.className = field.half ? 'field half' : 'field';
    const label = document.createElement('label');
    label.htmlFor = idOf(field);
    label.append(field.label);
    if (field.unit) label.append(this.#span('unit', field.unit));
    const control = this.#control(field);
    this.#controls.set(field.pointer, control);
    const errors = document.createElement('div');
    errors.className = 'error';
    errors.id = `${control.id}-error`;
    control.setAttribute('aria-describedby', errors.id);
    row.append(label, control);
    if (field.hint) {
      const hint = this.#span('hint', field.hint);
      hint.id = `${control.id}-hint`;
      control.setAttribute('aria-describedby', `${errors.id} ${hint.id}`);
      row.append(hint);
    }
    row.append(errors);
    return row;
  }

  #control(field: Field): Control {
    const control = document.createElement(field.lines ? 'textarea' : 'input');
    control.id = idOf(field);
    control.autocomplete = 'off';
    if (control instanceof HTMLTextAreaElement) control.rows = field.lines ?? 2;
    if (field.kind !== 'text') {
      control.spellcheck = false;
      control.autocapitalize = 'off';
      control.classList.add('code');
    }
    control.addEventListener('input', () => this.#clearFault(field));
    return control;
  }

  #span(className: string, text: string): HTMLElement {
    const span = document.createElement('span');
    span.className = className;
    span.textContent = text;
    return span;
  }

  #errors(field: Field): HTMLElement {
    return this.#find(`#${idOf(field)}-error`);
  }

  #find(selector: string): HTMLElement {
    const found = this.element.querySelector<HTMLElement>(selector);
    if (!found) throw new Error(`the page has no ${selector}`);
    return found;
  }
}
