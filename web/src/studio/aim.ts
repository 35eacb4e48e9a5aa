import type { Fault, Json, JsonObject } from '../api.ts';

/** What an evolution is asked for, as a form. */

export interface AimField {
  id: string;
  label: string;
  unit?: string;
  value: string;
  min?: number;
  max?: number;
  step?: number | 'any';
  hint?: string;
  /** Pasted numbers instead of one. */
  isText?: boolean;
}

export interface Criterion {
  name: string;
  label: string;
  hint: string;
  on: boolean;
  fields: AimField[];
}

const weight = (name: string, value: string): AimField => ({ id: `${name}-weight`, label: 'Counts', unit: '×', value, min: 0, max: 1e6, step: 'any' });
const slope = (name: string): AimField => ({ id: `${name}-slope`, label: 'Slopes up to', unit: '°', value: '15', min: 0.1, max: 89.9, step: 'any' });

export const CRITERIA: readonly Criterion[] = [
  {
    name: 'accessibility', label: 'Ground that can be reached', on: true,
    hint: 'The share of the ground in one connected area that is not too steep.',
    fields: [{ id: 'accessibility-share', label: 'Share', unit: '%', value: '80', min: 0, max: 100, step: 'any' }, slope('accessibility'), weight('accessibility', '3')],
  },
  {
    name: 'edges', label: 'Many obstacles', on: true,
    hint: 'Length of the edges of what is too steep: many obstacles have longer ones than one.',
    fields: [{ id: 'edges-density', label: 'Edges', unit: 'm/km²', value: '6000', min: 1, step: 'any' }, slope('edges'), weight('edges', '1')],
  },
  {
    name: 'slopes', label: 'Slopes', on: false,
    hint: 'How steep the flattest, the middle and the steepest ground is.',
    fields: [
      { id: 'slopes-least', label: 'Flattest', unit: '°', value: '0', min: 0, max: 90, step: 'any' },
      { id: 'slopes-middle', label: 'Half below', unit: '°', value: '8', min: 0, max: 90, step: 'any' },
      { id: 'slopes-greatest', label: 'Steepest', unit: '°', value: '40', min: 0, max: 90, step: 'any' },
      weight('slopes', '1'),
    ],
  },
  {
    name: 'elevations', label: 'Heights', on: false,
    hint: 'How much of the relief half of the ground lies below: 10 % is a plain with mountains, 90 % a plateau with gorges.',
    fields: [{ id: 'elevations-middle', label: 'Half below', unit: '% of the relief', value: '30', min: 0, max: 100, step: 'any' }, weight('elevations', '1')],
  },
  {
    name: 'roughness', label: 'Roughness', on: false,
    hint: 'Root mean square of bumps from sample to sample, metres a metre: 0.02 is smooth, 0.3 torn.',
    fields: [{ id: 'roughness-value', label: 'Bumps', unit: 'm/m', value: '0.05', min: 0.0001, step: 'any' }, weight('roughness', '1')],
  },
  {
    name: 'likeness', label: 'Like other terrain', on: false,
    hint: 'Slopes, heights and roughness of a square as large as the one that is judged: measured from a world here, or pasted.',
    fields: [{ id: 'likeness-sample', label: 'Statistics', value: '', isText: true, hint: '{"slopes": […], "heights": […], "relief": …, "roughness": …}' }, weight('likeness', '1')],
  },
];

export const GROUND: readonly AimField[] = [
  { id: 'relief', label: 'Relief', unit: 'm', value: '300', min: 0.01, max: 1e9, step: 'any', hint: 'Between the heights that 2 % and 98 % of the ground lie below.' },
  { id: 'side', label: 'Side of the square', unit: 'm', value: '4000', min: 0.01, max: 1e9, step: 'any', hint: 'What is judged, about the origin.' },
  { id: 'scale', label: 'Programme unit', unit: 'm', value: '1000', min: 0.01, max: 1e9, step: 'any', hint: 'How large features are.' },
  { id: 'samples', label: 'Samples a side', value: '128', min: 16, max: 1024, step: 1 },
  { id: 'world-seed', label: 'Seed of the world', value: '0', min: 0, max: Number.MAX_SAFE_INTEGER, step: 1 },
];

export const BREEDING: readonly AimField[] = [
  { id: 'generations', label: 'Generations', value: '40', min: 0, max: 10000, step: 1 },
  { id: 'population', label: 'Individuals an island', value: '64', min: 4, max: 65536, step: 1 },
  { id: 'islands', label: 'Islands', value: '1', min: 1, max: 64, step: 1, hint: 'They exchange their best every five generations.' },
  { id: 'goal', label: 'Enough at', unit: '%', value: '', min: 0, max: 100, step: 'any', hint: 'Empty: all generations.' },
  { id: 'seed', label: 'Seed of the evolution', value: '0', min: 0, max: Number.MAX_SAFE_INTEGER, step: 1, hint: 'Another one finds other terrain.' },
];

/** The form as it is filled in: texts by the fields' ids, and what is wanted. */
export interface Wish {
  values: { [id: string]: string };
  wanted: string[];
}

export const fieldsOfAll = (): AimField[] => [...CRITERIA.flatMap(({ fields }) => fields), ...GROUND, ...BREEDING];

export const emptyWish = (): Wish => ({
  values: Object.fromEntries(fieldsOfAll().map(({ id, value }) => [id, value])),
  wanted: CRITERIA.filter(({ on }) => on).map(({ name }) => name),
});

/** A text as a number; what is none goes to the server as it is, which says what is wrong with it. */
function number(text: string | undefined, factor = 1): Json {
  const value = Number(text);
  if (text === undefined || text.trim() === '' || Number.isNaN(value)) return text?.trim() || null;
  // Percents of few digits become shares of few digits.
  return factor === 1 ? value : Number((value * factor).toPrecision(12));
}

function pasted(text: string): Json {
  try {
    return JSON.parse(text) as Json;
  } catch {
    return text;
  }
}

function criterionOf(name: string, values: Wish['values']): JsonObject {
  const of = (field: string, factor?: number) => number(values[`${name}-${field}`], factor);
  switch (name) {
    case 'accessibility': return { accessibility: { slope: of('slope'), share: of('share', 0.01) } };
    case 'edges': return { edges: { slope: of('slope'), density: of('density') } };
    case 'slopes': return { slopes: { degrees: [of('least'), of('middle'), of('greatest')] } };
    case 'elevations': return { elevations: { heights: [0, of('middle', 0.01), 1] } };
    case 'roughness': return { roughness: { value: of('value') } };
    default: return { likeness: { sample: pasted(values['likeness-sample'] ?? '') } };
  }
}

/** What the server is asked for. */
export function workOf({ values, wanted }: Wish): JsonObject {
  const terms = wanted.map((name) => ({ weight: number(values[`${name}-weight`]), criterion: criterionOf(name, values) }));
  const of = (id: string) => number(values[id]);
  const migration = { every: 5, count: Math.min(1, Math.floor(Number(values['population']) / 2)) || 0 };
  return {
    evolution: {
      aim: { seed: of('world-seed'), scale: of('scale'), side: of('side'), samples: of('samples'), relief: of('relief'), wanted: terms },
      settings: { population: of('population'), islands: of('islands'), generations: of('generations'), migration },
      seed: of('seed'),
      ...(values['goal']?.trim() ? { goal: number(values['goal'], 0.01) } : {}),
    },
  };
}

/** The form that asks for this; what the form does not know is left out. */
export function wishOf(work: JsonObject): Wish {
  const { aim, settings, seed, goal } = work['evolution'] as { aim: JsonObject; settings: JsonObject; seed: number; goal?: number };
  const { values } = emptyWish();
  const text = (value: Json | undefined, factor = 1) => (typeof value === 'number' ? String(Number((value * factor).toPrecision(12))) : '');
  for (const id of ['scale', 'side', 'samples', 'relief']) values[id] = text(aim[id]);
  for (const id of ['population', 'islands', 'generations']) values[id] = text(settings[id]);
  Object.assign(values, { 'world-seed': text(aim['seed']), seed: text(seed), goal: text(goal, 100) });
  const wanted = (aim['wanted'] as { weight: number; criterion: { [name: string]: { [field: string]: Json } } }[]).map(({ weight, criterion }) => {
    const [name = '', fields = {}] = Object.entries(criterion)[0] ?? [];
    values[`${name}-weight`] = text(weight);
    for (const [field, value] of Object.entries(fields)) if (typeof value === 'number') values[`${name}-${field}`] = text(value, field === 'share' ? 100 : 1);
    if (name === 'likeness') values['likeness-sample'] = JSON.stringify(fields['sample']);
    const at = (field: string, share: number) => text((fields[field] as number[])[Math.round(((fields[field] as number[]).length - 1) * share)]);
    if (name === 'slopes') Object.assign(values, { 'slopes-least': at('degrees', 0), 'slopes-middle': at('degrees', 0.5), 'slopes-greatest': at('degrees', 1) });
    if (name === 'elevations') values['elevations-middle'] = text(Number(at('heights', 0.5)), 100);
    return name;
  });
  return { values, wanted };
}

/** The field that a fault is about: its id; undefined for what no field is about. */
export function fieldOf({ pointer }: Fault, { wanted }: Wish): string | undefined {
  const [, , part = '', ...rest] = pointer.split('/');
  const known = new Set(fieldsOfAll().map(({ id }) => id));
  const first = (...ids: string[]) => ids.find((id) => known.has(id));
  if (part === 'seed' || part === 'goal') return part;
  if (part === 'settings') return first(rest[0] ?? '');
  const [field = '', i, kind, , inner = ''] = rest;
  if (part !== 'aim') return undefined;
  if (field !== 'wanted') return field === 'seed' ? 'world-seed' : first(field);
  const name = wanted[Number(i)];
  if (!name) return undefined;
  return kind === 'weight' ? `${name}-weight` : (first(`${name}-${inner}`) ?? CRITERIA.find((criterion) => criterion.name === name)?.fields[0]?.id);
}
