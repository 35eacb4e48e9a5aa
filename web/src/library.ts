import type { Fault, Json, JsonObject, ProgrammeEntry } from './api.ts';
import { toValues, type Values } from './fields.ts';

/** What stands between a world's document, its form and the programme library. */

/** Where each part of a library programme stands in a world. */
const PLACES: readonly (readonly [library: string, world: readonly [string, ...string[]]])[] = [
  ['programme', ['base', 'programme']],
  ['scale', ['base', 'scale']],
  ['amplitude', ['base', 'amplitude']],
  ['datum', ['base', 'datum']],
  ['sea_level', ['sea_level']],
  ['elevation', ['elevation']],
  ['seed', ['seed']],
];

/** What a chosen programme brings into the form; the seed stays the world's own. */
const BROUGHT = /^\/(base\/(programme|scale|amplitude|datum)|sea_level|elevation\/(min|max))$/;

/** The library document of a world's programme. */
export function toProgramme(world: JsonObject): JsonObject {
  const found = PLACES.flatMap(([key, path]) => {
    let value: Json | undefined = world;
    for (const step of path) value = (value as JsonObject | undefined)?.[step];
    return value === undefined ? [] : [[key, value] as const];
  });
  return Object.fromEntries(found);
}

/** The form's values with a library programme in them. */
export function withProgramme(values: Values, programme: JsonObject): Values {
  const world: JsonObject = {};
  for (const [key, path] of PLACES) {
    const [first, second] = path;
    const value = programme[key];
    if (value === undefined) continue;
    if (second === undefined) world[first] = value;
    else world[first] = { ...(world[first] as JsonObject | undefined), [second]: value };
  }
  const brought = Object.entries(toValues(world)).filter(([pointer]) => BROUGHT.test(pointer));
  return { ...values, ...Object.fromEntries(brought) };
}

/** A fault of a library document at its place in the world that it came from. */
export function inWorld(fault: Fault): Fault {
  const [, key, ...rest] = fault.pointer.split('/');
  if (key === undefined) return fault; // the document as a whole
  const place = PLACES.find(([library]) => library === key)?.[1] ?? [key];
  return { ...fault, pointer: ['', ...place, ...rest].join('/') };
}

/** Tags as somebody types them: between spaces or commas, each once. */
export function readTags(text: string): string[] {
  return [...new Set(text.toLowerCase().split(/[\s,;#]+/).filter((tag) => tag !== ''))];
}

/** Every tag of some programmes, the most used first. */
export function tagsOf(programmes: readonly ProgrammeEntry[]): string[] {
  const counts = new Map<string, number>();
  for (const tag of programmes.flatMap(({ tags }) => tags)) counts.set(tag, (counts.get(tag) ?? 0) + 1);
  return [...counts].sort(([a, m], [b, n]) => n - m || a.localeCompare(b)).map(([tag]) => tag);
}

/** Whether a programme has every tag, and every word somewhere in what is said about it. As the server's `?tag=` and `?q=`. */
export function isFound(entry: ProgrammeEntry, tags: ReadonlySet<string>, text: string): boolean {
  const said = [entry.name, entry.title, entry.description ?? '', entry.origin, ...entry.tags].join('\n').toLowerCase();
  const words = text.toLowerCase().split(/\s+/).filter((word) => word !== '');
  return [...tags].every((tag) => entry.tags.includes(tag)) && words.every((word) => said.includes(word));
}
