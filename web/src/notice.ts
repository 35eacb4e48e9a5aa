/** One line above the map: what is going on, or what went wrong and what can be done about it. */
export class Notice {
  readonly #text = document.createElement('span');
  readonly #button = document.createElement('button');

  constructor(readonly element: HTMLElement) {
    this.#button.type = 'button';
    element.append(this.#text, this.#button);
    this.clear();
  }

  info(text: string): void {
    this.#show('info', text);
  }

  error(text: string, action?: { label: string; run: () => void }): void {
    this.#show('error', text, action);
  }

  /** Takes away what was said, or only a message of one kind. */
  clear(kind?: 'info' | 'error'): void {
    if (kind && this.element.dataset['kind'] !== kind) return;
    this.element.dataset['kind'] = '';
    this.#text.textContent = '';
    this.#button.hidden = true;
  }

  #show(kind: 'info' | 'error', text: string, action?: { label: string; run: () => void }): void {
    this.element.dataset['kind'] = kind;
    // Setting the same words again would make a screen reader repeat them.
    if (this.#text.textContent !== text) this.#text.textContent = text;
    this.#button.hidden = !action;
    if (!action) return;
    this.#button.textContent = action.label;
    this.#button.onclick = action.run;
  }
}
