import {
  Problem, askJob, forgetJob, jobs, previewJob, readJob, readWorld, saveWorld, type Job, type JobPreview, type JsonObject, type Stored,
} from '../api.ts';
import { ask, element } from '../dialog.ts';
import type { TerrainMap } from '../map.ts';
import { slug } from '../text.ts';
import { CurveEditor } from './curve.ts';
import { PROFILES, emptySketch, fromWork, toWork, type Curve, type Detail, type Kind, type Sketch, type Stroke } from './model.ts';
import { Pen } from './pen.ts';
import { ended } from './work.ts';

export interface PanelEvents {
  /** A new revision of the world is stored. */
  saved(name: string, stored: Stored): void;
}

/** Milliseconds without a change before a preview is asked for. */
const CALM_MS = 350;
const MOST_UNDONE = 100;

const KINDS: Record<Kind, { label: string; key: string; hint: string }> = {
  line: { label: 'Ridge line', key: 'l', hint: 'Click along the crest; double-click or Enter ends it.' },
  point: { label: 'Peak', key: 'k', hint: 'Click where a peak stands.' },
  area: { label: 'Plateau', key: 'a', hint: 'Click around the plateau; double-click or Enter ends it.' },
};

const NAMES: Record<string, string> = {
  mountain: 'Mountain', ridge: 'Sharp ridge', hill: 'Rounded hill', cone: 'Straight slope', mesa: 'Mesa', terraces: 'Terraces', own: 'My own curve',
};

/** The profile that the curve editor makes. */
const OWN = 'own';

const message = (error: unknown) => (error instanceof Error ? error.message : String(error));
const metres = (value: number) => `${Math.round(value).toLocaleString('en')} m`;

/** A layer of a world that shows what was drawn. */
interface DrawnLayer {
  name: string;
  hash: string;
}

/** What outlives the page: the sketch, the layer it belongs to, and the job that makes it. */
interface Kept {
  sketch: Sketch;
  layer?: string | undefined;
  job?: string | undefined;
}

const hashOf = (layer: JsonObject): string | undefined =>
  ((layer['source'] as JsonObject | undefined)?.['raster'] as JsonObject | undefined)?.['hash'] as string | undefined;

function drawnLayers(document: JsonObject): DrawnLayer[] {
  const layers = (document['layers'] ?? []) as JsonObject[];
  return layers.flatMap((layer) => {
    const hash = hashOf(layer);
    return hash === undefined ? [] : [{ name: String(layer['name']), hash }];
  });
}

/** Mountains drawn on the map: strokes, what they become, and the job that makes them part of the world. */
export class DrawPanel {
  readonly #pen: Pen;
  readonly #curve = new CurveEditor((curve, settled) => this.#reshape(curve, settled));
  #world = '';
  #sketch = emptySketch();
  #layer: string | undefined;
  #chosen: number | undefined;
  /** What the next stroke is like. */
  #next = { profile: 'mountain', height: 0, width: 0 };
  #kind: Kind | undefined;
  #undone: string[] = [];
  #before = '';
  #job: string | undefined;
  #asked = 0;
  #timer: number | undefined;
  #open = false;

  constructor(
    readonly root: HTMLElement,
    readonly terrain: TerrainMap,
    readonly events: PanelEvents,
  ) {
    this.#pen = new Pen(terrain, {
      drawn: (kind, points) => this.#drawn(kind, points),
      bent: (stroke, points, settled) => this.#bend(stroke, points, settled),
      chosen: (stroke) => this.#choose(stroke),
      drawing: (corners) => this.#showDrawing(corners),
    });
    this.#find('#curve').append(this.#curve.element);
    this.#find<HTMLSelectElement>('#stroke-profile').append(...[...Object.keys(PROFILES), OWN].map((name) => new Option(NAMES[name] ?? name, name)));
    this.#listen();
  }

  async show(world: string): Promise<void> {
    this.#open = true;
    if (world !== this.#world) this.#recall(world);
    this.#draw();
    this.#ask();
    await this.#showLayers();
    if (this.#job) void this.#follow(this.#job);
  }

  hide(): void {
    this.#open = false;
    this.#use(undefined);
    this.#pen.hide();
  }

  /** Keys that draw; true if one was meant for this. */
  key(event: KeyboardEvent): boolean {
    const { key } = event;
    const kind = (Object.keys(KINDS) as Kind[]).find((kind) => KINDS[kind].key === key.toLowerCase());
    if (kind) this.#use(this.#kind === kind ? undefined : kind);
    else if (key === 'Enter' && this.#kind) this.#pen.finish();
    else if (key === 'Escape' && this.#kind) this.#use(undefined);
    else if ((key === 'p' || key === 'P') && this.#kind) this.#pen.addAtCentre();
    else if ((key === 'Delete' || key === 'Backspace') && !this.#kind && this.#chosen !== undefined) this.#remove();
    else if (key === 'Backspace' && this.#kind) this.#pen.back();
    else return false;
    return true;
  }

  undo(): void {
    if (this.#kind && this.#pen.back()) return;
    const last = this.#undone.pop();
    if (last === undefined) return;
    this.#sketch = JSON.parse(last) as Sketch;
    this.#before = last;
    this.#chosen = undefined;
    this.#keep();
    this.#draw();
    this.#ask();
  }

  #find<E extends HTMLElement = HTMLElement>(selector: string): E {
    const found = this.root.querySelector<E>(selector);
    if (!found) throw new Error(`the page has no ${selector}`);
    return found;
  }

  #listen(): void {
    for (const kind of Object.keys(KINDS) as Kind[]) {
      this.#find(`#pen-${kind}`).addEventListener('click', () => this.#use(this.#kind === kind ? undefined : kind));
    }
    this.#find('#pen-finish').addEventListener('click', () => this.#pen.finish());
    this.#find('#pen-centre').addEventListener('click', () => this.#pen.addAtCentre());
    this.#find('#draw-undo').addEventListener('click', () => this.undo());
    this.#find('#stroke-remove').addEventListener('click', () => this.#remove());
    this.#find('#draw-clear').addEventListener('click', () => void this.#clear());
    this.#find('#draw-make').addEventListener('click', () => void this.#make());
    this.#find('#draw-cancel').addEventListener('click', () => void this.#cancel());
    for (const [id, set] of [['#stroke-height', 'height'], ['#stroke-width', 'width']] as const) {
      this.#find<HTMLInputElement>(id).addEventListener('input', (event) => {
        const value = Number((event.target as HTMLInputElement).value);
        if (value > 0 && value <= 1e6) this.#restyle({ [set]: value });
      });
    }
    this.#find<HTMLSelectElement>('#stroke-profile').addEventListener('change', (event) => this.#restyle({ profile: (event.target as HTMLSelectElement).value }));
    for (const setting of ['roughness', 'bias', 'ridges', 'seed'] as const) {
      const input = this.#find<HTMLInputElement>(`#draw-${setting}`);
      input.addEventListener('input', () => {
        if (input.checkValidity() && input.value !== '') this.#change({ ...this.#sketch, [setting]: Number(input.value) });
      });
    }
    const title = this.#find<HTMLInputElement>('#draw-title');
    title.addEventListener('input', () => this.#change({ ...this.#sketch, title: title.value }));
    const detail = this.#find<HTMLSelectElement>('#draw-detail');
    detail.addEventListener('change', () => this.#change({ ...this.#sketch, detail: detail.value as Detail }));
  }

  /** Takes up what was drawn in this world before. */
  #recall(world: string): void {
    this.#world = world;
    this.#undone = [];
    this.#chosen = undefined;
    const kept = localStorage.getItem(`terrane-sketch-${world}`);
    try {
      const { sketch, layer, job } = kept ? (JSON.parse(kept) as Kept) : { sketch: emptySketch() };
      this.#sketch = { ...emptySketch(), ...sketch };
      [this.#layer, this.#job] = [layer, job];
    } catch {
      this.#sketch = emptySketch(); // another version of the page kept something else
      [this.#layer, this.#job] = [undefined, undefined];
    }
    this.#before = JSON.stringify(this.#sketch);
  }

  #keep(): void {
    const kept: Kept = { sketch: this.#sketch, layer: this.#layer, job: this.#job };
    localStorage.setItem(`terrane-sketch-${this.#world}`, JSON.stringify(kept));
  }

  /** Changes the sketch; what is not settled, as in the middle of a drag, is no step to go back to and is not previewed yet. */
  #change(sketch: Sketch, settled = true): void {
    this.#sketch = sketch;
    if (settled) {
      const now = JSON.stringify(sketch);
      if (now !== this.#before) this.#undone = [...this.#undone.slice(1 - MOST_UNDONE), this.#before];
      this.#before = now;
      this.#keep();
      this.#ask();
    }
    this.#draw();
  }

  #use(kind: Kind | undefined): void {
    this.#kind = kind;
    if (kind) this.#chosen = undefined;
    this.#pen.use(kind);
    for (const other of Object.keys(KINDS) as Kind[]) this.#find(`#pen-${other}`).setAttribute('aria-pressed', String(other === kind));
    if (this.#open) this.#draw();
  }

  #showDrawing(corners: number | undefined): void {
    const drawing = this.#find('#drawing');
    drawing.hidden = corners === undefined;
    this.#find('#drawing-hint').textContent = this.#kind ? KINDS[this.#kind].hint : '';
    this.#find<HTMLButtonElement>('#pen-finish').hidden = this.#kind === 'point';
  }

  /** A stroke gets heights and widths that suit the view, unless one was drawn before. */
  #suited(): { profile: string; height: number; width: number } {
    if (this.#next.height > 0) return this.#next;
    const bounds = this.terrain.map.getBounds();
    const across = ((bounds.getEast() - bounds.getWest()) / 360) * 2 * Math.PI * 6378137;
    const digits = (value: number) => Number(value.toPrecision(1));
    const width = digits(Math.max(1, across / 8));
    return { ...this.#next, width, height: digits(Math.min(width / 4, 3000)) };
  }

  #drawn(kind: Kind, points: Stroke['points']): void {
    this.#next = this.#suited();
    this.#change({ ...this.#sketch, strokes: [...this.#sketch.strokes, { kind, points, ...this.#next }] });
  }

  #bend(stroke: number, points: Stroke['points'], settled: boolean): void {
    const strokes = this.#sketch.strokes.map((old, i) => (i === stroke ? { ...old, points } : old));
    this.#change({ ...this.#sketch, strokes }, settled);
  }

  #choose(stroke: number | undefined): void {
    this.#chosen = stroke === undefined || !this.#sketch.strokes[stroke] ? undefined : stroke;
    this.#draw();
  }

  /** The chosen stroke, or without one the next. */
  get #styled(): { profile: string; height: number; width: number } {
    return (this.#chosen === undefined ? undefined : this.#sketch.strokes[this.#chosen]) ?? this.#suited();
  }

  #restyle(style: Partial<Stroke>): void {
    this.#next = { ...this.#suited(), ...style };
    if (this.#chosen === undefined) return this.#draw();
    const strokes = this.#sketch.strokes.map((stroke, i) => (i === this.#chosen ? { ...stroke, ...style } : stroke));
    this.#change({ ...this.#sketch, strokes });
  }

  #reshape(curve: Curve, settled: boolean): void {
    // The named profiles stay as they are: a changed one is the user's own.
    this.#next = { ...this.#suited(), profile: OWN };
    const strokes = this.#sketch.strokes.map((stroke, i) => (i === this.#chosen ? { ...stroke, profile: OWN } : stroke));
    this.#change({ ...this.#sketch, strokes, profiles: { ...this.#sketch.profiles, [OWN]: curve } }, settled);
  }

  #remove(): void {
    const strokes = this.#sketch.strokes.filter((_, i) => i !== this.#chosen);
    this.#chosen = undefined;
    this.#change({ ...this.#sketch, strokes });
  }

  async #clear(): Promise<void> {
    if (this.#layer !== undefined || this.#sketch.strokes.length > 0) {
      const reply = await ask({
        title: 'Begin a new drawing?',
        text: 'What is drawn now is taken off the map. What you have made of it stays in the world.',
        answers: [{ id: 'keep', label: 'Keep drawing' }, { id: 'new', label: 'New drawing', primary: true }],
      });
      if (reply?.answer !== 'new') return;
    }
    this.#layer = undefined;
    this.#chosen = undefined;
    this.#change(emptySketch());
    await this.#showLayers();
  }

  /** Shows strokes and fields. */
  #draw(): void {
    const sketch = this.#sketch;
    if (this.#open) this.#pen.show(sketch.strokes, this.#chosen);
    const set = (id: string, value: string) => {
      const input = this.#find<HTMLInputElement>(id);
      if (input.value !== value && document.activeElement !== input) input.value = value;
    };
    const styled = this.#styled;
    set('#stroke-height', String(styled.height));
    set('#stroke-width', String(styled.width));
    set('#stroke-profile', styled.profile);
    set('#draw-title', sketch.title);
    set('#draw-detail', sketch.detail);
    for (const setting of ['roughness', 'bias', 'ridges', 'seed'] as const) set(`#draw-${setting}`, String(sketch[setting]));
    this.#curve.curve = sketch.profiles[styled.profile] ?? [[0, 1], [1, 0]];
    this.#find('#stroke-legend').textContent = this.#chosen === undefined ? 'The next stroke' : `Stroke ${this.#chosen + 1} of ${sketch.strokes.length}`;
    this.#find('#stroke-remove').hidden = this.#chosen === undefined;
    this.#find<HTMLButtonElement>('#draw-undo').disabled = this.#undone.length === 0;
    const make = this.#find<HTMLButtonElement>('#draw-make');
    make.disabled = !toWork(sketch) || this.#job !== undefined;
    make.textContent = this.#layer === undefined ? 'Make terrain' : 'Make it anew';
    this.#find('#draw-progress').hidden = this.#job === undefined;
  }

  #status(text: string, kind: 'info' | 'error' = 'info', action?: { label: string; run: () => void }): void {
    const status = this.#find('#draw-status');
    status.className = kind;
    status.replaceChildren(text);
    if (!action) return;
    const button = element('button', { type: 'button', textContent: action.label });
    button.addEventListener('click', action.run);
    status.append(' ', button);
  }

  /** What the server says is wrong, in the words of this form as far as it can be. */
  #refused(error: unknown): void {
    const faults = error instanceof Problem ? error.faults.map(({ pointer, detail }) => `${pointer.replace('/paths/drawing', '')}: ${detail}`) : [];
    this.#status([faults.length > 0 ? 'The drawing cannot be made.' : message(error), ...faults].join(' '), 'error');
  }

  /** Asks for a preview once nothing has changed for a moment. */
  #ask(): void {
    window.clearTimeout(this.#timer);
    const asked = ++this.#asked;
    this.#timer = window.setTimeout(() => void this.#preview(asked), CALM_MS);
  }

  async #preview(asked: number): Promise<void> {
    const work = toWork(this.#sketch);
    if (!work || !this.#open) return this.#pen.preview(undefined);
    let shown: JobPreview;
    try {
      shown = await previewJob(work);
    } catch (error) {
      if (asked === this.#asked && this.#open) this.#refused(error);
      return;
    }
    // An answer that was overtaken by a newer question is not shown.
    if (asked !== this.#asked || !this.#open) return;
    this.#pen.preview({ url: shown.picture, bbox: shown.bbox });
    const spacing = ((work['paths'] as JsonObject)['drawing'] as JsonObject)['spacing'] as number;
    if (!this.#job) this.#status(`Preview: up to ${metres(shown.elevation[1])} above the ground, a height every ${spacing} m.`);
    this.root.dataset['previewed'] = String(asked);
  }

  async #make(): Promise<void> {
    const work = toWork(this.#sketch);
    if (!work || this.#job) return;
    this.#use(undefined);
    this.#status('Asking the server…');
    try {
      const job = await askJob(work);
      this.#job = job.id;
      this.#keep();
      this.#draw();
      await this.#follow(job.id);
    } catch (error) {
      this.#refused(error);
    }
  }

  /** Waits for the job and puts what it makes into the world. */
  async #follow(id: string): Promise<void> {
    const world = this.#world;
    try {
      const job = await ended(id, (job) => this.#showProgress(job));
      if (world !== this.#world || id !== this.#job) return;
      this.#job = undefined;
      this.#keep();
      if (!job || job.state === 'stopped') this.#status('Given up.');
      else if (job.state === 'failed') this.#status(`It could not be made: ${job.failure ?? 'the server does not say why'}`, 'error');
      else await this.#place(job);
    } catch (error) {
      this.#job = undefined;
      this.#refused(error);
    }
    this.#draw();
  }

  #showProgress({ state, progress }: Job): void {
    const bar = this.#find<HTMLProgressElement>('#draw-progress progress');
    if (state === 'waiting') bar.removeAttribute('value');
    else bar.value = progress;
    this.#status(state === 'waiting' ? 'Waiting for other jobs…' : `Making terrain: ${Math.floor(progress * 100)} %`);
  }

  async #cancel(): Promise<void> {
    const job = this.#job;
    if (!job) return;
    try {
      await forgetJob(job);
    } catch (error) {
      this.#refused(error);
    }
  }

  /** A layer with this raster in the place of the one that the sketch was before, or on top. */
  async #place(job: Job): Promise<void> {
    const hash = job.raster?.split('/').at(-1) ?? '';
    await this.#save((layers) => {
      const source = { raster: { hash } };
      const own = layers.find(({ name }) => name === this.#layer);
      if (own) return layers.map((layer) => (layer === own ? { ...layer, source } : layer));
      const wish = slug(this.#sketch.title).slice(0, 50) || 'drawn';
      const taken = new Set(layers.map(({ name }) => name));
      let name = wish;
      for (let i = 2; taken.has(name); i++) name = `${wish}-${i}`;
      this.#layer = name;
      return [...layers, { name, source }];
    });
    this.#keep();
    this.#pen.preview(undefined);
    this.#status(`It is part of ${this.#world} now, as the layer ${this.#layer}.`);
    this.terrain.setTilted(true);
  }

  /** Saves the world with other layers, over whatever it is now. */
  async #save(change: (layers: JsonObject[]) => JsonObject[]): Promise<void> {
    for (;;) {
      const { document, etag } = await readWorld(this.#world);
      const layers = change((document['layers'] ?? []) as JsonObject[]);
      try {
        const stored = await saveWorld(this.#world, { ...document, layers }, etag);
        this.events.saved(this.#world, stored);
        return await this.#showLayers(stored.document);
      } catch (error) {
        // Somebody else was faster: once more over theirs.
        if (!(error instanceof Problem) || error.status !== 412) throw error;
      }
    }
  }

  /** The layers of the world that were drawn. */
  async #showLayers(document?: JsonObject): Promise<void> {
    const list = this.#find('#drawn-layers');
    try {
      const known = document ?? (await readWorld(this.#world)).document;
      const rows = drawnLayers(known).map(({ name, hash }) => {
        const edit = element('button', { type: 'button', textContent: name === this.#layer ? 'On the map' : 'Edit', disabled: name === this.#layer });
        edit.setAttribute('aria-label', `Edit ${name}`);
        edit.addEventListener('click', () => void this.#edit(name, hash));
        const remove = element('button', { type: 'button', textContent: 'Remove' });
        remove.setAttribute('aria-label', `Remove ${name}`);
        remove.addEventListener('click', () => void this.#takeOut(name));
        return element('li', {}, element('span', { textContent: name }), edit, remove);
      });
      list.replaceChildren(...rows);
      this.#find('#drawn').hidden = rows.length === 0;
    } catch (error) {
      this.#status(message(error), 'error');
    }
  }

  /** Takes the sketch of a layer up again: that of the job which made its raster. */
  async #edit(name: string, hash: string): Promise<void> {
    try {
      const made = (await jobs()).find(({ raster }) => raster?.endsWith(`/${hash}`));
      const work = made && (await readJob(made.id)).work;
      const sketch = work && fromWork(work);
      if (!sketch) return this.#status(`The drawing of ${name} is not kept, or was not made here: it can only be removed.`, 'error');
      this.#layer = name;
      this.#chosen = undefined;
      this.#change(sketch);
      await this.#showLayers();
    } catch (error) {
      this.#status(message(error), 'error');
    }
  }

  async #takeOut(name: string): Promise<void> {
    try {
      let removed: JsonObject | undefined;
      let at = 0;
      await this.#save((layers) => {
        at = layers.findIndex((layer) => layer['name'] === name);
        removed = layers[at];
        return layers.filter((layer) => layer !== removed);
      });
      if (this.#layer === name) this.#layer = undefined;
      this.#keep();
      this.#draw();
      const back = removed;
      const run = () => void this.#save((layers) => (back ? [...layers.slice(0, at), back, ...layers.slice(at)] : layers)).then(() => this.#status(`${name} is back.`));
      this.#status(`Removed ${name}.`, 'info', { label: 'Undo', run });
    } catch (error) {
      this.#status(message(error), 'error');
    }
  }
}
