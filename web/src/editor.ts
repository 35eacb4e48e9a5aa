import { Problem, createWorld, programmes, readProgramme, readWorld, saveWorld, type Fault, type JsonObject, type Stored } from './api.ts';
import { ask } from './dialog.ts';
import { FIELDS, fieldFor, toDocument, toValues, type Values } from './fields.ts';
import { Form } from './form.ts';
import { chooseProgramme } from './gallery.ts';
import { withProgramme } from './library.ts';
import { saveProgramme } from './save-programme.ts';
import { NAME, slug } from './text.ts';

export interface EditorEvents {
  /** A new revision of the world in the form is stored. */
  saved(name: string): void;
  /** A new world is stored, and is to be shown. */
  created(name: string): void;
}

const message = (error: unknown) => (error instanceof Error ? error.message : String(error));

/** Edits one world's document: what is in the form, what is stored, and how the one becomes the other. */
export class Editor {
  readonly #form: Form;
  #name: string | undefined;
  #stored: Stored = { document: {}, etag: '' };
  /** What the form held when it was last equal to what is stored. */
  #clean: Values = {};
  #saving = false;

  constructor(
    form: HTMLFormElement,
    readonly events: EditorEvents,
  ) {
    this.#form = new Form(form);
    form.addEventListener('input', () => this.#showChanged());
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      void this.save();
    });
    form.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' || !(event.ctrlKey || event.metaKey)) return;
      event.preventDefault();
      void this.save();
    });
    form.querySelector('#save-as')?.addEventListener('click', () => void this.saveAs());
    form.querySelector('#choose-programme')?.addEventListener('click', () => void this.chooseProgramme());
    form.querySelector('#save-programme')?.addEventListener('click', () => void this.saveProgramme());
  }

  get changed(): boolean {
    const values = this.#form.values;
    return FIELDS.some(({ pointer }) => values[pointer] !== this.#clean[pointer]);
  }

  /** Puts a stored world, or without a name the beginning of a new one, into the form. */
  load(name: string | undefined, stored: Stored): void {
    this.#name = name;
    this.#form.clearFaults();
    this.#form.status('');
    this.#form.title(name ? `Edit ${name}` : 'New world');
    this.#settle(stored);
    this.#fill();
    this.#showChanged();
  }

  async save(): Promise<void> {
    const name = this.#name;
    if (!name) return this.saveAs();
    await this.#guarded(async (document) => {
      const submitted = this.#form.values;
      const stored = await this.#put(name, document, this.#stored.etag);
      if (!stored || this.#name !== name) return;
      this.#settle(stored);
      // What was typed meanwhile stays.
      const untouched = FIELDS.every(({ pointer }) => this.#form.values[pointer] === submitted[pointer]);
      if (untouched) this.#fill();
      this.#form.status('Saved.');
      this.events.saved(name);
    });
  }

  async saveAs(): Promise<void> {
    await this.#guarded(async (document) => {
      const name = await this.#create(document);
      if (!name) return;
      this.#clean = this.#form.values; // nothing is left to lose
      this.events.created(name);
    });
  }

  /** Fills in a programme of the library; what stood there can be brought back. */
  async chooseProgramme(): Promise<void> {
    this.#form.status('Opening the library…');
    try {
      const chosen = await chooseProgramme(await programmes());
      this.#form.status('');
      if (!chosen) return;
      const { document } = await readProgramme(chosen.name);
      this.#change(withProgramme(this.#form.values, document), `Filled in ${chosen.title}, not saved yet.`, 'Undo', 'As it was.');
    } catch (error) {
      this.#form.status(message(error), 'error');
    }
  }

  /** Keeps the form's programme in the library, whether or not the world is saved. */
  async saveProgramme(): Promise<void> {
    await this.#guarded(async (document) => {
      this.#form.status('');
      const name = await saveProgramme(document, this.#name ? `from the world ${this.#name}` : 'from the editor');
      if (name) this.#form.status(`Saved to the library as ${name}.`);
    });
  }

  /** Puts other values into the form, and offers to take them out again. */
  #change(values: Values, said: string, label: string, saidBack: string): void {
    const before = this.#form.values;
    this.#form.clearFaults();
    this.#form.values = values;
    this.#showChanged();
    const run = () => {
      this.#form.values = before;
      this.#form.status(saidBack);
      this.#showChanged();
    };
    this.#form.status(said, 'info', { label, run });
  }

  /** Runs one saving at a time, with the form's document, and shows what went wrong. */
  async #guarded(run: (document: JsonObject) => Promise<void>): Promise<void> {
    if (this.#saving) return;
    this.#form.clearFaults();
    const { document, faults } = toDocument(this.#form.values, this.#stored.document);
    if (faults.size > 0) return this.#refuse([...faults].map(([pointer, detail]) => ({ pointer, detail })));
    this.#saving = true;
    this.#form.status('Saving…');
    try {
      await run(document);
    } catch (error) {
      if (error instanceof Problem && error.faults.length > 0) this.#refuse(error.faults);
      else this.#form.status(`Not saved. ${message(error)}`, 'error');
    } finally {
      this.#saving = false;
      this.#showChanged();
    }
  }

  async #put(name: string, document: JsonObject, etag: string): Promise<Stored | undefined> {
    try {
      return await saveWorld(name, document, etag);
    } catch (error) {
      if (!(error instanceof Problem) || error.status !== 412) throw error;
    }
    this.#form.status('');
    const reply = await ask({
      title: 'Somebody else has saved this world',
      text: 'It was changed since you opened it. Your changes are still in the form.',
      answers: [
        { id: 'mine', label: 'Save mine anyway' },
        { id: 'theirs', label: 'Load theirs' },
        { id: 'keep', label: 'Keep editing', primary: true },
      ],
    });
    if (reply?.answer === 'mine') return this.#put(name, document, (await readWorld(name)).etag);
    if (reply?.answer === 'theirs') await this.#loadTheirs(name);
    else this.#form.status('Not saved. Your changes are still here.');
    return undefined;
  }

  /** Shows what the other one saved; the user's own text can be brought back. */
  async #loadTheirs(name: string): Promise<void> {
    const mine = this.#form.values;
    this.load(name, await readWorld(name));
    this.#form.status('Loaded what is stored.', 'info', {
      label: 'Bring my changes back',
      run: () => {
        this.#form.values = mine;
        this.#form.status('Your changes are back, not saved yet.');
        this.#showChanged();
      },
    });
    this.events.saved(name);
  }

  async #create(document: JsonObject): Promise<string | undefined> {
    let value = slug(typeof document['title'] === 'string' ? document['title'] : '') || this.#name || 'world';
    let error: string | undefined;
    for (;;) {
      this.#form.status('');
      const reply = await ask({
        title: 'Save as a new world',
        text: 'The name becomes part of its address and cannot be changed.',
        lines: [{ label: 'Name', value, ...NAME, ...(error ? { error } : {}) }],
        answers: [
          { id: 'cancel', label: 'Cancel' },
          { id: 'create', label: 'Create', primary: true },
        ],
      });
      if (reply?.answer !== 'create') return undefined;
      value = reply.texts[0] ?? '';
      this.#form.status('Saving…');
      try {
        await createWorld(value, document);
        return value;
      } catch (problem) {
        if (!(problem instanceof Problem) || problem.status !== 409) throw problem;
        error = problem.message;
      }
    }
  }

  #settle(stored: Stored): void {
    this.#stored = stored;
    this.#clean = toValues(stored.document);
  }

  #fill(): void {
    this.#form.values = this.#clean;
    this.#clean = this.#form.values; // the form has its own line ends
  }

  #refuse(faults: Fault[]): void {
    const unplaced: Fault[] = [];
    const byField = new Map<string, Fault[]>();
    for (const fault of faults) {
      const field = fieldFor(fault.pointer);
      if (!field) unplaced.push(fault);
      else byField.set(field.pointer, [...(byField.get(field.pointer) ?? []), fault]);
    }
    this.#form.showFaults(byField);
    const rest = unplaced.map(({ pointer, detail }) => `${pointer || 'The document'}: ${detail}`);
    const count = faults.length === 1 ? 'One thing is wrong.' : `${faults.length} things are wrong.`;
    this.#form.status(['Not saved.', count, ...rest].join(' '), 'error');
  }

  #showChanged(): void {
    this.#form.changed(this.changed);
  }
}
