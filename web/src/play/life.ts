import {
  feed, goTo, leave, readGenerations, readPlayers, tellWay, within, type AdaptiveLayer, type Extent, type Feedback, type GenerationEntry,
} from '../adaptive.ts';
import { Problem } from '../api.ts';
import { find } from './page.ts';
import type { Place } from './grid.ts';

/** Ground that adapts, as the page shows it: generations, shaping, and what the server is told of the player's way. */

/** Positions are told this often, and kept this far apart. */
const TELL_MS = 1500;
const APART_M = 1.5;
const MOST_POSITIONS = 200;
/** A player who stands still is heard of this often. */
const ALIVE_MS = 20_000;
const PLAYERS_MS = 5000;
/** After this share of the promised distance the ground ahead adapts anew. */
const STRIDE = 0.8;
const LEAST_STRIDE_M = 40;
const NAME_PLACE = 'terrane-player';

/** What the server sends of a new generation. */
export interface GenerationNews {
  world: string;
  layer: string;
  number: number;
  revision: string;
  changed: Extent | null;
}

export interface LifeEvents {
  /** Where a generation came from this page's own question. */
  shaped(place: Place): void;
  /** The world has another revision. */
  renewed(revision: string, changed: Extent | null | undefined): void;
}

/** Keeps one name in a tab. */
function playerName(): string {
  const kept = sessionStorage.getItem(NAME_PLACE);
  if (kept) return kept;
  const name = `walker-${crypto.getRandomValues(new Uint32Array(1))[0]?.toString(36) ?? '0'}`;
  sessionStorage.setItem(NAME_PLACE, name);
  return name;
}

const plane = ({ east, south }: Place): [number, number] => [Math.round(east * 1000) / 1000, Math.round(-south * 1000) / 1000];

export class Life {
  readonly #card = find('#life');
  readonly #number = find('#generation');
  readonly #players = find('#players');
  readonly #past = find<HTMLInputElement>('#past');
  readonly #pastValue = find('#past-value');
  readonly #reason = find('#past-reason');
  readonly #reach = find<HTMLSelectElement>('#reach');
  readonly #ahead = find<HTMLInputElement>('#ahead');
  readonly #said = find('#said');
  readonly #name = playerName();
  #generations: GenerationEntry[] = [];
  #current = 0;
  #way: [number, number][] = [];
  #last: Place | undefined;
  #walked = 0;
  #walking = false;
  #known = false;
  #telling: Promise<void> = Promise.resolve();
  #feeding = false;
  /** Until then going back is refused, because of others. */
  #refused = '';
  /** How far around the player the ground stays. */
  promise = 0;
  /** Who else walks here, as last heard. */
  others: { name: string; place: Place }[] = [];

  constructor(
    readonly world: string,
    readonly layers: readonly AdaptiveLayer[],
    readonly events: LifeEvents,
  ) {
    this.#card.hidden = false;
    this.promise = Math.max(...layers.map(({ promise }) => promise));
    this.#past.addEventListener('change', () => void this.#goBack(Number(this.#past.value)));
    this.#past.addEventListener('input', () => (this.#pastValue.textContent = this.#past.value));
    this.#ahead.addEventListener('change', () => this.#say(this.#ahead.checked ? 'The ground ahead adapts while you walk.' : ''));
    window.setInterval(() => this.#tell(), TELL_MS);
    window.setInterval(() => this.#alive(), ALIVE_MS);
    window.setInterval(() => void this.#count(), PLAYERS_MS);
    window.addEventListener('pagehide', () => this.#leave());
    void this.refresh();
  }

  get number(): number {
    return this.#current;
  }

  get inside(): boolean {
    return this.#walking && this.#last !== undefined && this.#layerAt(this.#last) !== undefined;
  }

  toggleAhead(): void {
    this.#ahead.click();
  }

  #layerAt(place: Place): AdaptiveLayer | undefined {
    return this.layers.find(({ extent }) => within(extent, plane(place)));
  }

  /** Where the player is, in every frame; only who walks is promised ground. */
  at(place: Place, walking: boolean): void {
    if (walking !== this.#walking) this.#change(walking);
    if (!walking) return;
    const step = this.#last ? Math.hypot(place.east - this.#last.east, place.south - this.#last.south) : Infinity;
    if (step < APART_M) return;
    this.#last = place;
    this.#way.push(plane(place));
    if (this.#way.length >= MOST_POSITIONS) this.#tell();
    if (step < Infinity) this.#walked += step;
    if (this.#ahead.checked && this.#walked > Math.max(LEAST_STRIDE_M, STRIDE * this.promise)) this.#adapt(place);
  }

  #change(walking: boolean): void {
    this.#walking = walking;
    this.#last = undefined;
    this.#refused = '';
    if (!walking) this.#leave();
    this.#showPast();
  }

  /** Sends the way since the last time; one message after the other, so that it stays in order. */
  #tell(): Promise<void> {
    const way = this.#way;
    if (way.length === 0) return this.#telling;
    this.#way = [];
    this.#known = true;
    this.#telling = this.#telling.then(async () => {
      try {
        this.promise = await tellWay(this.world, this.#name, way);
      } catch (error) {
        this.#fail(error);
      }
      this.#showPast();
    });
    return this.#telling;
  }

  #alive(): void {
    if (!this.#walking || !this.#last || this.#way.length > 0) return;
    this.#way.push(plane(this.#last));
    void this.#tell();
  }

  #leave(): void {
    this.#way = [];
    if (!this.#known) return;
    this.#known = false;
    this.#telling = this.#telling.then(() => leave(this.world, this.#name));
  }

  async #count(): Promise<void> {
    if (document.hidden) return;
    try {
      const players = await readPlayers(this.world);
      this.#players.textContent = ['nobody walks here', '1 walks here'][players.length] ?? `${players.length} walk here`;
      this.others = players
        .filter(({ name }) => name !== this.#name)
        .map(({ name, position: [x, y] }) => ({ name, place: { east: x, south: -y } }));
      if (players.length === 0) this.#refused = '';
      this.#showPast();
    } catch {
      this.#players.textContent = '';
    }
  }

  /** Of the height of a place there will be more. */
  async shape(place: Place | undefined): Promise<void> {
    if (!place) return this.#say('There is no ground in the middle of the view.');
    const layer = this.#layerAt(place);
    if (!layer) return this.#say('The ground there does not adapt.');
    const radius = Number(this.#reach.value);
    this.events.shaped(place);
    await this.#feed({ layer: layer.name, points: [plane(place)], ...(radius ? { radius } : {}) });
  }

  #adapt(place: Place): void {
    const layer = this.#layerAt(place);
    if (!layer || this.#feeding) return;
    this.#walked = 0;
    void this.#feed({ layer: layer.name, players: true });
  }

  async #feed(feedback: Feedback): Promise<void> {
    if (this.#feeding) return this.#say('One thing after the other: the ground is still being shaped.');
    this.#feeding = true;
    this.#card.setAttribute('aria-busy', 'true');
    try {
      await this.#tell();
      const { generation, revision, changed } = await feed(this.world, feedback);
      this.#say(changed ? `Generation ${generation.number}` : `Generation ${generation.number}: nothing changed`);
      this.#heard(generation.number);
      this.events.renewed(revision, changed);
      await this.refresh();
    } catch (error) {
      this.#fail(error);
    } finally {
      this.#feeding = false;
      this.#card.removeAttribute('aria-busy');
    }
  }

  /** A generation of this world, from anybody. */
  news({ number, revision, changed }: GenerationNews): void {
    this.#heard(number);
    this.events.renewed(revision, changed);
    if (!this.#feeding) void this.refresh();
  }

  #heard(number: number): void {
    this.#current = number;
    this.#number.textContent = String(number);
    this.#card.dataset['generation'] = String(number);
  }

  /** Reads which generations there are. Those that came after the current one stay in the strip, to go on to. */
  async refresh(): Promise<void> {
    const [layer] = this.layers;
    if (!layer) return;
    try {
      const { current, generations } = await readGenerations(this.world, layer.name);
      const isPart = generations.every(({ hash }, i) => this.#generations[i]?.hash === hash);
      if (!isPart) this.#generations = generations;
      this.#heard(generations.find(({ hash }) => hash === current)?.number ?? generations.length - 1);
      this.#showPast();
    } catch (error) {
      this.#fail(error);
    }
  }

  async #goBack(number: number): Promise<void> {
    const [layer] = this.layers;
    const wanted = this.#generations[number];
    if (!layer || !wanted || number === this.#current) return;
    try {
      await goTo(this.world, layer.name, wanted.hash);
      await this.refresh();
    } catch (error) {
      if (error instanceof Problem && error.status === 409) this.#refused = error.message;
      else this.#fail(error);
    }
    this.#showPast();
  }

  #showPast(): void {
    const last = this.#generations.length - 1;
    this.#past.max = String(Math.max(0, last));
    if (document.activeElement !== this.#past || this.#past.disabled) this.#past.value = String(this.#current);
    this.#pastValue.textContent = `${this.#past.value} of ${Math.max(0, last)}`;
    const own = this.#walking && this.#known ? 'The ground under those who walk stays: fly (F) to go back.' : '';
    this.#past.disabled = last < 1 || own !== '' || this.#refused !== '';
    this.#reason.textContent = last < 1 ? '' : this.#refused || own;
    if (this.#refused) this.#past.value = String(this.#current);
  }

  #say(text: string): void {
    this.#said.dataset['kind'] = '';
    this.#said.textContent = text;
  }

  #fail(error: unknown): void {
    this.#said.dataset['kind'] = 'error';
    this.#said.textContent = error instanceof Error ? error.message : String(error);
  }
}
