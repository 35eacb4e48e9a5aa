import { AttributionControl, GPUInitializationError, type ErrorEvent, type StyleSpecification } from 'maplibre-gl';
import { Unreachable, catalog, readStyle, readWorld, type CatalogEntry, type Stored } from './api.ts';
import { ask } from './dialog.ts';
import { DrawPanel } from './drawing/panel.ts';
import { Editor } from './editor.ts';
import { STARTER } from './fields.ts';
import { Follower } from './follower.ts';
import { formatLink, parseLink, type Link, type Overlay } from './link.ts';
import { TerrainMap, type View } from './map.ts';
import { toMetres } from './mercator.ts';
import { Notice } from './notice.ts';
import { OverlayControl } from './overlay-control.ts';
import { PlayControl } from './play-control.ts';
import { Readout } from './readout.ts';
import { showScale } from './scale.ts';
import { Evolve } from './studio/evolve.ts';
import { Studio } from './studio/studio.ts';
import type { StudioEvents } from './studio/switcher.ts';
import { ViewControl } from './view-control.ts';

/** What opens beside the map, one at a time. */
type Panel = 'edit' | 'draw';

/** What the server says when it is busy; it is asked again after a while. */
const BUSY = [429, 503];
const BUSY_WAIT_MS = 2000;

function find<E extends HTMLElement>(selector: string): E {
  const found = document.querySelector<E>(selector);
  if (!found) throw new Error(`the page has no ${selector}`);
  return found;
}

function message(error: unknown): string {
  if (error instanceof GPUInitializationError) return 'This browser cannot draw the map: WebGL 2 is missing or switched off.';
  return error instanceof Error ? error.message : String(error);
}

/** The page: one world on the map and in the form, the choice of worlds, and the link to the view. */
export class Viewer {
  readonly #stage = find('#stage');
  readonly #select = find<HTMLSelectElement>('#world');
  readonly #panels: Record<Panel, { button: HTMLButtonElement; element: HTMLElement }> = {
    edit: { button: find('#edit'), element: find('#panel') },
    draw: { button: find('#draw-button'), element: find('#draw') },
  };
  readonly #notice = new Notice(find('#notice'));
  readonly #editor = new Editor(find<HTMLFormElement>('#editor'), {
    saved: (name) => void this.#renew(name),
    created: (name) => void this.#showCreated(name),
  });
  readonly #control = new ViewControl(find('#height'), (view) => this.#changeView(view));
  /** Hears what others make of the world that is shown. */
  readonly #follower = new Follower({
    settled: () => this.#renewal,
    shows: () => this.#revision,
    changed: (name) => void this.#compare(name),
    gone: (name) => this.#notice.error(`The world "${name}" has been deleted.`),
  });
  readonly #playControl = new PlayControl(() => this.#play());
  readonly #overlayControl = new OverlayControl((overlays) => this.#changeView({ overlays }));
  readonly #studioEvents: StudioEvents = {
    created: (name) => void this.#showCreated(name),
    breed: (session) => void new Studio(this.#studioEvents).show(session),
    evolve: () => void new Evolve(this.#studioEvents).show(),
    world: () => this.#world,
    place: () => toMetres(this.#terrain?.camera ?? { lon: 0, lat: 0 }),
  };
  #terrain: TerrainMap | undefined;
  #drawing: DrawPanel | undefined;
  #world: string | undefined;
  /** Of the world that is shown, as far as is known. */
  #revision: string | undefined;
  #renewal: Promise<void> = Promise.resolve();
  #opening = 0;
  #retry: number | undefined;

  async start(): Promise<void> {
    this.#listen();
    await this.#begin();
    if (Evolve.wasOpen) void new Evolve(this.#studioEvents).show();
    else if (Studio.wasOpen) this.#breed();
  }

  /** Reads the catalog and opens what the link says. Comes back here after a failure. */
  async #begin(): Promise<void> {
    this.#notice.info('Loading…');
    let worlds: CatalogEntry[];
    try {
      worlds = await this.#readCatalog();
    } catch (error) {
      return this.#fail(error, () => void this.#begin());
    }
    const link = parseLink(location.hash);
    const first = worlds[0];
    if (!first) return this.#offerFirst();
    const wanted = worlds.find(({ name }) => name === link.world);
    await this.#open((wanted ?? first).name, wanted || !link.world ? link : { ...link, camera: undefined });
    if (link.world && !wanted) this.#notice.error(`There is no world "${link.world}" here. This is another one.`);
  }

  async #readCatalog(): Promise<CatalogEntry[]> {
    const worlds = await catalog();
    const options = worlds.map(({ name, title }) => new Option(title || name, name));
    this.#select.replaceChildren(...options);
    this.#select.disabled = worlds.length === 0;
    if (this.#world) this.#select.value = this.#world;
    this.#revision = worlds.find(({ name }) => name === this.#world)?.revision;
    return worlds;
  }

  /** An empty server: the form makes the first world. */
  #offerFirst(): void {
    this.#stage.removeAttribute('aria-busy');
    this.#select.replaceChildren(new Option('No worlds yet'));
    this.#notice.info('This server has no worlds yet. The form makes the first one.');
    this.#editor.load(undefined, { document: STARTER, etag: '' });
    this.#panels.edit.button.disabled = false;
    this.#showPanel('edit');
  }

  async #open(name: string, view: View): Promise<void> {
    const opening = ++this.#opening;
    this.#select.value = name;
    this.#stage.setAttribute('aria-busy', 'true');
    try {
      const [stored, style] = await Promise.all([readWorld(name), readStyle(name)]);
      if (opening !== this.#opening) return; // another world was chosen meanwhile
      this.#world = name;
      this.#revision = stored.etag.replaceAll('"', '');
      this.#follower.follow(name);
      this.#editor.load(name, stored);
      this.#panels.edit.button.disabled = false;
      this.#notice.clear();
      this.#showStyle(style, view);
      this.#panels.draw.button.disabled = false;
      if (this.#isOpen('draw')) await this.#drawing?.show(name);
    } catch (error) {
      if (opening !== this.#opening) return;
      if (this.#world) this.#select.value = this.#world; // that is still the one shown
      this.#fail(error, () => void this.#open(name, view));
    }
  }

  #showStyle(style: StyleSpecification, view: View): void {
    document.title = `${this.#select.selectedOptions[0]?.text ?? this.#world} · Terrane`;
    if (this.#terrain) {
      this.#terrain.show(style, view);
    } else {
      this.#terrain = new TerrainMap(find('#map'), style, view);
      this.#attach(this.#terrain);
      this.#drawing = new DrawPanel(this.#panels.draw.element, this.#terrain, { saved: (name, stored) => this.#drawn(name, stored) });
    }
    this.#showControls(this.#terrain);
    this.#writeLink();
  }

  #showControls(terrain: TerrainMap): void {
    this.#control.show(terrain.tilted, terrain.exaggeration);
    this.#overlayControl.show(terrain.overlays.there, terrain.overlays.shown);
  }

  #attach(terrain: TerrainMap): void {
    const { map } = terrain;
    map.addControl(this.#control, 'top-right');
    map.addControl(this.#overlayControl, 'top-right');
    map.addControl(this.#playControl, 'top-right');
    map.addControl(new AttributionControl({ compact: true }), 'top-right');
    map.getCanvas().setAttribute('aria-label', 'Map of the terrain: arrow keys move, plus and minus zoom, Shift with arrows turns and tilts');
    map.on('dataloading', () => this.#stage.setAttribute('aria-busy', 'true'));
    map.on('idle', () => {
      if (!terrain.renewing) this.#stage.removeAttribute('aria-busy');
    });
    map.on('moveend', () => this.#writeLink());
    map.on('error', (event) => this.#mapFailed(event));
    new Readout(find('#readout'), terrain);
    showScale(map, find('#scale'));
  }

  /** Shows what others have made of the world, also in the form unless something in it would be lost. */
  async #compare(name: string): Promise<void> {
    const stored = await readWorld(name).catch(() => undefined);
    if (!stored || name !== this.#world || stored.etag.replaceAll('"', '') === this.#revision) return;
    this.#drawn(name, stored);
  }

  /** Goes into the world, where the map's middle is. */
  #play(): void {
    if (!this.#world || !this.#terrain) return;
    const { lon, lat, bearing } = this.#terrain.camera;
    const { x, y } = toMetres({ lon, lat });
    location.href = `play.html?world=${this.#world}#at=${x.toFixed(1)},${y.toFixed(1)}&to=${Math.round((bearing + 360) % 360)}`;
  }

  /** Puts the newest revision of the world on the map, seen from where we are. */
  #renew(name: string): Promise<void> {
    this.#renewal = this.#renewNow(name);
    return this.#renewal;
  }

  async #renewNow(name: string): Promise<void> {
    this.#stage.setAttribute('aria-busy', 'true');
    try {
      const [style] = await Promise.all([readStyle(name), this.#readCatalog()]);
      if (name !== this.#world) return;
      this.#notice.clear();
      this.#terrain?.renew(style);
      if (this.#terrain) this.#showControls(this.#terrain);
      document.title = `${this.#select.selectedOptions[0]?.text ?? name} · Terrane`;
    } catch (error) {
      this.#fail(error, () => void this.#renew(name));
    }
  }

  /** Terrain was drawn: the map shows it, and the form what is stored now unless something in it would be lost. */
  #drawn(name: string, stored: Stored): void {
    if (name !== this.#world) return;
    if (!this.#editor.changed) this.#editor.load(name, stored);
    void this.#renew(name);
  }

  async #showCreated(name: string): Promise<void> {
    try {
      await this.#readCatalog();
      await this.#open(name, this.#currentView());
    } catch (error) {
      this.#fail(error, () => void this.#showCreated(name));
    }
  }

  /** Tries again what the map could not get, once the server is there again. */
  async #recover(): Promise<void> {
    this.#notice.info('Trying again…');
    try {
      await this.#readCatalog();
      this.#notice.clear();
      this.#terrain?.reload();
    } catch (error) {
      this.#fail(error, () => void this.#recover());
    }
  }

  #fail(error: unknown, retry: () => void): void {
    this.#stage.removeAttribute('aria-busy');
    this.#notice.error(message(error), { label: 'Try again', run: retry });
  }

  #mapFailed(event: ErrorEvent): void {
    const { error } = event;
    // MapLibre's request errors have a status, 0 when there was no answer.
    const status = (error as { status?: number }).status;
    if (status !== undefined && BUSY.includes(status)) return this.#waitAndReload();
    const lost = status === 0 ? new Unreachable().message : `Parts of the map could not be loaded (${status}).`;
    this.#notice.error(status === undefined ? message(error) : lost, {
      label: 'Try again',
      run: () => void this.#recover(),
    });
  }

  #waitAndReload(): void {
    this.#notice.info('The server is busy. Some tiles come later.');
    this.#retry ??= window.setTimeout(() => {
      this.#retry = undefined;
      this.#notice.clear('info');
      this.#terrain?.reload();
    }, BUSY_WAIT_MS);
  }

  #currentView(): View {
    const terrain = this.#terrain;
    return terrain
      ? { camera: terrain.camera, tilted: terrain.tilted, exaggeration: terrain.exaggeration, overlays: terrain.overlays.shown }
      : parseLink(location.hash);
  }

  #changeView({ tilted, exaggeration, overlays }: { tilted?: boolean; exaggeration?: number; overlays?: Overlay[] }): void {
    const terrain = this.#terrain;
    if (!terrain) return;
    if (exaggeration !== undefined) terrain.setExaggeration(exaggeration);
    if (tilted !== undefined) terrain.setTilted(tilted);
    if (overlays !== undefined) terrain.setOverlays(overlays);
    this.#showControls(terrain);
    this.#writeLink();
  }

  #writeLink(): void {
    if (!this.#world) return;
    const { overlays, ...view } = this.#currentView();
    const hash = formatLink({ world: this.#world, ...view, overlays: overlays ? [...overlays] : undefined });
    // Replaced, not added: the way back leads out of the map, not through every move.
    if (hash !== location.hash) history.replaceState(history.state, '', hash);
  }

  /** Somebody pasted another link into the address bar. */
  async #followLink(): Promise<void> {
    const link = parseLink(location.hash);
    if (link.world && link.world !== this.#world) return this.#choose(link.world, link);
    if (!this.#terrain || !link.camera) return;
    this.#terrain.moveTo(link);
    this.#showControls(this.#terrain);
  }

  async #choose(name: string, link?: Link): Promise<void> {
    if (this.#editor.changed && !(await this.#mayDiscard())) {
      if (this.#world) this.#select.value = this.#world;
      return this.#writeLink();
    }
    const view = this.#currentView();
    await this.#open(name, link ?? { tilted: view.tilted, exaggeration: view.exaggeration, overlays: view.overlays });
  }

  async #mayDiscard(): Promise<boolean> {
    const reply = await ask({
      title: 'Discard your changes?',
      text: `What you changed in ${this.#world ?? 'the form'} has not been saved.`,
      answers: [
        { id: 'discard', label: 'Discard' },
        { id: 'keep', label: 'Keep editing', primary: true },
      ],
    });
    return reply?.answer === 'discard';
  }

  #breed(): void {
    void new Studio(this.#studioEvents).show();
  }

  #isOpen(panel: Panel): boolean {
    return !this.#panels[panel].element.hidden;
  }

  /** Opens one panel, or closes the one that is open. */
  #showPanel(open: Panel | undefined): void {
    for (const [name, { button, element }] of Object.entries(this.#panels)) {
      const was = !element.hidden;
      element.hidden = name !== open;
      button.setAttribute('aria-expanded', String(name === open));
      if (was && !open) button.focus();
      if (was && name === 'draw' && open !== 'draw') this.#drawing?.hide();
    }
    if (!open) return;
    this.#panels[open].element.querySelector<HTMLElement>('textarea, button[aria-pressed]')?.focus({ preventScroll: true });
    if (open === 'draw' && this.#world) void this.#drawing?.show(this.#world);
  }

  #toggle(panel: Panel): void {
    if (!this.#panels[panel].button.disabled) this.#showPanel(this.#isOpen(panel) ? undefined : panel);
  }

  #listen(): void {
    this.#select.addEventListener('change', () => void this.#choose(this.#select.value));
    for (const panel of Object.keys(this.#panels) as Panel[]) {
      const { button, element } = this.#panels[panel];
      button.addEventListener('click', () => this.#toggle(panel));
      element.querySelector('.close')?.addEventListener('click', () => this.#showPanel(undefined));
      element.addEventListener('keydown', (event) => {
        if (event.key !== 'Escape') return;
        event.preventDefault();
        // The first Escape lays the pen down.
        if (panel !== 'draw' || !this.#drawing?.key(event)) this.#showPanel(undefined);
      });
    }
    find('#breed').addEventListener('click', () => this.#breed());
    window.addEventListener('hashchange', () => void this.#followLink());
    window.addEventListener('beforeunload', (event) => {
      if (this.#editor.changed) event.preventDefault();
    });
    find('.skip').addEventListener('click', (event) => {
      event.preventDefault(); // the hash is the link's
      this.#terrain?.map.getCanvas().focus();
    });
    document.addEventListener('keydown', (event) => this.#shortcut(event));
  }

  #shortcut(event: KeyboardEvent): void {
    const typing = event.target instanceof Element && event.target.closest('input:not([type=range]), textarea, select, dialog');
    if (typing || event.altKey || event.defaultPrevented) return;
    if ((event.ctrlKey || event.metaKey) && event.key === 'z' && this.#isOpen('draw')) {
      event.preventDefault();
      return this.#drawing?.undo();
    }
    if (event.ctrlKey || event.metaKey) return;
    const pressing = event.key === 'Enter' && event.target instanceof Element && event.target.closest('button, summary');
    if (this.#isOpen('draw') && !pressing && this.#drawing?.key(event)) return event.preventDefault();
    if (this.#isOpen('draw') && event.key === 'Escape') return this.#showPanel(undefined);
    const overlay = this.#overlayControl.overlayOf(event.key);
    if (overlay) this.#overlayControl.toggle(overlay);
    else if (event.key === 'b' || event.key === 'B') this.#breed();
    else if (event.key === 'p' || event.key === 'P') this.#play();
    else if (event.key === 't' || event.key === 'T') this.#control.toggle();
    else if (event.key === 'e' || event.key === 'E' || event.key === 'd' || event.key === 'D') {
      event.preventDefault(); // or the letter would land in the form
      this.#toggle(event.key.toLowerCase() === 'e' ? 'edit' : 'draw');
    }
  }
}
