import { Block, LAYER, fill } from './block.ts';
import { COARSEST, FINEST, blockAt, distanceTo, keyOf, meets, parentOf, sideOf, union, type Address, type Place, type Rectangle } from './grid.ts';
import { AT_ONCE, Loader, type Heights } from './loader.ts';

/** A quarter of a block, drawn because nothing finer is there or needed: `corner` counts its cells from the block's. */
export interface Quarter {
  block: Block;
  corner: readonly [east: number, south: number];
}

/** Ground further away is not drawn. */
export const HORIZON = 26_000;
/** Layers that may be filled in a frame, so that none takes long. */
const FILLS_A_FRAME = 6;
/** How long the ground takes from one revision to the next. */
const MOVE_S = 0.7;
/**
 * What the ground does when the world changes: all of it is fetched (only what changed is sent), then written beside
 * what is shown, then moves at once, so that no picture mixes revisions before and after; `settling` makes room for the next.
 */
type Phase = 'still' | 'fetching' | 'filling' | 'moving' | 'settling';

/** What is known of a change: a rectangle that holds all of it, null if there is none, undefined if it may be anywhere. */
export type Changed = Rectangle | null | undefined;

interface Target {
  revision: string;
  changed: Changed;
}

function together(a: Changed, b: Changed): Changed {
  if (a === undefined || b === undefined) return undefined;
  return a && b ? union(a, b) : (a ?? b);
}

export interface TerrainEvents {
  /** The heights of a layer are to be sent to the graphics card. */
  filled(layer: number): void;
  /** The ground is now that of a revision, the move of so many blocks has begun. */
  arrived(revision: string, moved: number): void;
  failed(error: Error): void;
}

/** The ground around a place: blocks in memory, finer the nearer, of one revision or on the way from one to the next. */
export class Terrain {
  readonly data: Float32Array<ArrayBuffer>;
  readonly #blocks = new Map<string, Block>();
  readonly #free: number[] = [];
  readonly #loader: Loader;
  readonly #find = (address: Address) => this.#blocks.get(keyOf(address));
  #wanted: { address: Address; urgency: number }[] = [];
  #dirty = new Set<Block>();
  #phase: Phase = 'still';
  #target: Target | undefined;
  #queued: Target | undefined;
  #checked = new Set<Block>();
  #share = 1;
  #frame = 0;
  /** Smaller where the machine is slow: blocks are refined from nearer on. */
  refinement = 1.6;

  constructor(
    world: string,
    public revision: string,
    readonly layers: number,
    readonly events: TerrainEvents,
    readonly instantly: boolean,
  ) {
    this.data = new Float32Array(layers * LAYER);
    for (let layer = layers - 1; layer >= 0; layer--) this.#free.push(layer);
    this.#loader = new Loader(world, (error) => events.failed(error));
  }

  /** How far the ground has moved from its heights before to those now, 0 … 1. */
  get share(): number {
    const t = this.#share;
    return t * t * (3 - 2 * t);
  }

  /** Whether every picture from here will be like this one. */
  get still(): boolean {
    return this.#phase === 'still' && this.#dirty.size === 0 && this.#wanted.length === 0 && this.#loader.idle;
  }

  get phase(): string {
    return this.#phase;
  }

  get blocks(): number {
    return this.#blocks.size;
  }

  /** The height that is seen at a place, from the finest block there. */
  height(place: Place): number | undefined {
    for (let z = FINEST; z >= COARSEST; z--) {
      const block = this.#find(blockAt(place, z));
      if (block) return block.height(place.east, place.south, this.share);
    }
    return undefined;
  }

  /** How far apart the heights under a place are. */
  spacing(place: Place): number | undefined {
    for (let z = FINEST; z >= COARSEST; z--) if (this.#find(blockAt(place, z))) return sideOf(z) / 64;
    return undefined;
  }

  /** Whether the ground is of a revision, or on its way there. */
  knows(revision: string): boolean {
    return [this.revision, this.#target?.revision, this.#queued?.revision].includes(revision);
  }

  /** The world has another revision; what is known to have changed, or undefined if it may be anything. */
  renew(revision: string, changed: Changed): void {
    if ((this.#queued ?? this.#target)?.revision === revision || (revision === this.revision && !this.#target && !this.#queued)) return;
    const before = this.#queued ?? (this.#phase === 'fetching' ? this.#target : undefined);
    this.#queued = { revision, changed: before ? together(before.changed, changed) : changed };
  }

  /**
   * One frame: chooses what is drawn from a place, `height` metres above the ground, asks for what is missing and moves
   * on what changes. `sees` leaves out what is not in view.
   */
  update(place: Place, height: number, seconds: number, sees: (block: Block) => boolean): Quarter[] {
    this.#frame++;
    this.#advance(seconds);
    this.#wanted = [];
    const quarters: Quarter[] = [];
    const first = blockAt({ east: place.east - HORIZON, south: place.south - HORIZON }, COARSEST);
    const last = blockAt({ east: place.east + HORIZON, south: place.south + HORIZON }, COARSEST);
    for (let y = first.y; y <= last.y; y++) {
      for (let x = first.x; x <= last.x; x++) {
        const address = { z: COARSEST, x, y };
        if (distanceTo(address, place) > HORIZON) continue;
        const block = this.#need(address, place, height);
        if (block) this.#choose(block, place, height, sees, quarters);
      }
    }
    this.#ask();
    this.#fillSome();
    return quarters;
  }

  /** Draws a block, quarters of it by the blocks below where these are near and there. */
  #choose(block: Block, place: Place, height: number, sees: (block: Block) => boolean, quarters: Quarter[]): void {
    block.used = this.#frame;
    const { z, x, y } = block.address;
    const visible = sees(block);
    for (const [dx, dy] of [[0, 0], [1, 0], [0, 1], [1, 1]] as const) {
      const below = { z: z + 1, x: 2 * x + dx, y: 2 * y + dy };
      const finer = z < FINEST && Math.hypot(distanceTo(below, place), height) < this.refinement * sideOf(z + 1);
      const child = finer ? this.#need(below, place, height) : undefined;
      if (child) this.#choose(child, place, height, sees, quarters);
      else if (visible) quarters.push({ block, corner: [dx * 32, dy * 32] });
    }
  }

  /** The block, or a wish for it. */
  #need(address: Address, place: Place, height: number): Block | undefined {
    const block = this.#find(address);
    if (!block) this.#wanted.push({ address, urgency: Math.hypot(distanceTo(address, place), height) });
    return block;
  }

  /** Asks for what is wanted most: what looks coarsest from here, large blocks before small ones. */
  #ask(): void {
    if (this.#phase === 'fetching') this.#check();
    const calm = this.#phase === 'still' || this.#phase === 'fetching';
    if (!calm || !this.#loader.free || this.#wanted.length === 0) return;
    if (this.#free.length < AT_ONCE && !this.#oldest()) {
      this.#wanted = []; // all layers are in use: what is finer has to wait
      return;
    }
    this.#wanted.sort((a, b) => a.address.z - b.address.z || a.urgency - b.urgency);
    for (const { address } of this.#wanted) {
      if (!this.#loader.free) return;
      if (this.#find(address) || this.#loader.asks(this.revision, address)) continue;
      const revision = this.revision;
      void this.#loader.ask(revision, address, '', (answer) => this.#receive(revision, address, answer)).then(() => this.#ask());
    }
  }

  /** Heights came: they are kept if the ground still is of their revision and at rest, and asked for again otherwise. */
  #receive(revision: string, address: Address, answer: Heights | undefined): void {
    const calm = this.#phase === 'still' || this.#phase === 'fetching';
    if (!answer?.heights || revision !== this.revision || !calm || this.#find(address)) return;
    const parent = this.#find(parentOf(address));
    if (!parent && address.z > COARSEST) return;
    const layer = this.#layer();
    if (layer === undefined) return;
    const block = new Block(address, answer.heights, answer.tag, layer, parent);
    block.used = this.#frame;
    this.#blocks.set(keyOf(address), block);
    for (const time of ['before', 'now'] as const) this.#fill(block, time);
    this.events.filled(layer);
    // The normals along common edges become exact.
    for (const other of this.#beside(block)) this.#dirty.add(other);
  }

  /** The block that was needed least recently, if it is needed no more. */
  #oldest(): Block | undefined {
    let oldest: Block | undefined;
    const parents = new Set([...this.#blocks.values()].map(({ parent }) => parent));
    for (const block of this.#blocks.values()) {
      if (!parents.has(block) && block.used < this.#frame - 2 && (!oldest || block.used < oldest.used)) oldest = block;
    }
    return oldest;
  }

  /** A layer nobody uses: a free one, or that of a block that is given up. */
  #layer(): number | undefined {
    const free = this.#free.pop();
    if (free !== undefined) return free;
    const oldest = this.#oldest();
    if (!oldest) return undefined;
    this.#blocks.delete(keyOf(oldest.address));
    this.#dirty.delete(oldest);
    this.#checked.delete(oldest);
    return oldest.layer;
  }

  #fill(block: Block, time: 'before' | 'now'): void {
    fill(this.data.subarray(block.layer * LAYER, (block.layer + 1) * LAYER), block, time, this.#find);
  }

  /** Writes some of what has changed to the texture; both times, or the one that is not seen. */
  #fillSome(): void {
    let left = FILLS_A_FRAME;
    for (const block of this.#dirty) {
      if (left-- === 0) return;
      this.#dirty.delete(block);
      // While the ground is about to move, what is seen is `before`; while it settles, it is `now`.
      if (this.#phase !== 'filling') this.#fill(block, 'before');
      if (this.#phase !== 'settling') this.#fill(block, 'now');
      this.events.filled(block.layer);
    }
  }

  #advance(seconds: number): void {
    if (this.#queued && (this.#phase === 'still' || this.#phase === 'fetching')) this.#begin(this.#queued);
    if (this.#phase === 'filling' && this.#dirty.size === 0) this.#move();
    else if (this.#phase === 'moving') this.#share = this.instantly ? 1 : Math.min(1, this.#share + seconds / MOVE_S);
    else if (this.#phase === 'settling' && this.#dirty.size === 0) this.#phase = 'still';
    if (this.#phase === 'moving' && this.#share === 1) this.#settle();
  }

  #begin(target: Target): void {
    this.#queued = undefined;
    this.#target = target;
    this.#phase = 'fetching';
    this.#checked = new Set();
    for (const block of this.#blocks.values()) block.next = undefined;
  }

  /** Asks of every block that may have changed whether it has; once all is known, the new heights are written. */
  #check(): void {
    const target = this.#target;
    if (!target || this.#phase !== 'fetching') return;
    let open = 0;
    for (const block of this.#blocks.values()) {
      const may = target.changed === undefined || (target.changed && meets(block.address, target.changed));
      if (block.next || !may) continue;
      open++;
      if (!this.#loader.free || this.#checked.has(block)) continue;
      this.#checked.add(block);
      const take = (answer: Heights | undefined) => {
        if (this.#target !== target) return;
        this.#checked.delete(block);
        if (!answer) return; // asked again
        block.expect(answer.heights, answer.tag);
      };
      void this.#loader.ask(target.revision, block.address, block.tag, take).then(() => this.#check());
    }
    if (open === 0) this.#write(target);
  }

  #write(target: Target): void {
    this.revision = target.revision;
    this.#share = 0;
    for (const block of this.#blocks.values()) block.turn();
    this.#phase = 'filling';
    this.#touch();
    if (this.#dirty.size === 0) this.#rest();
  }

  /** What moves is to be written, and what lies beside or below it and shows its heights, too. */
  #touch(): void {
    for (const block of this.#blocks.values()) {
      if (block.moves || block.parent?.moves || this.#beside(block).some(({ moves }) => moves)) this.#dirty.add(block);
    }
  }

  #beside({ address: { z, x, y } }: Block): Block[] {
    const places = [[-1, 0], [1, 0], [0, -1], [0, 1]] as const;
    return places.map(([dx, dy]) => this.#find({ z, x: x + dx, y: y + dy })).filter((block) => block !== undefined);
  }

  #move(): void {
    this.#phase = 'moving';
    this.events.arrived(this.revision, [...this.#blocks.values()].filter(({ moves }) => moves).length);
  }

  /** Nothing moved: the revision alone is new. */
  #rest(): void {
    this.#share = 1;
    this.#phase = 'still';
    this.#target = undefined;
    this.events.arrived(this.revision, 0);
  }

  #settle(): void {
    this.#phase = 'settling';
    this.#target = undefined;
    this.#touch();
    for (const block of this.#blocks.values()) block.settle();
  }
}
