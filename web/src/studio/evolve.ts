import {
  Problem, askJob, createProgramme, createSession, createWorld, forgetJob, jobs, keyedPicture, readEvolution, readJob, resumeJob, stopJob,
  type Best, type Evolution, type GenerationPoint, type Job,
} from '../api.ts';
import { ask, element } from '../dialog.ts';
import { NAME } from '../text.ts';
import { CRITERIA, wishOf, workOf } from './aim.ts';
import { FitnessCurve } from './fitness.ts';
import { newRecord } from './record.ts';
import { switcher, type StudioEvents } from './switcher.ts';
import { WishForm } from './wish-form.ts';

const PLACE = 'terrane-evolve';
const WAIT_MS = 400;

const message = (error: unknown) => (error instanceof Error ? error.message : String(error));
const pause = (ms: number) => new Promise((resolve) => setTimeout(resolve, ms));

interface Kept {
  job?: string | undefined;
  open?: boolean;
}

const kept = (): Kept => JSON.parse(localStorage.getItem(PLACE) ?? '{}') as Kept;

/** Programmes bred towards what is wanted, by a job of the server: what is asked for, how it goes, and what is done with what it finds. */
export class Evolve {
  readonly #dialog = element('dialog', { className: 'studio evolve', tabIndex: -1 });
  readonly #select = element('select', { id: 'evolve-job' });
  readonly #form: WishForm;
  readonly #live = element('div', { className: 'evolve-live', hidden: true });
  readonly #picture = element('img', { id: 'evolve-best', width: 512, height: 512, alt: '' });
  readonly #progress = element('p', { id: 'evolve-progress' });
  readonly #bar = element('progress', { max: 1 });
  readonly #scores = element('table', { id: 'evolve-scores' });
  readonly #programme = element('code', { id: 'evolve-programme' });
  readonly #curve = new FitnessCurve();
  readonly #status = element('p', { id: 'evolve-status' });
  readonly #actions: Record<'stop' | 'resume' | 'keep' | 'world' | 'breed' | 'again' | 'delete', HTMLButtonElement>;
  #job: Job | undefined;
  #points: GenerationPoint[] = [];
  #best: Best | undefined;
  #shownBest = '';
  /** Which following is the present one: others end. */
  #following = 0;
  #busy = false;

  constructor(readonly events: StudioEvents) {
    this.#form = new WishForm(() => void this.#guarded(() => this.#start()), () => events.place());
    const action = (id: string, label: string, title: string, run: () => Promise<void>) => {
      const button = element('button', { type: 'button', id: `evolve-${id}`, textContent: label, title });
      button.addEventListener('click', () => void this.#guarded(run));
      return button;
    };
    this.#actions = {
      stop: action('stop', 'Stop', 'Lay it aside: it goes on from its last generation (S)', () => this.#stop()),
      resume: action('resume', 'Resume', 'Go on from the last generation (S)', () => this.#resume()),
      keep: action('keep', 'Keep…', 'Put the best into the library of programmes (K)', () => this.#keep()),
      world: action('world', 'Make a world…', 'Make a world of the best (W)', () => this.#makeWorld()),
      breed: action('breed', 'Breed from it', 'Take the best into breeding by eye', () => this.#breed()),
      again: action('again', 'New evolution…', 'Ask for another one, beginning with this one’s wishes (N)', async () => this.#showForm()),
      delete: action('delete', 'Delete…', 'Forget this evolution', () => this.#delete()),
    };
    const close = element('button', { type: 'button', className: 'quiet', textContent: 'Close' });
    close.addEventListener('click', () => this.#dialog.close());
    const heading = element('h2', { id: 'evolve-title', textContent: 'Evolve terrain' });
    const label = element('label', { className: 'visually-hidden', htmlFor: 'evolve-job', textContent: 'Evolution' });
    const views = switcher('evolve', () => {
      this.#dialog.close();
      this.events.breed();
    });
    this.#status.setAttribute('role', 'status');
    this.#bar.setAttribute('aria-labelledby', this.#progress.id);
    const details = element('details', {}, element('summary', { textContent: 'The best programme' }), this.#programme);
    this.#live.append(
      element('figure', {}, this.#picture, element('figcaption', { className: 'hint', textContent: 'The best so far, over the square that is judged' })),
      element('div', { className: 'evolve-how' }, this.#progress, this.#bar, this.#curve.element,
        element('p', { className: 'legend hint' }, element('span', { className: 'best', textContent: '— best' }), ' ', element('span', { className: 'mean', textContent: '— mean of all' })),
        this.#scores, details),
    );
    this.#dialog.append(
      element('div', { className: 'studio-head' }, heading, views, label, this.#select, this.#actions.again, this.#actions.delete, close),
      element('div', { className: 'evolve-body' }, this.#form.element, this.#live),
      element('div', { className: 'studio-foot' }, this.#status, element('div', { className: 'actions' },
        this.#actions.stop, this.#actions.resume, this.#actions.breed, this.#actions.keep, this.#actions.world)),
    );
    this.#dialog.setAttribute('aria-labelledby', heading.id);
    this.#select.addEventListener('change', () => void this.#guarded(() => (this.#select.value ? this.#open(this.#select.value) : Promise.resolve(this.#showForm()))));
    this.#dialog.addEventListener('keydown', (event) => this.#key(event));
    this.#dialog.addEventListener('close', () => {
      this.#following++;
      localStorage.setItem(PLACE, JSON.stringify({ ...kept(), open: false }));
      this.#dialog.remove();
    });
  }

  /** Whether the page was left with it open. */
  static get wasOpen(): boolean {
    return kept().open === true;
  }

  async show(): Promise<void> {
    document.body.append(this.#dialog);
    this.#dialog.showModal();
    await this.#guarded(async () => {
      await this.#form.listWorlds(this.events.world());
      const last = kept().job;
      const known = await this.#list();
      if (last && known.some(({ id }) => id === last)) await this.#open(last);
      else this.#showForm();
    });
  }

  #key(event: KeyboardEvent): void {
    if (event.altKey || event.ctrlKey || event.metaKey || (event.target instanceof Element && event.target.closest('select, input, textarea'))) return;
    const { stop, resume, keep, world, again } = this.#actions;
    const button = { s: stop.hidden ? resume : stop, k: keep, w: world, n: again }[event.key.toLowerCase()];
    if (!button || button.disabled || button.hidden || this.#live.hidden) return;
    event.preventDefault();
    button.click();
  }

  /** One at a time; what went wrong is said, at its field where there is one. */
  async #guarded(run: () => Promise<void>): Promise<void> {
    if (this.#busy) return;
    this.#busy = true;
    this.#dialog.setAttribute('aria-busy', 'true');
    try {
      await run();
    } catch (error) {
      const faults = error instanceof Problem ? error.faults : [];
      const others = this.#form.element.hidden ? faults : this.#form.showFaults(faults);
      this.#say([message(error), ...others.map(({ pointer, detail }) => `${pointer}: ${detail}`)].join(' '), true);
    } finally {
      this.#busy = false;
      this.#dialog.removeAttribute('aria-busy');
      this.#draw();
      this.#holdFocus();
    }
  }

  /** Keys are heard where the focus is: when what had it is gone, the page has it. */
  #holdFocus(): void {
    const active = document.activeElement;
    const isLost = !active || active === document.body || (this.#dialog.contains(active) && active.getClientRects().length === 0);
    if (isLost && this.#dialog.open) this.#dialog.focus();
  }

  #say(text: string, isError = false): void {
    if (this.#status.textContent !== text) this.#status.textContent = text;
    this.#status.className = isError ? 'error' : '';
  }

  async #list(): Promise<Job[]> {
    const known = (await jobs()).filter(({ kind }) => kind === 'evolution');
    const name = ({ id, time, state }: Job) => `${time.slice(0, 16).replace('T', ' ')} · ${state} · ${id.slice(0, 6)}`;
    this.#select.replaceChildren(new Option('New evolution', ''), ...known.map((job) => new Option(name(job), job.id)));
    this.#select.value = this.#job?.id ?? '';
    return known;
  }

  #showForm(): void {
    this.#following++;
    this.#job = undefined;
    this.#select.value = '';
    this.#form.element.hidden = false;
    this.#live.hidden = true;
    localStorage.setItem(PLACE, JSON.stringify({ open: true }));
    this.#say('Say what is wanted: programmes are bred towards it.');
    this.#form.element.querySelector<HTMLElement>('input')?.focus();
    this.#draw();
  }

  async #start(): Promise<void> {
    this.#form.showFaults([]);
    const job = await askJob(workOf(this.#form.wish));
    this.#job = job;
    await this.#list();
    await this.#open(job.id);
  }

  async #open(id: string): Promise<void> {
    const job = await readJob(id);
    [this.#job, this.#points, this.#best] = [job, [], undefined];
    if (job.work) this.#form.wish = wishOf(job.work);
    this.#select.value = id;
    this.#form.element.hidden = true;
    this.#live.hidden = false;
    localStorage.setItem(PLACE, JSON.stringify({ job: id, open: true }));
    await this.#look(job);
    (this.#actions.stop.hidden ? this.#actions.world : this.#actions.stop).focus();
    void this.#follow(id);
  }

  /** Looks at it until it ends, is laid aside, or something else is shown. */
  async #follow(id: string): Promise<void> {
    const following = ++this.#following;
    while (this.#job?.state === 'waiting' || this.#job?.state === 'running') {
      await pause(WAIT_MS);
      if (following !== this.#following) return;
      try {
        const job = await readJob(id);
        if (following !== this.#following) return;
        await this.#look(job);
      } catch (error) {
        if (following !== this.#following) return;
        this.#say(`${message(error)} Looking again…`, true);
        if (error instanceof Problem && error.status === 404) return this.#showForm();
        await pause(5 * WAIT_MS); // busy or away: the job is kept
      }
    }
    if (following === this.#following) await this.#list();
  }

  async #look(job: Job): Promise<void> {
    const seen: Evolution = await readEvolution(job.id, this.#points.length);
    this.#job = job;
    this.#points.push(...seen.curve.slice(Math.max(0, this.#points.length - (seen.curve[0]?.generation ?? 0))));
    this.#best = seen.best;
    this.#curve.show(this.#points, seen.of);
    const last = this.#points.at(-1);
    const words = { waiting: 'waits for its turn', running: 'is under way', stopped: 'is stopped', done: 'is done', failed: 'failed' };
    this.#progress.textContent = last
      ? `Generation ${last.generation} of ${seen.of}, ${last.evaluations.toLocaleString('en')} programmes judged`
      : `No generation of ${seen.of} yet`;
    this.#bar.value = job.state === 'done' ? 1 : job.progress;
    this.#say(`The evolution ${words[job.state]}.${job.failure ? ` ${job.failure}` : ''}`, job.state === 'failed');
    this.#draw();
    this.#holdFocus();
    await this.#showPicture();
  }

  async #showPicture(): Promise<void> {
    const [job, best] = [this.#job, this.#best];
    const shown = job && best ? `${job.id} ${best.programme} ${best.generation}` : '';
    if (shown === this.#shownBest) return;
    this.#shownBest = shown;
    if (!job || !best) return this.#picture.removeAttribute('src');
    const url = await keyedPicture(`jobs/${job.id}/best.png?size=512`);
    if (this.#picture.src) URL.revokeObjectURL(this.#picture.src);
    this.#picture.src = url;
    this.#picture.alt = `Relief of the best programme, score ${best.score.toFixed(3)}`;
  }

  #draw(): void {
    const state = this.#live.hidden ? undefined : this.#job?.state;
    const { stop, resume, keep, world, breed, again } = this.#actions;
    const isOpen = state === 'waiting' || state === 'running';
    stop.hidden = !isOpen;
    resume.hidden = state !== 'stopped';
    this.#actions.delete.hidden = again.hidden = state === undefined;
    for (const button of [keep, world, breed]) {
      button.hidden = state === undefined;
      button.disabled = !this.#best;
    }
    this.#programme.textContent = this.#best?.programme ?? '';
    const rows = (this.#best?.criteria ?? []).map(({ criterion, weight, score }) => {
      const name = CRITERIA.find(({ name }) => name === criterion)?.label ?? criterion;
      const meter = element('meter', { min: 0, max: 1, value: score });
      meter.setAttribute('aria-label', name);
      return element('tr', {}, element('th', { scope: 'row', textContent: name }), element('td', { textContent: `× ${weight}` }), element('td', {}, meter), element('td', { className: 'number', textContent: score.toFixed(3) }));
    });
    const all = this.#best ? [element('tr', { className: 'all' }, element('th', { scope: 'row', textContent: `All, found in generation ${this.#best.generation}` }), element('td'), element('td'), element('td', { className: 'number', textContent: this.#best.score.toFixed(3) }))] : [];
    this.#scores.replaceChildren(...rows, ...all);
  }

  get #id(): string {
    return this.#job?.id ?? '';
  }

  async #stop(): Promise<void> {
    this.#following++;
    await this.#look(await stopJob(this.#id));
    await this.#list();
    this.#actions.resume.focus();
  }

  async #resume(): Promise<void> {
    await this.#look(await resumeJob(this.#id));
    this.#actions.stop.focus();
    void this.#follow(this.#id);
  }

  async #delete(): Promise<void> {
    const reply = await ask({
      title: 'Delete this evolution?',
      text: 'What it found is gone; worlds and programmes made of it stay.',
      answers: [{ id: 'keep', label: 'Keep it', primary: true }, { id: 'delete', label: 'Delete' }],
    });
    if (reply?.answer !== 'delete') return;
    await forgetJob(this.#id);
    this.#showForm();
    await this.#list();
  }

  /** Asks for a name until it is free. */
  async #named(title: string, text: string, make: (name: string) => Promise<void>): Promise<string | undefined> {
    let value = `evolved-${this.#id.slice(0, 6)}`;
    let error: string | undefined;
    for (;;) {
      const reply = await ask({ title, text, lines: [{ label: 'Name', value, ...NAME, ...(error ? { error } : {}) }], answers: [{ id: 'cancel', label: 'Cancel' }, { id: 'make', label: 'Keep', primary: true }] });
      if (reply?.answer !== 'make') return undefined;
      value = reply.texts[0] ?? '';
      try {
        await make(value);
        return value;
      } catch (problem) {
        if (!(problem instanceof Problem) || problem.status !== 409) throw problem;
        error = problem.message;
      }
    }
  }

  async #keep(): Promise<void> {
    const best = this.#best;
    if (!best) return;
    const { seed, programme, scale, amplitude, datum } = best;
    const origin = `evolved, score ${best.score.toFixed(3)}`;
    const name = await this.#named('Keep the best', 'It goes into the library of programmes.', (name) => createProgramme(name, { title: name, origin, seed, programme, scale, amplitude, datum }));
    if (name) this.#say(`Kept ${name} in the library.`);
  }

  async #makeWorld(): Promise<void> {
    const best = this.#best;
    if (!best) return;
    const { seed, programme, scale, amplitude, datum } = best;
    const name = await this.#named('Make a world of it', 'The name becomes part of its address and cannot be changed.', (name) => createWorld(name, { title: name, seed, base: { programme, scale, amplitude, datum } }));
    if (name === undefined) return;
    this.#dialog.close();
    this.events.created(name);
  }

  /** The best as the first of a session's first generation: its noises are drawn anew there. */
  async #breed(): Promise<void> {
    if (!this.#best) return;
    const record = { ...newRecord(Math.floor(Math.random() * 2 ** 32)), programmes: [this.#best.programme] };
    const name = `evolved-${record.seed.toString(36)}`;
    await createSession(name, record);
    this.#dialog.close();
    this.events.breed(name);
  }
}

