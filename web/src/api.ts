import type { StyleSpecification } from 'maplibre-gl';
import { askKey, authorization } from './key.ts';
import type { Generation, SessionRecord } from './studio/record.ts';

/** The server's calls that the viewer uses. All addresses are relative: the page may live under a base path. */

export type Json = string | number | boolean | null | Json[] | JsonObject;
export type JsonObject = { [key: string]: Json };

export interface CatalogEntry {
  name: string;
  title?: string;
  revision: string;
}

/** A programme in the list of the library. */
export interface ProgrammeEntry {
  name: string;
  title: string;
  description?: string;
  tags: string[];
  origin: string;
  revision: string;
}

/** One thing that is wrong with a document. `start` and `end` count Unicode scalar values of a programme's text. */
export interface Fault {
  pointer: string;
  detail: string;
  at?: string;
  start?: number;
  end?: number;
}

/** A stored document and the ETag it was stored under. */
export interface Stored {
  document: JsonObject;
  etag: string;
}

/** The server refused: RFC 9457, or whatever stands between us and the server answered. */
export class Problem extends Error {
  constructor(
    readonly status: number,
    message: string,
    readonly faults: Fault[] = [],
  ) {
    super(message);
  }
}

/** No answer at all. */
export class Unreachable extends Error {
  constructor() {
    super('The server does not answer.');
  }
}

async function problem(response: Response): Promise<Problem> {
  const plain = `The server answered ${response.status} ${response.statusText}`.trim() + '.';
  try {
    const body = (await response.json()) as { title?: string; detail?: string; errors?: Partial<Fault>[] };
    const isFault = (entry: Partial<Fault>): entry is Fault => typeof entry.pointer === 'string';
    const errors = body.errors ?? [];
    // What is wrong with the request, not with the document, has no pointer and is simply said.
    const said = errors.filter((entry) => !isFault(entry)).map(({ detail }) => detail);
    return new Problem(response.status, [body.detail ?? body.title ?? plain, ...said].join(' '), errors.filter(isFault));
  } catch {
    return new Problem(response.status, plain);
  }
}

export async function request(path: string, init: RequestInit = {}): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path, { ...init, headers: { ...init.headers, ...authorization() } });
  } catch {
    throw new Unreachable();
  }
  if (response.status === 401 && (await askKey())) return request(path, init);
  if (!response.ok) throw await problem(response);
  return response;
}

export const send = (method: string, document: JsonObject, headers: Record<string, string> = {}): RequestInit => ({
  method,
  headers: { 'Content-Type': 'application/json', ...headers },
  body: JSON.stringify(document),
});

async function stored(response: Response): Promise<Stored> {
  return { document: (await response.json()) as JsonObject, etag: response.headers.get('ETag') ?? '' };
}

export async function catalog(): Promise<CatalogEntry[]> {
  const response = await request('catalog', { cache: 'no-cache' });
  return ((await response.json()) as { worlds: CatalogEntry[] }).worlds;
}

export async function readWorld(name: string): Promise<Stored> {
  return stored(await request(`worlds/${name}`, { cache: 'no-cache' }));
}

/** Saves over the revision `etag`; a Problem 412 says that another one has been saved since. */
export async function saveWorld(name: string, document: JsonObject, etag: string): Promise<Stored> {
  return stored(await request(`worlds/${name}`, send('PUT', document, etag ? { 'If-Match': etag } : {})));
}

export async function createWorld(name: string, document: JsonObject): Promise<void> {
  await request(`worlds?name=${encodeURIComponent(name)}`, send('POST', document));
}

export async function readStyle(name: string): Promise<StyleSpecification> {
  const response = await request(`worlds/${name}/style.json`, { cache: 'no-cache' });
  return (await response.json()) as StyleSpecification;
}

export async function programmes(): Promise<ProgrammeEntry[]> {
  const response = await request('programmes', { cache: 'no-cache' });
  return ((await response.json()) as { programmes: ProgrammeEntry[] }).programmes;
}

export async function readProgramme(name: string): Promise<Stored> {
  return stored(await request(`programmes/${name}`, { cache: 'no-cache' }));
}

export async function createProgramme(name: string, document: JsonObject): Promise<void> {
  await request(`programmes?name=${encodeURIComponent(name)}`, send('POST', document));
}

/** Saves over the revision `etag`. */
export async function replaceProgramme(name: string, document: JsonObject, etag: string): Promise<void> {
  await request(`programmes/${name}`, send('PUT', document, { 'If-Match': etag }));
}

export async function sessions(): Promise<{ name: string; generations: number }[]> {
  const response = await request('breeding', { cache: 'no-cache' });
  return ((await response.json()) as { sessions: { name: string; generations: number }[] }).sessions;
}

export async function readSession(name: string): Promise<{ record: SessionRecord; etag: string }> {
  const { document, etag } = await stored(await request(`breeding/${name}`, { cache: 'no-cache' }));
  return { record: document as unknown as SessionRecord, etag };
}

export async function createSession(name: string, record: SessionRecord): Promise<void> {
  await request(`breeding?name=${encodeURIComponent(name)}`, send('POST', record as unknown as JsonObject));
}

/** Saves over the revision `etag`; answers that of what is saved. */
export async function saveSession(name: string, record: SessionRecord, etag: string): Promise<string> {
  return (await stored(await request(`breeding/${name}`, send('PUT', record as unknown as JsonObject, { 'If-Match': etag })))).etag;
}

export async function deleteSession(name: string): Promise<void> {
  await request(`breeding/${name}`, { method: 'DELETE' });
}

export async function readGeneration(name: string, generation: number): Promise<Generation> {
  return (await (await request(`breeding/${name}/generations/${generation}`, { cache: 'no-cache' })).json()) as Generation;
}

/** Long work. */
export interface Job {
  id: string;
  kind: 'paths' | 'evolution';
  /** When it was asked for. */
  time: string;
  state: 'waiting' | 'running' | 'stopped' | 'done' | 'failed';
  /** 0 … 1 */
  progress: number;
  /** Address of the raster that it made. */
  raster?: string;
  failure?: string;
  /** What it is asked for; not in lists. */
  work?: JsonObject;
}

/** About what a job will make: a picture and where it lies, in metres. */
export interface JobPreview {
  bbox: [number, number, number, number];
  elevation: [number, number];
  steps: number;
  picture: string;
}

export async function previewJob(work: JsonObject): Promise<JobPreview> {
  return (await (await request('jobs/preview', send('POST', work))).json()) as JobPreview;
}

export async function askJob(work: JsonObject): Promise<Job> {
  return (await (await request('jobs', send('POST', work))).json()) as Job;
}

export async function readJob(id: string): Promise<Job> {
  return (await (await request(`jobs/${id}`, { cache: 'no-cache' })).json()) as Job;
}

export async function jobs(): Promise<Job[]> {
  return ((await (await request('jobs', { cache: 'no-cache' })).json()) as { jobs: Job[] }).jobs;
}

export async function forgetJob(id: string): Promise<void> {
  await request(`jobs/${id}`, { method: 'DELETE' });
}

/** Lays a job aside; what it has done stays. */
export async function stopJob(id: string): Promise<Job> {
  return (await (await request(`jobs/${id}/stop`, { method: 'POST' })).json()) as Job;
}

/** Lets a stopped job go on. */
export async function resumeJob(id: string): Promise<Job> {
  return (await (await request(`jobs/${id}/resume`, { method: 'POST' })).json()) as Job;
}

/** A generation of an evolution: scores are 0 … 1. */
export interface GenerationPoint {
  generation: number;
  best: number;
  mean: number;
  evaluations: number;
}

/** The best programme of an evolution so far, with what a world needs to show it. */
export interface Best {
  generation: number;
  programme: string;
  score: number;
  criteria: { criterion: string; weight: number; score: number }[];
  seed: number;
  scale: number;
  amplitude: number;
  datum: number;
  side: number;
}

/** How an evolution goes; nothing is there before its first generation. */
export interface Evolution {
  generation?: number;
  of: number;
  curve: GenerationPoint[];
  best?: Best;
}

/** The curve from a generation on, and the best so far. */
export async function readEvolution(id: string, from: number): Promise<Evolution> {
  return (await (await request(`jobs/${id}/evolution?from=${from}`, { cache: 'no-cache' })).json()) as Evolution;
}

/** Slopes, heights and roughness of a square of a world about a place, in metres. */
export async function statistics(world: string, { x, y }: { x: number; y: number }, side: number, spacing: number): Promise<JsonObject> {
  const bbox = [x - side / 2, y - side / 2, x + side / 2, y + side / 2];
  return (await (await request(`worlds/${world}/statistics`, send('POST', { bbox, spacing }))).json()) as JsonObject;
}

/** A picture that needs the user's key, as an address of its own. */
export async function keyedPicture(path: string): Promise<string> {
  return URL.createObjectURL(await (await request(path)).blob());
}

/** Where the picture of a programme is; the address changes with the programme, so that no old picture is shown. */
export const previewUrl = ({ name, revision }: ProgrammeEntry, pixels: number) =>
  `programmes/${name}/preview.png?size=${pixels}#${revision}`;
