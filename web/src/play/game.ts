import { adaptiveLayers } from '../adaptive.ts';
import { readStyle, readWorld, type JsonObject } from '../api.ts';
import { listen, type ServerEvent } from '../events.ts';
import { toLonLat, toMetres } from '../mercator.ts';
import { Notice } from '../notice.ts';
import { Controls, type Deed } from './controls.ts';
import { Life, type GenerationNews } from './life.ts';
import { Others } from './others.ts';
import { Pace } from './pace.ts';
import { find } from './page.ts';
import { meet } from './ray.ts';
import { SNOW, landStops } from './relief.ts';
import { Terrain, type Changed } from './terrain.ts';
import { View, type Circle, type Seen } from './view.ts';
import { EYES, Walker } from './walker.ts';
import type { Place } from './grid.ts';

/** How much finer than needed the ground is where the machine can. */
const MOST_REFINEMENT = 2;
const PHONE_REFINEMENT = 1.6;
const PULSE_S = 1.4;
const SHOW_MS = 250;
const SAVED_MS = 150;
/** Motion is reckoned in steps no longer than this, and no more than so many a picture. */
const STEP_S = 0.05;
const LONGEST_S = 0.5;

const reduced = matchMedia('(prefers-reduced-motion: reduce)');

/** What the address says: `play.html?world=NAME#at=x,y&to=DEGREES`. */
function linked(): { world: string | undefined; at: Place | undefined; heading: number } {
  const world = new URLSearchParams(location.search).get('world') ?? undefined;
  const hash = new URLSearchParams(location.hash.slice(1));
  const [x, y] = (hash.get('at') ?? '').split(',').map(Number);
  const at = x !== undefined && y !== undefined && Number.isFinite(x) && Number.isFinite(y) ? { east: x, south: -y } : undefined;
  const heading = (Number(hash.get('to') ?? 0) * Math.PI) / 180;
  return { world: world && /^[a-z0-9][a-z0-9-]{0,62}$/.test(world) ? world : undefined, at, heading: Number.isFinite(heading) ? heading : 0 };
}

/** The page: somebody's eyes, hands and feet in a world. */
export class Game {
  readonly #stage = find('#play');
  readonly #canvas = find<HTMLCanvasElement>('#ground');
  readonly #notice = new Notice(find('#notice'));
  readonly #help = find('#help');
  readonly #flyButton = find<HTMLButtonElement>('#fly');
  readonly #helpButton = find<HTMLButtonElement>('#help-button');
  readonly #others = new Others();
  readonly #walker = new Walker();
  readonly #pace = new Pace(matchMedia('(pointer: coarse)').matches ? PHONE_REFINEMENT : MOST_REFINEMENT);
  readonly #controls = new Controls(this.#canvas, find('#stick'), {
    turn: (heading, pitch) => this.#turn(heading, pitch),
    deed: (deed, at) => this.#do(deed, at),
  });
  #view!: View;
  #terrain!: Terrain;
  #life: Life | undefined;
  #world = '';
  #sea = 0;
  #stands = false;
  #pulse: { place: Place; since: number } | undefined;
  #before = 0;
  #drawn = false;
  #shown = 0;
  #stale = true;
  #pictures = 0;
  #slowest = 0;

  async start(): Promise<void> {
    const { world, at, heading } = linked();
    if (!world) return this.#notice.error('The address names no world: open the game from the map.');
    this.#world = world;
    this.#listen();
    this.#notice.info('Loading…');
    try {
      this.#view = new View(this.#canvas);
    } catch {
      return this.#notice.error('This browser cannot draw the world: WebGL 2 is missing or switched off.');
    }
    try {
      const [{ document, etag }, style] = await Promise.all([readWorld(world), readStyle(world)]);
      this.#open(document, etag.replaceAll('"', ''), at ?? this.#middle(document, style.center as [number, number] | undefined));
    } catch (error) {
      return this.#notice.error(error instanceof Error ? error.message : String(error), { label: 'Try again', run: () => location.reload() });
    }
    this.#walker.turn(heading, -0.06);
    listen(`events?world=${world}`, { heard: (event) => this.#hear(event), missed: () => void this.#catchUp() });
    requestAnimationFrame((now) => this.#frame(now));
  }

  /** Where one begins: in the middle of ground that adapts, or where the map begins. */
  #middle(document: JsonObject, [lon, lat]: [number, number] = [0, 0]): Place {
    const [layer] = adaptiveLayers(document);
    const { x, y } = layer
      ? { x: (layer.extent[0] + layer.extent[2]) / 2, y: (layer.extent[1] + layer.extent[3]) / 2 }
      : toMetres({ lon, lat });
    return { east: x, south: -y };
  }

  #open(document: JsonObject, revision: string, at: Place): void {
    const title = String(document['title'] ?? this.#world);
    window.document.title = `${title} · Play · Terrane`;
    find('#world-title').textContent = title;
    const { min = -10000, max = 9000 } = (document['elevation'] ?? {}) as { min?: number; max?: number };
    this.#sea = Number(document['sea_level'] ?? 0);
    this.#terrain = new Terrain(this.#world, revision, this.#view.layers, {
      filled: (layer) => this.#view.update(layer),
      arrived: (revision, moved) => Object.assign(this.#stage.dataset, { revision, moved: String(moved) }),
      failed: (error) => this.#notice.error(error.message),
    }, reduced.matches);
    this.#stage.dataset['revision'] = revision;
    this.#view.show(this.#terrain.data, this.#sea, landStops(this.#sea, [min, max]), this.#sea + 0.8 * SNOW);
    this.#walker.place = at;
    this.#adopt(document);
  }

  /** Shows what adapts, if anything does. */
  #adopt(document: JsonObject): void {
    const layers = adaptiveLayers(document);
    for (const element of window.document.querySelectorAll<HTMLElement>('.adaptive')) element.hidden = layers.length === 0;
    if (layers.length === 0 || this.#life) return;
    this.#life = new Life(this.#world, layers, {
      shaped: (place) => (this.#pulse = { place, since: performance.now() }),
      renewed: (revision, changed) => this.#renew(revision, changed),
    });
  }

  #renew(revision: string, changed: Changed): void {
    this.#stale = true;
    this.#terrain.renew(revision, changed);
  }

  #hear({ event, data }: ServerEvent): void {
    const news = JSON.parse(data) as Partial<GenerationNews>;
    if (news.world !== this.#world) return;
    if (event === 'generation' && this.#life) this.#life.news(news as GenerationNews);
    else if (event === 'world' && news.revision) this.#saved(news.revision);
  }

  /** A generation is a save, too, and says more about it: what it says is waited for. */
  #saved(revision: string): void {
    window.setTimeout(() => {
      if (!this.#terrain.knows(revision)) this.#renew(revision, undefined);
    }, SAVED_MS);
  }

  /** Nobody listened for a while. */
  async #catchUp(): Promise<void> {
    const { etag } = await readWorld(this.#world).catch(() => ({ etag: '' }));
    const revision = etag.replaceAll('"', '');
    if (!revision || this.#terrain.knows(revision)) return;
    this.#renew(revision, undefined);
    await this.#life?.refresh();
  }

  #ground = { at: (place: Place): number | undefined => this.#surface(place) };

  #surface(place: Place): number | undefined {
    const height = this.#terrain.height(place);
    return height === undefined ? undefined : Math.max(height, this.#sea);
  }

  #frame(now: number): void {
    requestAnimationFrame((next) => this.#frame(next));
    const apart = now - this.#before;
    const seconds = Math.min(LONGEST_S, Math.max(0, apart) / 1000);
    this.#before = now;
    if (document.hidden) return;
    const begun = performance.now();
    this.#move(seconds);
    const moves = this.#controls.active || this.#walker.speed > 0.02 || this.#pulse !== undefined;
    const lively = this.#stale || moves || !reduced.matches || !this.#terrain.still;
    // Where nothing moves there is time for all pixels.
    const resized = this.#view.resize(Math.min(2, devicePixelRatio) * (lively ? this.#pace.pixels : 1));
    const needed = lively || resized;
    if (needed) this.#draw(now, seconds);
    if (lively && this.#drawn && apart < 1000) this.#pace.tell(apart);
    this.#drawn = lively;
    this.#slowest = Math.max(this.#slowest, performance.now() - begun);
    if (now - this.#shown > SHOW_MS) this.#show(now);
  }

  #move(seconds: number): void {
    const below = this.#surface(this.#walker.place);
    if (below === undefined) return;
    if (!this.#stands) {
      this.#stands = true;
      this.#walker.eye = below + EYES;
    }
    const steps = Math.ceil(seconds / STEP_S);
    for (let i = 0; i < steps; i++) this.#walker.step(this.#controls.wish(seconds / steps), seconds / steps, this.#ground);
    // Until the ground is as fine as it gets, where one stands is not told to anybody.
    if (this.#stage.dataset['ready']) this.#life?.at(this.#walker.place, !this.#walker.flying);
  }

  #draw(now: number, seconds: number): void {
    const { place, eye, heading, pitch } = this.#walker;
    const above = Math.max(0, eye - (this.#surface(place) ?? eye));
    const sees = this.#view.look({ place, eye, heading, pitch });
    this.#terrain.refinement = this.#pace.refinement;
    const quarters = this.#terrain.update(place, above, seconds, sees);
    const seen: Seen = {
      place, eye, above, heading, pitch,
      seconds: reduced.matches ? 0 : now / 1000,
      share: this.#terrain.share,
      ring: this.#ring(), pulse: this.#pulsing(now),
    };
    this.#view.draw(quarters, this.#pace.refinement, seen);
    this.#point();
    this.#stale = !this.#terrain.still;
    this.#stage.dataset['pictures'] = String(++this.#pictures);
    if (this.#terrain.still && this.#stands) this.#settled();
  }

  #point(): void {
    if (this.#life) this.#others.show(this.#life.others, this.#view, this.#walker, (there) => this.#surface(there));
  }

  #settled(): void {
    if (this.#stage.dataset['ready']) return;
    this.#stage.dataset['ready'] = 'yes';
    this.#stage.removeAttribute('aria-busy');
    this.#notice.clear('info');
    this.#stale = true;
    if (this.#surface(this.#walker.place) === this.#sea) this.#fly(true);
  }

  #ring(): Circle | undefined {
    const life = this.#life;
    if (!life?.inside || this.#walker.flying) return undefined;
    return { place: this.#walker.place, radius: life.promise, strength: 0.8 };
  }

  #pulsing(now: number): Circle | undefined {
    if (!this.#pulse) return undefined;
    const t = (now - this.#pulse.since) / 1000 / PULSE_S;
    if (t >= 1) {
      this.#pulse = undefined;
      this.#stale = true;
      return undefined;
    }
    const radius = reduced.matches ? 12 : 4 + 60 * Math.sqrt(Math.max(0, t));
    return { place: this.#pulse.place, radius, strength: 1 - Math.max(0, t) };
  }

  /** The figures in the corner, and the address. */
  #show(now: number): void {
    this.#shown = now;
    const { place, eye, heading, pitch } = this.#walker;
    const ground = this.#terrain.height(place);
    if (ground === undefined) return;
    find('#elevation').textContent = ground.toFixed(1);
    find('#coordinates').textContent = `x ${Math.round(place.east)}, y ${Math.round(-place.south)}`;
    Object.assign(this.#stage.dataset, {
      east: place.east.toFixed(3), north: (-place.south).toFixed(3), eye: eye.toFixed(3), ground: ground.toFixed(4),
      heading: heading.toFixed(3), pitch: pitch.toFixed(3), flying: String(this.#walker.flying), phase: this.#terrain.phase, blocks: String(this.#terrain.blocks),
      spacing: String(this.#terrain.spacing(place) ?? ''), still: String(this.#terrain.still), slowest: this.#slowest.toFixed(1),
      refinement: this.#pace.refinement.toFixed(2), pixels: this.#pace.pixels.toFixed(2),
    });
    this.#slowest = 0;
    this.#showAim();
    this.#point();
    if (this.#walker.speed < 0.05) this.#link();
  }

  /** What lies in the middle of the view: how far, and how high. */
  #showAim(): void {
    const { place } = this.#walker;
    const aim = this.#aim([0.5, 0.5]);
    const height = aim && this.#terrain.height(aim);
    const far = aim ? Math.hypot(aim.east - place.east, aim.south - place.south) : 0;
    find('#aim').textContent = height === undefined ? '' : `ahead ${height.toFixed(0)} m, ${far.toFixed(0)} m away`;
    Object.assign(this.#stage.dataset, {
      aim: height?.toFixed(4) ?? '', aimEast: aim?.east.toFixed(3) ?? '', aimNorth: aim ? (-aim.south).toFixed(3) : '', far: far.toFixed(1),
    });
  }

  #link(): void {
    const { place, heading } = this.#walker;
    const degrees = Math.round((((heading * 180) / Math.PI) % 360) + 360) % 360;
    const hash = `#at=${place.east.toFixed(1)},${(-place.south).toFixed(1)}&to=${degrees}`;
    if (hash !== location.hash) history.replaceState(history.state, '', hash);
    const { lon, lat } = toLonLat({ x: place.east, y: -place.south });
    find<HTMLAnchorElement>('#back').href = `./#world=${this.#world}&at=${lon.toFixed(6)},${lat.toFixed(6)}&zoom=14`;
  }

  #turn(heading: number, pitch: number): void {
    this.#walker.turn(heading, pitch);
    this.#stale = true;
  }

  #fly(flying: boolean): void {
    this.#walker.fly(flying);
    this.#flyButton.setAttribute('aria-pressed', String(flying));
    this.#stale = true;
  }

  #do(deed: Deed, at: readonly [number, number] = [0.5, 0.5]): void {
    if (!this.#terrain && deed !== 'help' && deed !== 'map') return;
    if (deed === 'fly') this.#fly(!this.#walker.flying);
    else if (deed === 'help') this.#showHelp(this.#help.hidden !== false);
    else if (deed === 'map') find<HTMLAnchorElement>('#back').click();
    else if (deed === 'ahead') this.#life?.toggleAhead();
    else if (deed === 'lock') void this.#canvas.requestPointerLock();
    else if (this.#life) void this.#life.shape(this.#aim(at));
  }

  /** The ground at a point of the picture. */
  #aim(at: readonly [number, number]): Place | undefined {
    const { place, eye } = this.#walker;
    return meet(place, eye, this.#view.direction(at), (there) => this.#surface(there));
  }

  #showHelp(shown: boolean): void {
    this.#help.hidden = !shown;
    this.#helpButton.setAttribute('aria-expanded', String(shown));
    localStorage.setItem('terrane-play-help', shown ? 'shown' : 'away');
    if (!shown && this.#help.contains(document.activeElement)) this.#canvas.focus();
  }

  #listen(): void {
    this.#flyButton.addEventListener('click', () => this.#do('fly'));
    this.#helpButton.addEventListener('click', () => this.#showHelp(this.#help.hidden !== false));
    find('#help-close').addEventListener('click', () => this.#showHelp(false));
    find('#shape').addEventListener('click', () => this.#do('shape'));
    find('.skip').addEventListener('click', (event) => {
      event.preventDefault(); // the hash is the link's
      this.#canvas.focus();
    });
    window.addEventListener('resize', () => (this.#stale = true));
    document.addEventListener('visibilitychange', () => this.#controls.release());
    const small = matchMedia('(max-width: 720px)').matches;
    this.#showHelp(localStorage.getItem('terrane-play-help') !== 'away' && !small);
    this.#canvas.focus({ preventScroll: true });
  }
}
