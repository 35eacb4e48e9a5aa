import { request, send } from './api.ts';
import { authorization } from './key.ts';
import type { JsonObject } from './api.ts';

/** Ground that evolves while it is used: feedback, generations and players of a world (docs/evolving.md). */

/** A rectangle of the plane: least x and y, greatest x and y. */
export type Extent = [west: number, south: number, east: number, north: number];

/** One adaptive layer of a world, as its document says it. */
export interface AdaptiveLayer {
  name: string;
  extent: Extent;
  promise: number;
}

export interface Fed {
  layer: string;
  generation: { hash: string; number: number };
  revision: string;
  changed: Extent | null;
  deviation: number;
}

export interface GenerationEntry {
  number: number;
  hash: string;
  time?: string;
}

export interface Generations {
  layer: string;
  current: string;
  generations: GenerationEntry[];
}

export interface Player {
  name: string;
  position: [number, number];
}

/** What a feedback says: places of the ground, or the places of all players. */
export interface Feedback {
  layer: string;
  points?: [number, number][];
  radius?: number;
  players?: true;
}

/** Of `Ground`, as far as its extent goes; what is left out has the server's defaults. */
interface Ground {
  origin?: [number, number];
  cell?: number;
  populations?: number;
  lines?: number;
  length?: number;
  passes?: number;
  promise?: number;
}

function extentOf({ origin = [0, 0], cell = 10, populations = 1, lines = 33, length = 33, passes = 2 }: Ground): Extent {
  const metres = (nodes: number) => (nodes - 1) * 2 ** passes * cell;
  return [origin[0], origin[1], origin[0] + metres(populations * lines), origin[1] + metres(length)];
}

/** The layers of a world's document that adapt. */
export function adaptiveLayers(document: JsonObject): AdaptiveLayer[] {
  const layers = (document['layers'] ?? []) as { name?: string; source?: { adaptive?: { ground?: Ground } } }[];
  return layers.flatMap(({ name, source }) => {
    const ground = source?.adaptive?.ground;
    return ground ? [{ name: name ?? '', extent: extentOf(ground), promise: ground.promise ?? 50 }] : [];
  });
}

export const within = ([west, south, east, north]: Extent, [x, y]: readonly [number, number]): boolean =>
  x >= west && x <= east && y >= south && y <= north;

export async function feed(world: string, feedback: Feedback): Promise<Fed> {
  return (await (await request(`worlds/${world}/feedback`, send('POST', feedback as unknown as JsonObject))).json()) as Fed;
}

export async function readGenerations(world: string, layer: string): Promise<Generations> {
  const path = `worlds/${world}/generations?layer=${encodeURIComponent(layer)}`;
  return (await (await request(path, { cache: 'no-cache' })).json()) as Generations;
}

export async function goTo(world: string, layer: string, generation: string): Promise<void> {
  await request(`worlds/${world}/generation`, send('PUT', { layer, generation }));
}

/** The way of a player since the last time; answers how far the ground around it is promised to stay. */
export async function tellWay(world: string, player: string, positions: readonly (readonly [number, number])[]): Promise<number> {
  const response = await request(`worlds/${world}/players/${player}`, send('PUT', { positions } as unknown as JsonObject));
  return ((await response.json()) as { promise: number }).promise;
}

/** Also while the page is being left. */
export async function leave(world: string, player: string): Promise<void> {
  await fetch(`worlds/${world}/players/${player}`, { method: 'DELETE', headers: authorization(), keepalive: true }).catch(() => undefined);
}

export async function readPlayers(world: string): Promise<Player[]> {
  return ((await (await request(`worlds/${world}/players`, { cache: 'no-cache' })).json()) as { players: Player[] }).players;
}
