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
  /** Something may have happened that was not heard: at the beginning, and after a silence too long for the server's memory. */
  missed(): void;
}

/** Resolves when the page is seen, or when the signal says stop. */
function seen(signal: AbortSignal): Promise<void> {
  if (!document.hidden) return Promise.resolve();
  return new Promise((resolve) => {
    const end = () => {
      document.removeEventListener('visibilitychange', end);
      signal.removeEventListener('abort', end);
      resolve();
    };
    document.addEventListener('visibilitychange', end);
    signal.addEventListener('abort', end);
  });
}

/** Resolves after a while, or at once when the signal says stop. */
function rest(milliseconds: number, signal: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, milliseconds);
    signal.addEventListener('abort', () => {
      clearTimeout(timer);
      resolve();
    });
  });
}

/**
 * Follows the server's events until `stop` is called. Comes back by itself where it was when the connection is lost, and
 * lets go of it while the page is hidden: browsers have six for all tabs together.
 */
export function listen(path: string, listener: Listener): { stop(): void } {
  const abort = new AbortController();
  void follow(path, listener, abort.signal);
  return { stop: () => abort.abort() };
}

async function follow(path: string, listener: Listener, stop: AbortSignal): Promise<void> {
  let last: string | undefined;
  let wait = FIRST_WAIT_MS;
  while (!stop.aborted) {
    await seen(stop);
    const away = new AbortController();
    const leave = () => (stop.aborted || document.hidden) && away.abort();
    stop.addEventListener('abort', leave);
    document.addEventListener('visibilitychange', leave);
    try {
      const back: Record<string, string> = last === undefined ? {} : { 'Last-Event-ID': last };
      const headers = { Accept: 'text/event-stream', ...back, ...authorization() };
      const response = await fetch(path, { headers, cache: 'no-store', signal: away.signal });
      // A server without events, or one that wants another key: the page works without them.
      if ([401, 403, 404].includes(response.status)) return;
      if (response.ok && response.body) {
        wait = FIRST_WAIT_MS;
        if (last === undefined) listener.missed();
        await read(response.body, (event) => {
          last = event.id ?? last;
          if (event.event === 'reset') listener.missed();
          else listener.heard(event);
        });
      }
    } catch {
      // Lost, hidden or stopped; below it is tried again unless the page has stopped it.
    } finally {
      stop.removeEventListener('abort', leave);
      document.removeEventListener('visibilitychange', leave);
    }
    if (stop.aborted || document.hidden) continue;
    await rest(wait, stop);
    wait = Math.min(LONGEST_WAIT_MS, wait * 2);
  }
}

async function read(body: ReadableStream<Uint8Array>, heard: (event: ServerEvent) => void): Promise<void> {
  const parser = new EventParser();
  const decoder = new TextDecoder();
  const reader = body.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    for (const event of parser.push(decoder.decode(value, { stream: true }))) heard(event);
  }
}
