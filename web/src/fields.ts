import type { Json, JsonObject } from './api.ts';

/** The fields of a world document, and the way between a document and what stands in a form. */

export interface Field {
  /** JSON pointer into the document. */
  pointer: string;
  label: string;
  kind: 'text' | 'number' | 'integer' | 'json' | 'programme';
  unit?: string;
  hint?: string;
  /** Below "More": seldom changed. */
  more?: boolean;
  /** A text area of so many lines. */
  lines?: number;
  /** Two of a kind stand side by side. */
  half?: boolean;
}

export const FIELDS: readonly Field[] = [
  { pointer: '/title', label: 'Title', kind: 'text' },
  { pointer: '/base/programme', label: 'Programme', kind: 'programme', lines: 6 },
  { pointer: '/seed', label: 'Seed', kind: 'integer', half: true },
  { pointer: '/base/scale', label: 'Scale', unit: 'm', kind: 'number', hint: 'Metres per unit of x and y', half: true },
  { pointer: '/base/amplitude', label: 'Amplitude', unit: 'm', kind: 'number', hint: 'Times the programme', half: true },
  { pointer: '/base/datum', label: 'Datum', unit: 'm', kind: 'number', hint: 'Added to it', half: true },
  { pointer: '/sea_level', label: 'Sea level', unit: 'm', kind: 'number', half: true },
  { pointer: '/description', label: 'Description', kind: 'text', lines: 2, more: true },
  { pointer: '/attribution', label: 'Attribution', kind: 'text', more: true },
  { pointer: '/elevation/min', label: 'Lowest', unit: 'm', kind: 'number', more: true, half: true },
  { pointer: '/elevation/max', label: 'Highest', unit: 'm', kind: 'number', more: true, half: true },
  { pointer: '/base/origin/0', label: 'Origin east', unit: 'm', kind: 'number', more: true, half: true },
  { pointer: '/base/origin/1', label: 'Origin north', unit: 'm', kind: 'number', more: true, half: true },
  { pointer: '/generator', label: 'Generator', kind: 'integer', more: true, hint: 'Version of the algorithms' },
  { pointer: '/layers', label: 'Layers', kind: 'json', lines: 3, more: true },
];

/** What stands in the form, by pointer. */
export type Values = Record<string, string>;

/** What a new world starts from. */
export const STARTER: JsonObject = {
  seed: 1,
  base: { programme: 'ridged_multifractal(1.0, 2.0, 8, 1.0, 2.0)', scale: 20000, amplitude: 1500, datum: 0 },
};

const segments = (pointer: string) =>
  pointer.split('/').slice(1).map((part) => part.replaceAll('~1', '/').replaceAll('~0', '~'));

function get(document: Json, pointer: string): Json | undefined {
  let value: Json | undefined = document;
  for (const part of segments(pointer)) {
    if (value === null || typeof value !== 'object') return undefined;
    value = (value as JsonObject)[part];
  }
  return value;
}

function set(document: JsonObject, pointer: string, value: Json | undefined): void {
  const path = segments(pointer);
  const last = path.pop() ?? '';
  let parent = document;
  path.forEach((part, i) => {
    const missing = parent[part] === undefined || parent[part] === null;
    if (missing) {
      if (value === undefined) return;
      parent[part] = /^\d+$/.test(path[i + 1] ?? last) ? [] : {};
    }
    parent = parent[part] as JsonObject;
  });
  if (parent === undefined || parent === null) return;
  if (value === undefined) delete parent[last];
  else parent[last] = value;
}

function show(value: Json | undefined): string {
  if (value === undefined || value === null) return '';
  return typeof value === 'object' ? JSON.stringify(value, null, 2) : String(value);
}

export function toValues(document: JsonObject): Values {
  return Object.fromEntries(FIELDS.map((field) => [field.pointer, show(get(document, field.pointer))]));
}

/** The value that a text stands for; a blank optional field is left to the server's default. */
function parse(field: Field, text: string): Json | undefined {
  const trimmed = text.trim();
  const tree = field.kind === 'json' || (field.kind === 'programme' && trimmed.startsWith('{'));
  if (field.kind === 'text') return trimmed === '' ? undefined : text;
  if (field.kind === 'programme' && !tree) return text;
  if (trimmed === '') return undefined;
  if (tree) return JSON.parse(trimmed) as Json;
  const number = Number(trimmed.replaceAll('\u2212', '-'));
  if (!Number.isFinite(number)) throw new Error(`"${trimmed}" is not a number`);
  if (field.kind === 'integer' && !Number.isSafeInteger(number)) throw new Error(`"${trimmed}" is not a whole number`);
  return number;
}

/**
 * The document that the form describes. What the form has no field for stays as it is in `original`.
 * Texts that stand for nothing are reported by pointer.
 */
export function toDocument(values: Values, original: JsonObject): { document: JsonObject; faults: Map<string, string> } {
  const document = structuredClone(original);
  const faults = new Map<string, string>();
  for (const field of FIELDS) {
    try {
      const value = parse(field, values[field.pointer] ?? '');
      if (value === undefined && /\/\d+$/.test(field.pointer) && get(document, field.pointer) !== undefined) {
        throw new Error('is missing'); // a list cannot have a hole
      }
      set(document, field.pointer, value);
    } catch (error) {
      faults.set(field.pointer, error instanceof Error ? error.message : String(error));
    }
  }
  return { document, faults };
}

/** The field that an error belongs to: the one it names or lies in, else the first one inside what it names. */
export function fieldFor(pointer: string): Field | undefined {
  const inside = (whole: string, part: string) => part === whole || part.startsWith(`${whole}/`);
  return (
    FIELDS.find((field) => inside(field.pointer, pointer)) ??
    (pointer === '' ? undefined : FIELDS.find((field) => inside(pointer, field.pointer)))
  );
}
