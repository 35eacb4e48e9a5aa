import type { Fault } from './api.ts';
import { lineAndColumn, utf16Offset } from './text.ts';

/**
 * The text area of a programme. Behind it stands a copy of the text in the same type, invisible but for the marks:
 * a text area itself cannot mark a part of its text.
 */
export class ProgrammeField {
  readonly #backdrop = document.createElement('div');

  constructor(
    readonly area: HTMLTextAreaElement,
    readonly list: HTMLElement,
  ) {
    const box = document.createElement('div');
    box.className = 'programme';
    this.#backdrop.className = 'backdrop';
    this.#backdrop.setAttribute('aria-hidden', 'true');
    area.replaceWith(box);
    box.append(this.#backdrop, area);
    area.addEventListener('scroll', () => this.#align());
    area.addEventListener('input', () => this.mark([]));
  }

  /** Shows where and what is wrong; the caret goes to the first fault that has a place. */
  mark(faults: readonly Fault[]): void {
    const text = this.area.value;
    const placed = faults
      .filter((fault) => fault.start !== undefined)
      .map((fault) => {
        const start = utf16Offset(text, fault.start ?? 0);
        return { start, end: Math.max(start, utf16Offset(text, fault.end ?? fault.start ?? 0)), fault };
      })
      .sort((a, b) => a.start - b.start);
    this.#paint(text, placed);
    const found = new Map(placed.map((place) => [place.fault, place]));
    this.list.replaceChildren(
      ...faults.map((fault) => {
        const place = found.get(fault);
        return place ? this.#button(text, place.start, place.end, fault.detail) : this.#plain(fault);
      }),
    );
    this.area.toggleAttribute('aria-invalid', false);
    if (faults.length > 0) this.area.setAttribute('aria-invalid', 'true');
    const first = placed[0];
    if (first) this.#select(first.start, first.end);
  }

  #paint(text: string, places: readonly { start: number; end: number }[]): void {
    const parts: (string | Node)[] = [];
    let done = 0;
    for (const { start, end } of places) {
      if (start < done) continue; // faults may overlap; the first one is marked
      const mark = document.createElement('mark');
      // What is missing at the end of the text has no characters to mark: mark the place itself.
      mark.textContent = text.slice(start, end) || '\u200b';
      mark.classList.toggle('gap', start === end);
      parts.push(text.slice(done, start), mark);
      done = end;
    }
    this.#backdrop.replaceChildren(...parts, text.slice(done), '\n');
    this.#align();
  }

  #button(text: string, start: number, end: number, detail: string): HTMLElement {
    const { line, column } = lineAndColumn(text, start);
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = `Line ${line}, column ${column}: ${detail}`;
    button.addEventListener('click', () => {
      this.area.focus();
      this.#select(start, end);
    });
    return button;
  }

  #plain(fault: Fault): HTMLElement {
    const line = document.createElement('span');
    line.textContent = fault.at ? `${fault.at}: ${fault.detail}` : fault.detail;
    return line;
  }

  #select(start: number, end: number): void {
    this.area.setSelectionRange(start, end);
  }

  #align(): void {
    this.#backdrop.scrollTop = this.area.scrollTop;
    this.#backdrop.scrollLeft = this.area.scrollLeft;
  }
}
