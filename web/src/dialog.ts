/** A question that must be answered before anything else happens. */

/** A line of text that is asked for. */
export interface Line {
  label: string;
  value: string;
  hint?: string;
  pattern?: string;
  error?: string;
  optional?: boolean;
  /** Is not shown. */
  secret?: boolean;
  /** Makes the text from that of the line before, until the user writes another. */
  follow?: (before: string) => string;
}

export interface Question<Answer extends string> {
  title: string;
  text: string;
  answers: readonly { id: Answer; label: string; primary?: boolean }[];
  /** Asks for lines of text as well. */
  lines?: readonly Line[];
}

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Partial<HTMLElementTagNameMap[K]> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/** Label, text field, and what is said about them. */
function lineOf({ label, value, hint, pattern, error, optional, secret }: Line, i: number): { input: HTMLInputElement; parts: Node[] } {
  const input = element('input', { id: `dialog-line-${i}`, value, required: !optional, autocomplete: 'off', spellcheck: false });
  input.autocapitalize = 'off';
  if (secret) input.type = 'password';
  if (pattern) input.pattern = pattern;
  if (hint) input.title = hint;
  const parts: Node[] = [element('label', { htmlFor: input.id }, label), input];
  if (error || hint) {
    const said = element('p', { id: `${input.id}-said`, className: error ? 'error' : 'hint' }, error ?? hint ?? '');
    input.setAttribute('aria-describedby', said.id);
    if (error) input.setAttribute('aria-invalid', 'true');
    parts.push(said);
  }
  return { input, parts };
}

function follow(lines: readonly Line[], inputs: readonly HTMLInputElement[]): void {
  lines.forEach(({ follow }, i) => {
    const [before, input] = [inputs[i - 1], inputs[i]];
    if (!follow || !before || !input) return;
    let own = false;
    input.addEventListener('input', () => (own = true));
    before.addEventListener('input', () => {
      if (!own) input.value = follow(before.value);
    });
  });
}

/** Resolves to the answer and the lines of text, or to undefined when the user pressed Escape. */
export function ask<Answer extends string>(
  question: Question<Answer>,
): Promise<{ answer: Answer; texts: string[] } | undefined> {
  const form = element('form', { method: 'dialog' });
  const heading = element('h2', { id: 'dialog-title' }, question.title);
  form.append(heading, element('p', { id: 'dialog-text' }, question.text));
  const lines = question.lines ?? [];
  const made = lines.map(lineOf);
  const inputs = made.map(({ input }) => input);
  form.append(...made.flatMap(({ parts }) => parts));
  follow(lines, inputs);
  const buttons = question.answers.map(({ id, label, primary }) =>
    element('button', { value: id, className: primary ? 'primary' : '', formNoValidate: !primary }, label),
  );
  form.append(element('div', { className: 'actions' }, ...buttons));
  const dialog = element('dialog', {}, form);
  dialog.setAttribute('aria-labelledby', heading.id);
  dialog.setAttribute('aria-describedby', 'dialog-text');
  // Enter in the text field takes the first submit button: put the primary answer there, in front of the eyes it stays last.
  form.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter' || !inputs.some((input) => input === event.target)) return;
    event.preventDefault();
    form.requestSubmit(buttons.find((button) => button.classList.contains('primary')));
  });
  document.body.append(dialog);
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => {
      const answer = question.answers.find(({ id }) => id === dialog.returnValue)?.id;
      dialog.remove();
      resolve(answer === undefined ? undefined : { answer, texts: inputs.map(({ value }) => value.trim()) });
    });
    dialog.showModal();
    const first = inputs[lines.findIndex(({ error }) => error)] ?? inputs[0];
    (first ?? buttons.find((button) => button.classList.contains('primary')))?.focus();
    first?.select();
  });
}
