/** A question that must be answered before anything else happens. */

export interface Question<Answer extends string> {
  title: string;
  text: string;
  answers: readonly { id: Answer; label: string; primary?: boolean }[];
  /** Asks for a line of text as well. */
  input?: { label: string; value: string; hint?: string; pattern?: string; error?: string };
}

function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Partial<HTMLElementTagNameMap[K]> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/** Resolves to the answer and the text, or to undefined when the user pressed Escape. */
export function ask<Answer extends string>(
  question: Question<Answer>,
): Promise<{ answer: Answer; text: string } | undefined> {
  const form = element('form', { method: 'dialog' });
  const heading = element('h2', { id: 'dialog-title' }, question.title);
  form.append(heading, element('p', { id: 'dialog-text' }, question.text));
  let input: HTMLInputElement | undefined;
  if (question.input) {
    const { label, value, hint, pattern, error } = question.input;
    input = element('input', { id: 'dialog-input', value, required: true, autocomplete: 'off', spellcheck: false });
    input.autocapitalize = 'off';
    if (pattern) input.pattern = pattern;
    if (hint) input.title = hint;
    form.append(element('label', { htmlFor: input.id }, label), input);
    if (error) {
      input.setAttribute('aria-invalid', 'true');
      input.setAttribute('aria-describedby', 'dialog-error');
      form.append(element('p', { id: 'dialog-error', className: 'error' }, error));
    } else if (hint) {
      form.append(element('p', { className: 'hint' }, hint));
    }
  }
  const buttons = question.answers.map(({ id, label, primary }) =>
    element('button', { value: id, className: primary ? 'primary' : '', formNoValidate: !primary }, label),
  );
  form.append(element('div', { className: 'actions' }, ...buttons));
  const dialog = element('dialog', {}, form);
  dialog.setAttribute('aria-labelledby', heading.id);
  dialog.setAttribute('aria-describedby', 'dialog-text');
  // Enter in the text field takes the first submit button: put the primary answer there, in front of the eyes it stays last.
  form.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter' || event.target !== input) return;
    event.preventDefault();
    form.requestSubmit(buttons.find((button) => button.classList.contains('primary')));
  });
  document.body.append(dialog);
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => {
      const answer = question.answers.find(({ id }) => id === dialog.returnValue)?.id;
      dialog.remove();
      resolve(answer === undefined ? undefined : { answer, text: input?.value.trim() ?? '' });
    });
    dialog.showModal();
    (input ?? buttons.find((button) => button.classList.contains('primary')))?.focus();
    input?.select();
  });
}
