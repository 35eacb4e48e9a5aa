import { authorization } from './key.ts';

/** What the server says of itself while it runs (`GET /events`), read with fetch: EventSource cannot send a key. */

/** One message of a stream of events. */
export interface ServerEvent {
  event: string;
  data: string;
  id?: string | undefined;
}

/** Takes a stream's text as it comes and gives the events that are whole (WHATWG HTML, server-sent events). */
export class EventParser {
  #rest = '';
  #data: string[] = [];
  #event = '';
  #id: string | undefined;

  push(text: string): ServerEvent[] {
    // A carriage return at the end may be half of a line's end.
    const lines = (this.#rest + text).split(/\r\n|\n|\r(?!$)/);
    this.#rest = lines.pop() ?? '';
    return lines.flatMap((line) => this.#line(line) ?? []);
  }

  #line(line: string): ServerEvent | undefined {
    if (line === '') return this.#dispatch();
    const colon = line.indexOf(':');
    if (colon === 0) return undefined; // a comment keeps the connection open
    const field = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? '' : line.slice(colon + 1).replace(/^ /, '');
    if (field === 'data') this.#data.push(value);
    else if (field === 'event') this.#event = value;
    else if (field === 'id') this.#id = value;
    return undefined;
  }

  #dispatch(): ServerEvent | undefined {
    const said = this.#data.length > 0 ? { event: this.#event || 'message', data: this.#data.join('\n'), id: this.#id } : undefined;
    this.#data = [];
    this.#event = '';
    return said;
  }
}

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 15_000;

export interface Listener {
  /** A message came. */
  heard(event: ServerEvent): void;
  /** The connection stands, for the first time or again: what happened meanwhile was not heard. */
  opened(again: boolean): void;
  closed?(): void;
}

/** Follows the server's events until `stop` is called; comes back by itself when the connection is lost. */
export function listen(path: string, listener: Listener): { stop(): void } {
  const abort = new AbortController();
  void follow(path, listener, abort.signal);
  return { stop: () => abort.abort() };
}

async function follow(path: string, listener: Listener, signal: AbortSignal): Promise<void> {
  let again = false;
  let wait = FIRST_WAIT_MS;
  while (!signal.aborted) {
    try {
      const response = await fetch(path, { headers: { Accept: 'text/event-stream', ...authorization() }, cache: 'no-store', signal });
      // A server without events, or one that wants a key: the page works without them.
      if (response.status === 404 || response.status === 401 || response.status === 403) return;
      if (response.ok && response.body) {
        listener.opened(again);
        again = true;
        wait = FIRST_WAIT_MS;
        await read(response.body, listener);
      }
    } catch {
      // Lost, or stopped by the page; the first is tried again below.
    }
    if (signal.aborted) return;
    listener.closed?.();
    await new Promise((resolve) => setTimeout(resolve, wait));
    wait = Math.min(LONGEST_WAIT_MS, wait * 2);
  }
}

async function read(body: ReadableStream<Uint8Array>, listener: Listener): Promise<void> {
  const parser = new EventParser();
  const decoder = new TextDecoder();
  const reader = body.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    for (const event of parser.push(decoder.decode(value, { stream: true }))) listener.heard(event);
  }
}
