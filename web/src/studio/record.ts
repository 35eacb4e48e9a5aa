import type { JsonObject } from '../api.ts';

/** A session of breeding as the server keeps it: all its generations follow from it. */
export interface SessionRecord {
  form: 1;
  seed: number;
  budget: { nodes: number; depth: number; cost_ns: number };
  programmes: string[];
  choices: Choice[];
  kept: Kept[];
}

/** One or two of a generation; another `again` breeds other children of the same parents. */
export interface Choice {
  parents: number[];
  again?: number;
}

export interface Kept {
  name: string;
  generation: number;
  individual: number;
  programme: string;
}

export type Origin =
  | 'given'
  | 'grown'
  | { chosen: number }
  | { copied: number }
  | { refused: number }
  | { mutated: { parent: number; mutation: string } }
  | { crossed: { parents: [number, number] } };

export interface Individual {
  programme: string;
  origin: Origin;
  /** Least and greatest value over what the picture shows. */
  values: [number, number];
}

export interface Generation {
  generation: number;
  generations: number;
  /** The seed that a world needs to look as the pictures do. */
  seed: number;
  individuals: Individual[];
}

/** Programmes of a session stay small enough that twelve are shown within a second. */
const BUDGET = { nodes: 160, depth: 24, cost_ns: 1500 };

export const newRecord = (seed: number): SessionRecord => ({ form: 1, seed, budget: BUDGET, programmes: [], choices: [], kept: [] });

/** The next generation of these parents; of a generation that has children already, another one in their place. */
export function bred(record: SessionRecord, generation: number, parents: readonly number[]): SessionRecord {
  const before = record.choices[generation];
  const same = before && before.parents.join() === parents.join();
  const choice: Choice = { parents: [...parents], ...(same ? { again: (before.again ?? 0) + 1 } : {}) };
  return { ...record, choices: [...record.choices.slice(0, generation), choice] };
}

/** The record without its generations after one. */
export const upTo = (record: SessionRecord, generation: number): SessionRecord => ({ ...record, choices: record.choices.slice(0, generation) });

/** The parents of an individual, in the generation before its own. */
export function parentsOf(origin: Origin): number[] {
  if (typeof origin === 'string') return [];
  if ('chosen' in origin) return [origin.chosen];
  if ('copied' in origin) return [origin.copied];
  if ('refused' in origin) return [origin.refused];
  if ('mutated' in origin) return [origin.mutated.parent];
  return origin.crossed.parents;
}

const MUTATIONS: Record<string, string> = { replace: 'a part grown anew', shrink: 'a part cut out', swap: 'two parts exchanged' };

/** How an individual came to be, in words. */
export function told(origin: Origin): string {
  const [a, b] = parentsOf(origin).map((parent) => parent + 1);
  if (origin === 'given') return 'given';
  if (origin === 'grown') return 'grown at random';
  if ('chosen' in origin) return `chosen: ${a} lives on`;
  if ('copied' in origin) return `child of ${a}, the same`;
  if ('refused' in origin) return `${a} again: its children grew too large`;
  if ('mutated' in origin) return `child of ${a}, ${MUTATIONS[origin.mutated.mutation] ?? origin.mutated.mutation}`;
  return `child of ${a} and ${b}`;
}

/** Of every generation up to this one's the individuals that this one comes from, the newest first. */
export function ancestors(generations: readonly Generation[], generation: number, individual: number): { generation: number; individuals: number[] }[] {
  const rows = [{ generation, individuals: [individual] }];
  for (let g = generation; g > 0; g--) {
    const { individuals } = rows.at(-1) ?? { individuals: [] };
    const parents = individuals.flatMap((i) => parentsOf(generations[g]?.individuals[i]?.origin ?? 'grown'));
    if (parents.length === 0) break;
    rows.push({ generation: g - 1, individuals: [...new Set(parents)].sort((a, b) => a - b) });
  }
  return rows;
}

/** Metres a programme unit, and how high a world made of a programme is. */
const [SCALE, RELIEF] = [6000, 2000];

/** The world that looks as an individual's picture. */
export function worldOf({ programme, values: [low, high] }: Individual, seed: number, title: string): JsonObject {
  const amplitude = high > low ? RELIEF / (high - low) : RELIEF;
  const fits = Math.abs(amplitude) <= 1e6 && Math.abs(low * amplitude) <= 1e6;
  const [factor, datum] = fits ? [Number(amplitude.toPrecision(6)), Number((-low * amplitude).toPrecision(6))] : [RELIEF, 0];
  return { title, seed, base: { programme, scale: SCALE, amplitude: factor, datum } };
}
