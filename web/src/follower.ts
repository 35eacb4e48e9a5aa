import { listen, type ServerEvent } from './events.ts';

/** Within this time what is heard of may have been saved by this page, and be on its way to the map. */
const OWN_SAVE_MS = 300;

export interface FollowerEvents {
  /** Resolves when nothing of the page's own is on its way to the map. */
  settled(): Promise<void>;
  /** The revision that is shown, as far as is known. */
  shows(): string | undefined;
  /** The world has, or may have, another revision. */
  changed(name: string): void;
  gone(name: string): void;
}

/** Listens to what happens to one world at a time. */
export class Follower {
  #name: string | undefined;
  #events: { stop(): void } | undefined;

  constructor(readonly events: FollowerEvents) {}

  follow(name: string): void {
    if (name === this.#name) return;
    this.#name = name;
    this.#events?.stop();
    this.#events = listen(`events?world=${name}`, {
      heard: (event) => void this.#hear(name, event),
      missed: () => this.events.changed(name),
    });
  }

  async #hear(name: string, { event, data }: ServerEvent): Promise<void> {
    if (event !== 'world' && event !== 'generation') return;
    const { revision } = JSON.parse(data) as { revision?: string | null };
    await new Promise((resolve) => setTimeout(resolve, OWN_SAVE_MS));
    await this.events.settled();
    if (name !== this.#name || revision === this.events.shows()) return;
    if (revision) this.events.changed(name);
    else this.events.gone(name);
  }
}
