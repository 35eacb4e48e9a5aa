import {
  Problem, createProgramme, createSession, createWorld, deleteSession, keyedPicture, readGeneration, readSession, saveSession, sessions,
} from '../api.ts';
import { ask, element } from '../dialog.ts';
import { hasKey } from '../key.ts';
import { NAME, slug } from '../text.ts';
import { ancestors, bred, newRecord, told, upTo, worldOf, type Generation, type SessionRecord } from './record.ts';
import { switcher, type StudioEvents } from './switcher.ts';

const PLACE = 'terrane-studio';
/** The keys of the twelve, in the order of the number row. */
const KEYS = '1234567890-=';

const message = (error: unknown) => (error instanceof Error ? error.message : String(error));

/** Twelve terrains side by side: one or two are chosen, their children come next. */
export class Studio {
  readonly #dialog = element('dialog', { className: 'studio' });
  readonly #cards: { button: HTMLButtonElement; picture: HTMLImageElement; origin: HTMLElement }[] = [];
  readonly #select = element('select', { id: 'studio-session' });
  readonly #strip = element('ol', { id: 'studio-history' });
  readonly #kept = element('ul', { id: 'studio-kept' });
  readonly #status = element('p', { id: 'studio-status' });
  readonly #actions: Record<'next' | 'undo' | 'keep' | 'world' | 'family', HTMLButtonElement>;
  #name: string | undefined;
  #record: SessionRecord = newRecord(1);
  #etag = '';
  /** Of the session, as far as they were looked at. */
  #generations: Generation[] = [];
  #shown = 0;
  #chosen: number[] = [];
  #busy = false;

  constructor(readonly events: StudioEvents) {
    const action = (id: string, label: string, title: string, run: () => Promise<void>) => {
      const button = element('button', { type: 'button', id: `studio-${id}`, textContent: label, title });
      button.addEventListener('click', () => void this.#guarded(run));
      return button;
    };
    this.#actions = {
      next: action('next', 'Next generation', 'Breed what is chosen (Enter)', () => this.#next()),
      undo: action('undo', 'Undo', 'Take the newest generation back (U)', () => this.#undo()),
      keep: action('keep', 'Keep…', 'Keep what is chosen under a name (K)', () => this.#keep()),
      world: action('world', 'Make a world…', 'Make a world of what is chosen (W)', () => this.#makeWorld()),
      family: action('family', 'Family tree', 'Where what is chosen comes from (F)', () => this.#family()),
    };
    this.#actions.next.className = 'primary';
    const fresh = action('new', 'New session', 'Begin with twelve others', () => this.#begin());
    const gone = action('delete', 'Delete…', 'Delete this session', () => this.#delete());
    const exported = element('button', { type: 'button', id: 'studio-export', textContent: 'Export', title: 'Save the session as a file' });
    exported.addEventListener('click', () => this.#export());
    const imported = element('button', { type: 'button', id: 'studio-import', textContent: 'Import…', title: 'Read a session from a file' });
    const file = element('input', { type: 'file', accept: '.json,application/json', hidden: true });
    imported.addEventListener('click', () => file.click());
    file.addEventListener('change', () => void this.#guarded(() => this.#import(file)));
    const close = element('button', { type: 'button', className: 'quiet', textContent: 'Close' });
    close.addEventListener('click', () => this.#dialog.close());
    const heading = element('h2', { id: 'studio-title', textContent: 'Breed terrain' });
    const views = switcher('breed', () => {
      this.#dialog.close();
      events.evolve();
    });
    const label = element('label', { className: 'visually-hidden', htmlFor: 'studio-session', textContent: 'Session' });
    const grid = element('div', { className: 'twelve', role: 'group' });
    grid.setAttribute('aria-label', 'The generation');
    for (let i = 0; i < KEYS.length; i++) grid.append(this.#card(i));
    this.#status.setAttribute('role', 'status');
    const side = element('div', { className: 'studio-side' }, element('h3', { textContent: 'History' }), this.#strip, element('h3', { textContent: 'Kept' }), this.#kept);
    this.#dialog.append(
      element('div', { className: 'studio-head' }, heading, views, label, this.#select, fresh, imported, exported, gone, file, close),
      element('div', { className: 'studio-body' }, grid, side),
      element('div', { className: 'studio-foot' }, this.#status, element('div', { className: 'actions' }, ...Object.values(this.#actions))),
    );
    this.#dialog.setAttribute('aria-labelledby', heading.id);
    this.#select.addEventListener('change', () => void this.#guarded(() => this.#open(this.#select.value)));
    this.#dialog.addEventListener('keydown', (event) => this.#key(event));
    this.#dialog.addEventListener('close', () => {
      localStorage.setItem(PLACE, JSON.stringify({ name: this.#name, open: false }));
      this.#dialog.remove();
    });
  }

  /** Whether the page was left with the studio open. */
  static get wasOpen(): boolean {
    return (JSON.parse(localStorage.getItem(PLACE) ?? '{}') as { open?: boolean }).open === true;
  }

  async show(session?: string): Promise<void> {
    document.body.append(this.#dialog);
    this.#dialog.showModal();
    this.#cards[0]?.button.focus(); // where the keys are, not in the choice of sessions
    await this.#guarded(async () => {
      const last = session ?? (JSON.parse(localStorage.getItem(PLACE) ?? '{}') as { name?: string }).name;
      const known = await this.#list();
      const name = known.find((name) => name === last) ?? known[0];
      if (name === undefined) await this.#begin();
      else await this.#open(name);
    });
  }

  #card(i: number): HTMLElement {
    const picture = element('img', { alt: '', width: 256, height: 256, decoding: 'async' });
    const origin = element('span', { className: 'hint' });
    const button = element('button', { type: 'button', className: 'terrain' }, picture, element('span', { className: 'number', textContent: String(i + 1) }), origin);
    button.setAttribute('aria-pressed', 'false');
    button.setAttribute('aria-keyshortcuts', KEYS[i] ?? '');
    button.addEventListener('click', () => this.#choose(i));
    button.addEventListener('dblclick', () => {
      this.#chosen = [i];
      void this.#guarded(() => this.#next());
    });
    this.#cards.push({ button, picture, origin });
    return button;
  }

  #key(event: KeyboardEvent): void {
    if (event.altKey || (event.target instanceof Element && event.target.closest('select, input'))) return;
    const key = event.key.toLowerCase();
    if ((event.ctrlKey || event.metaKey) && key === 'z') {
      event.preventDefault();
      return this.#actions.undo.click();
    }
    if (event.ctrlKey || event.metaKey) return;
    const i = KEYS.indexOf(event.key);
    const named = { u: 'undo', k: 'keep', w: 'world', f: 'family' } as const;
    const action = named[key as keyof typeof named];
    const onButton = event.target instanceof Element && event.target.closest('button:not(.terrain)');
    if (i >= 0 && event.key.length === 1) this.#choose(i);
    else if (action) this.#actions[action].click();
    else if (event.key === 'Enter' && !onButton && this.#chosen.length > 0) this.#actions.next.click();
    else if (event.key.startsWith('Arrow')) this.#step(event.key);
    else return;
    event.preventDefault();
  }

  /** Arrow keys go from terrain to terrain, whatever the number of columns. */
  #step(key: string): void {
    const buttons = this.#cards.map(({ button }) => button);
    const at = buttons.findIndex((button) => button === document.activeElement);
    const columns = buttons.filter(({ offsetTop }) => offsetTop === buttons[0]?.offsetTop).length;
    const by = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -columns, ArrowDown: columns }[key] ?? 0;
    buttons[at < 0 ? 0 : at + by]?.focus();
  }

  /** One at a time; what went wrong is said. */
  async #guarded(run: () => Promise<void>): Promise<void> {
    if (this.#busy) return;
    this.#busy = true;
    this.#dialog.setAttribute('aria-busy', 'true');
    try {
      await run();
    } catch (error) {
      const faults = error instanceof Problem ? error.faults.map(({ pointer, detail }) => `${pointer}: ${detail}`) : [];
      this.#say([message(error), ...faults].join(' '), true);
    } finally {
      this.#busy = false;
      this.#dialog.removeAttribute('aria-busy');
      this.#draw();
    }
  }

  #say(text: string, isError = false): void {
    this.#status.textContent = text;
    this.#status.className = isError ? 'error' : '';
  }

  async #list(): Promise<string[]> {
    const known = (await sessions()).map(({ name }) => name);
    this.#select.replaceChildren(...known.map((name) => new Option(name, name)));
    if (this.#name) this.#select.value = this.#name;
    return known;
  }

  async #begin(): Promise<void> {
    const seed = Math.floor(Math.random() * 2 ** 32);
    await this.#add(newRecord(seed), `session-${seed.toString(36)}`);
    this.#say('Choose one or two of these.');
  }

  async #add(record: SessionRecord, name: string): Promise<void> {
    await createSession(name, record);
    this.#name = name;
    await this.#list();
    await this.#open(name);
  }

  async #open(name: string): Promise<void> {
    const { record, etag } = await readSession(name);
    [this.#name, this.#record, this.#etag, this.#generations] = [name, record, etag, []];
    this.#select.value = name;
    localStorage.setItem(PLACE, JSON.stringify({ name, open: true }));
    await this.#look(record.choices.length);
  }

  /** Shows a generation. */
  async #look(generation: number): Promise<void> {
    this.#generations[generation] ??= await readGeneration(this.#name ?? '', generation);
    this.#shown = generation;
    this.#chosen = [...(this.#record.choices[generation]?.parents ?? [])];
    this.#draw();
    this.#say(generation === this.#record.choices.length ? 'Choose one or two: Enter breeds their children.' : `Generation ${generation + 1} of ${this.#record.choices.length + 1}: choose others to go another way from here.`);
  }

  #choose(i: number): void {
    const others = this.#chosen.filter((other) => other !== i);
    // The older of two makes room.
    this.#chosen = others.length < this.#chosen.length ? others : [...others.slice(-1), i];
    this.#draw();
  }

  async #save(record: SessionRecord): Promise<void> {
    this.#etag = await saveSession(this.#name ?? '', record, this.#etag);
    const shared = record.choices.findIndex((choice, i) => JSON.stringify(choice) !== JSON.stringify(this.#record.choices[i]));
    this.#generations.length = Math.min(this.#generations.length, (shared < 0 ? record.choices.length : shared) + 1);
    this.#record = record;
  }

  async #next(): Promise<void> {
    if (this.#chosen.length === 0) return this.#say('Choose one or two first.');
    if (this.#shown < this.#record.choices.length - 1) {
      const reply = await ask({
        title: 'Go another way?',
        text: `The ${this.#record.choices.length - this.#shown} generations after this one are given up, or kept in a session of their own.`,
        answers: [{ id: 'cancel', label: 'Cancel' }, { id: 'over', label: 'Give them up' }, { id: 'branch', label: 'Keep both', primary: true }],
      });
      if (reply?.answer === 'branch') return this.#add(bred(this.#record, this.#shown, this.#chosen), await this.#branchName());
      if (reply?.answer !== 'over') return;
    }
    await this.#save(bred(this.#record, this.#shown, this.#chosen));
    await this.#look(this.#shown + 1);
  }

  async #branchName(): Promise<string> {
    const known = await this.#list();
    const stem = (this.#name ?? 'session').replace(/-branch-\d+$/, '').slice(0, 50);
    for (let i = 1; ; i++) if (!known.includes(`${stem}-branch-${i}`)) return `${stem}-branch-${i}`;
  }

  async #undo(): Promise<void> {
    const last = this.#record.choices.length;
    if (last === 0) return this.#say('This is the first generation.');
    const undone = this.#record.choices[last - 1];
    await this.#save(upTo(this.#record, last - 1));
    await this.#look(last - 1);
    this.#chosen = [...(undone?.parents ?? [])];
    this.#say('The newest generation is taken back.');
  }

  /** The one that is chosen last. */
  get #one(): number | undefined {
    return this.#chosen.at(-1);
  }

  async #keep(): Promise<void> {
    const i = this.#one;
    const individual = i === undefined ? undefined : this.#generations[this.#shown]?.individuals[i];
    if (i === undefined || !individual) return this.#say('Choose what to keep first.');
    const reply = await ask({
      title: 'Keep this terrain',
      text: 'It stays with the session, and can go into the library of programmes.',
      lines: [{ label: 'Name', value: `terrain-${this.#shown + 1}-${i + 1}`, ...NAME }],
      answers: [{ id: 'cancel', label: 'Cancel' }, { id: 'library', label: 'Also to the library' }, { id: 'keep', label: 'Keep', primary: true }],
    });
    const name = reply?.texts[0];
    if (!name || (reply?.answer !== 'keep' && reply?.answer !== 'library')) return;
    const kept = { name, generation: this.#shown, individual: i, programme: individual.programme };
    await this.#save({ ...this.#record, kept: [...this.#record.kept.filter((other) => other.name !== name), kept] });
    if (reply.answer === 'library') {
      const { base, seed } = worldOf(individual, this.#generations[this.#shown]?.seed ?? 0, name) as { base: Record<string, number>; seed: number };
      await createProgramme(name, { title: name, origin: `bred in ${this.#name}`, seed, programme: individual.programme, scale: base['scale'] ?? 1, amplitude: base['amplitude'] ?? 1, datum: base['datum'] ?? 0 });
    }
    this.#say(reply.answer === 'library' ? `Kept ${name}, in the library too.` : `Kept ${name}.`);
  }

  async #makeWorld(): Promise<void> {
    const i = this.#one;
    const generation = this.#generations[this.#shown];
    const individual = i === undefined ? undefined : generation?.individuals[i];
    if (!individual || !generation) return this.#say('Choose what to make a world of first.');
    let value = `bred-${this.#shown + 1}-${(i ?? 0) + 1}`;
    let error: string | undefined;
    for (;;) {
      const reply = await ask({
        title: 'Make a world of it',
        text: 'The name becomes part of its address and cannot be changed.',
        lines: [{ label: 'Name', value, ...NAME, ...(error ? { error } : {}) }],
        answers: [{ id: 'cancel', label: 'Cancel' }, { id: 'create', label: 'Create', primary: true }],
      });
      if (reply?.answer !== 'create') return;
      value = reply.texts[0] ?? '';
      try {
        await createWorld(value, worldOf(individual, generation.seed, value));
        this.#dialog.close();
        return this.events.created(value);
      } catch (problem) {
        if (!(problem instanceof Problem) || problem.status !== 409) throw problem;
        error = problem.message;
      }
    }
  }

  async #family(): Promise<void> {
    const i = this.#one;
    if (i === undefined) return this.#say('Choose whose family first.');
    for (let g = 0; g <= this.#shown; g++) this.#generations[g] ??= await readGeneration(this.#name ?? '', g);
    const rows = ancestors(this.#generations, this.#shown, i).map(({ generation, individuals }) => {
      const pictures = individuals.map((individual) => {
        const { origin } = this.#generations[generation]?.individuals[individual] ?? { origin: 'grown' as const };
        return element('figure', {}, this.#thumbnail(generation, individual), element('figcaption', { textContent: `${individual + 1}: ${told(origin)}` }));
      });
      return element('li', {}, element('span', { textContent: `Generation ${generation + 1}` }), element('div', {}, ...pictures));
    });
    const heading = element('h2', { id: 'family-title', textContent: 'Family tree' });
    const form = element('form', { method: 'dialog' }, heading, element('ol', { className: 'family' }, ...rows), element('div', { className: 'actions' }, element('button', { className: 'primary', textContent: 'Close' })));
    const dialog = element('dialog', { className: 'family-tree' }, form);
    dialog.setAttribute('aria-labelledby', heading.id);
    this.#dialog.append(dialog);
    dialog.addEventListener('close', () => dialog.remove());
    dialog.showModal();
  }

  async #delete(): Promise<void> {
    const name = this.#name;
    if (!name) return;
    const reply = await ask({
      title: `Delete ${name}?`,
      text: 'Its generations and what it keeps are gone; worlds and programmes made of it stay.',
      answers: [{ id: 'keep', label: 'Keep it', primary: true }, { id: 'delete', label: 'Delete' }],
    });
    if (reply?.answer !== 'delete') return;
    await deleteSession(name);
    this.#name = undefined;
    const [next] = await this.#list();
    if (next === undefined) await this.#begin();
    else await this.#open(next);
  }

  #export(): void {
    const url = URL.createObjectURL(new Blob([JSON.stringify(this.#record, null, 2)], { type: 'application/json' }));
    element('a', { href: url, download: `${this.#name}.json` }).click();
    URL.revokeObjectURL(url);
  }

  async #import(file: HTMLInputElement): Promise<void> {
    const chosen = file.files?.[0];
    file.value = '';
    if (!chosen) return;
    const record = JSON.parse(await chosen.text()) as SessionRecord;
    const known = await this.#list();
    let name = slug(chosen.name.replace(/\.json$/i, '')) || 'imported';
    while (known.includes(name)) name = `${name.slice(0, 55)}-again`;
    await this.#add(record, name);
  }

  #thumbnail(generation: number, individual: number): HTMLImageElement {
    const picture = element('img', { alt: `Terrain ${individual + 1} of generation ${generation + 1}`, width: 96, height: 96 });
    this.#fill(picture, generation, individual);
    return picture;
  }

  /** The address changes with what is shown, so that no old picture is. */
  #fill(picture: HTMLImageElement, generation: number, individual: number): void {
    const path = this.#record.choices.slice(0, generation).map(({ parents, again }) => `${parents.join('.')}_${again ?? 0}`).join('-');
    const url = `breeding/${this.#name}/generations/${generation}/${individual}/picture.png#${this.#record.seed}-${path}`;
    if (picture.dataset['address'] === url) return;
    picture.dataset['address'] = url;
    if (!hasKey()) picture.src = url;
    else void keyedPicture(url).then((made) => (picture.src = made), () => {});
  }

  #draw(): void {
    const generation = this.#generations[this.#shown];
    this.#cards.forEach(({ button, picture, origin }, i) => {
      const individual = generation?.individuals[i];
      button.setAttribute('aria-pressed', String(this.#chosen.includes(i)));
      if (!individual) return;
      button.setAttribute('aria-label', `Terrain ${i + 1}, ${told(individual.origin)}`);
      button.title = individual.programme;
      origin.textContent = told(individual.origin);
      this.#fill(picture, this.#shown, i);
    });
    const none = this.#chosen.length === 0;
    for (const name of ['next', 'keep', 'world', 'family'] as const) this.#actions[name].disabled = none;
    this.#actions.undo.disabled = this.#record.choices.length === 0;
    const again = this.#record.choices[this.#shown]?.parents.join() === this.#chosen.join() && !none;
    this.#actions.next.textContent = again ? 'Other children' : 'Next generation';
    this.#drawHistory();
    this.#kept.replaceChildren(...this.#record.kept.map((kept) => {
      const show = element('button', { type: 'button', textContent: kept.name });
      show.addEventListener('click', () => void this.#guarded(async () => {
        const there = this.#record.choices.length >= kept.generation;
        await this.#look(there ? kept.generation : this.#record.choices.length);
        if (this.#generations[this.#shown]?.individuals[kept.individual]?.programme === kept.programme) this.#chosen = [kept.individual];
        else this.#say(`${kept.name} comes from generations that were given up: ${kept.programme}`);
      }));
      return element('li', {}, show);
    }));
    if (this.#record.kept.length === 0) this.#kept.replaceChildren(element('li', { className: 'hint', textContent: 'Nothing yet.' }));
  }

  #drawHistory(): void {
    const steps = [...this.#record.choices, undefined].map((choice, g) => {
      const button = element('button', { type: 'button' }, ...(choice?.parents.map((parent) => this.#thumbnail(g, parent)) ?? []), element('span', { textContent: `${g + 1}` }));
      button.setAttribute('aria-label', `Generation ${g + 1}`);
      if (g === this.#shown) button.setAttribute('aria-current', 'step');
      button.addEventListener('click', () => void this.#guarded(() => this.#look(g)));
      return element('li', {}, button);
    });
    this.#strip.replaceChildren(...steps);
  }
}
