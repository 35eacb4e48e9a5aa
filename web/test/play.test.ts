import assert from 'node:assert/strict';
import { test } from 'node:test';
import { adaptiveLayers } from '../src/adaptive.ts';
import { EventParser } from '../src/events.ts';
import { Block, LAYER, TEXELS, fill } from '../src/play/block.ts';
import { CELLS, COARSEST, VERTICES, blockAt, distanceTo, heightIn, meets, parentOf, sideOf } from '../src/play/grid.ts';
import { Pace } from '../src/play/pace.ts';
import { meet } from '../src/play/ray.ts';
import { landStops } from '../src/play/relief.ts';
import { Terrain } from '../src/play/terrain.ts';
import { EYES, Walker } from '../src/play/walker.ts';

const still = { forward: 0, right: 0, up: 0, fast: false };
const slope = (rise: number) => ({ at: ({ east }: { east: number }) => rise * east });

test('blocks lie where the metric grid has them', () => {
  assert.equal(sideOf(17), 256);
  assert.deepEqual(blockAt({ east: -1, south: 300 }, 17), { z: 17, x: -1, y: 1 });
  assert.deepEqual(parentOf({ z: 17, x: -1, y: 1 }), { z: 16, x: -1, y: 0 });
  assert.equal(distanceTo({ z: 17, x: 0, y: 0 }, { east: 259, south: -4 }), 5);
  assert.equal(distanceTo({ z: 17, x: 0, y: 0 }, { east: 10, south: 10 }), 0);
  // Row 0 lies south of the plane's y = 0.
  assert.ok(meets({ z: 17, x: 0, y: 0 }, [10, -20, 20, -10]));
  assert.ok(!meets({ z: 17, x: 0, y: 0 }, [10, 100, 20, 120]));
});

test('heights between vertices lie on the triangles', () => {
  const heights = new Float32Array(VERTICES * VERTICES).map((_, i) => 3 * (i % VERTICES) - 2 * Math.floor(i / VERTICES));
  assert.equal(heightIn(heights, 10.25, 7.5), 3 * 10.25 - 15);
  assert.equal(heightIn(heights, 64, 64), 64);
  assert.equal(heightIn(heights, 65, -1), 3 * 65 + 2, 'beyond the edges it goes on');
  heights[0] = 100; // one corner alone
  assert.equal(heightIn(heights, 0.75, 0.75), 3 * 0.75 - 1.5, 'the other triangle does not see it');
});

test('a layer holds what a block and its parent show, and its neighbour beyond the edge', () => {
  const plane = (x: number, y: number, z: number) => {
    const spacing = sideOf(z) / CELLS;
    return new Float32Array(VERTICES * VERTICES).map((_, i) => (x * CELLS + (i % VERTICES)) * spacing + 2 * (y * CELLS + Math.floor(i / VERTICES)) * spacing);
  };
  const parent = new Block({ z: 16, x: 1, y: 1 }, plane(1, 1, 16), '', 0, undefined);
  const block = new Block({ z: 17, x: 3, y: 2 }, plane(3, 2, 17), '', 1, parent);
  const east = new Block({ z: 17, x: 4, y: 2 }, plane(4, 2, 17).map((height) => height + 1000), '', 2, undefined);
  const layer = new Float32Array(LAYER);
  fill(layer, block, 'now', ({ x, y }) => (x === 4 && y === 2 ? east : undefined));
  const at = (column: number, row: number) => [...layer.subarray(4 * ((row + 1) * TEXELS + column + 1), 4 * ((row + 1) * TEXELS + column + 1) + 4)];
  const exact = (column: number, row: number) => (3 * CELLS + column) * 4 + 2 * (2 * CELLS + row) * 4;
  assert.deepEqual(at(5, 9), [0, 0, exact(5, 9), exact(5, 9)]);
  assert.equal(at(-1, 9)[2], exact(-1, 9), 'nothing there: it goes on');
  assert.equal(at(65, 9)[2], exact(65, 9) + 1000, 'the neighbour');
});

test('who walks stays on the ground, slower uphill, and falls where it ends', () => {
  const ways = [0, 0.5, 3].map((rise) => {
    const walker = new Walker();
    walker.turn(Math.PI / 2, 0);
    walker.eye = EYES;
    for (let i = 0; i < 100; i++) {
      walker.step({ ...still, forward: 1 }, 0.02, slope(rise));
      assert.ok(Math.abs(walker.eye - EYES - rise * walker.place.east) < 1e-9);
    }
    return walker.place.east;
  });
  const [level, uphill, wall] = ways as [number, number, number];
  assert.ok(level > 10 && uphill < 0.7 * level && uphill > 0 && wall === 0, String(ways));

  const high = new Walker();
  high.eye = 100;
  const heights = Array.from({ length: 400 }, () => (high.step(still, 0.02, slope(0)), high.eye));
  assert.ok(heights.every((height, i) => height <= (heights[i - 1] ?? 100)) && heights.at(-1) === EYES);
  assert.ok((heights[9] ?? 0) > 99, 'not at once');

  const nowhere = new Walker();
  nowhere.step({ ...still, forward: 1 }, 1, { at: () => undefined });
  assert.deepEqual(nowhere.place, { east: 0, south: 0 });
});

test('who flies goes where the eyes look, and not into the ground', () => {
  const walker = new Walker();
  walker.fly(true);
  walker.turn(0, -1);
  for (let i = 0; i < 200; i++) walker.step({ ...still, forward: 1 }, 0.02, slope(0));
  assert.ok(walker.place.south < -20 && Math.abs(walker.place.east) < 1e-9 && walker.eye === 2);
  walker.fly(false);
  for (let i = 0; i < 100; i++) walker.step(still, 0.02, slope(0));
  assert.equal(walker.eye, EYES);
});

test('a look meets the ground where it is', () => {
  const down = Math.SQRT1_2;
  const found = meet({ east: 5, south: 7 }, 100, { east: down, south: 0, up: -down }, () => 0);
  assert.ok(found && Math.abs(found.east - 105) < 0.01 && found.south === 7);
  assert.equal(meet({ east: 0, south: 0 }, 10, { east: 0, south: 0, up: 1 }, () => 0), undefined);
});

test('events come whole whatever pieces they come in', () => {
  const text = ': hello\r\n\r\nevent: generation\nid: a-1\ndata: {"world":\ndata: "w"}\n\nretry: 5\n\ndata:x\r\n\r\n';
  const expected = [
    { event: 'generation', data: '{"world":\n"w"}', id: 'a-1' },
    { event: 'message', data: 'x', id: 'a-1' },
  ];
  for (const size of [1, 2, 3, 7, text.length]) {
    const parser = new EventParser();
    const heard = [];
    for (let i = 0; i < text.length; i += size) heard.push(...parser.push(text.slice(i, i + size)));
    assert.deepEqual(heard, expected, `pieces of ${size}`);
  }
});

test('the land has the colours of the relief', () => {
  const stops = landStops(0, [-500, 3000]);
  assert.deepEqual([stops[0]?.elevation, stops.at(-1)?.elevation], [0, 2600]);
  assert.ok((stops.at(-1)?.colour[0] ?? 0) > (stops[0]?.colour[0] ?? 1));
  const low = landStops(0, [-50, 200]);
  assert.ok(low.every(({ colour: [red, green, blue] }) => [red, green, blue].every(Number.isFinite) && green > blue), 'low hills wear no snow');
});

test('slow pictures cost pixels, quick ones get them back', () => {
  const pace = new Pace(2);
  for (let i = 0; i < 400; i++) pace.tell(60);
  assert.ok(pace.pixels < 0.6 && pace.refinement < 1.5, `${pace.pixels} ${pace.refinement}`);
  for (let i = 0; i < 4000; i++) pace.tell(16);
  assert.ok(pace.pixels === 1 && pace.refinement === 2);
});

test('a document tells its ground that adapts', () => {
  const ground = { origin: [10, 20], cell: 2, populations: 2, lines: 5, length: 9, passes: 1, promise: 30 };
  const layers = [{ name: 'rivers', source: {} }, { name: 'living', source: { adaptive: { ground } } }];
  assert.deepEqual(adaptiveLayers({ layers }), [{ name: 'living', extent: [10, 20, 46, 52], promise: 30 }]);
  assert.deepEqual(adaptiveLayers({}), []);
});

/** A server whose ground is as high as its revision says, but for the blocks that do not change. */
function served(changes: (z: number, x: number) => boolean): { asked: string[] } {
  const asked: string[] = [];
  const storage = { getItem: () => null };
  Object.assign(globalThis, {
    sessionStorage: storage,
    fetch: async (url: string, { headers }: { headers: Record<string, string> }) => {
      const [, revision, z, x] = /@(\d+)\/metric\/r32\/(\d+)\/(-?\d+)/.exec(url) ?? [];
      const height = changes(Number(z), Number(x)) ? Number(revision) : 1;
      asked.push(`${url} ${headers['If-None-Match'] ?? ''}`);
      if (headers['If-None-Match'] === `"${height}"`) return new Response(null, { status: 304 });
      return new Response(new Float32Array(VERTICES * VERTICES).fill(height), { headers: { ETag: `"${height}"` } });
    },
  });
  return { asked };
}

const here = { east: 100, south: 100 };

async function frames(terrain: Terrain, until: () => boolean, seen = () => {}): Promise<void> {
  for (let i = 0; i < 5000; i++) {
    terrain.update(here, 2, 1 / 60, () => true);
    seen();
    if (until()) return;
    await new Promise((resolve) => setImmediate(resolve));
  }
  assert.fail(`still ${terrain.phase}`);
}

test('the ground moves from one revision to the next at once, everywhere', async () => {
  const { asked } = served(() => true);
  const arrived: string[] = [];
  const terrain = new Terrain('w', '1', 320, { filled: () => {}, arrived: (revision) => arrived.push(revision), failed: assert.fail }, false);
  await frames(terrain, () => terrain.still);
  assert.equal(terrain.spacing(here), 0.5);
  assert.equal(terrain.height(here), 1);
  const before = asked.length;

  terrain.renew('2', undefined);
  terrain.renew('3', undefined); // overtaken
  const heights = new Set<number>();
  const places = [here, { east: 5000, south: -3000 }, { east: -20000, south: 100 }];
  await frames(terrain, () => terrain.still, () => {
    const seen = places.map((place) => terrain.height(place));
    assert.equal(new Set(seen).size, 1, `one revision: ${seen}`);
    heights.add(seen[0] ?? NaN);
  });
  assert.deepEqual(arrived, ['3']);
  assert.equal(terrain.height(here), 3);
  assert.ok(heights.size > 20 && Math.min(...heights) === 1 && Math.max(...heights) === 3, 'slowly');
  assert.ok(asked.slice(before).every((question) => question.endsWith('"1"')), 'only what changed is sent');

  // What the graphics card was given is the new ground in all four channels.
  const block = terrain.data.subarray(0, LAYER);
  assert.ok(block.every((height) => height === 3));
});

test('only what meets the change is asked for', async () => {
  const { asked } = served((z, x) => z > COARSEST && x >= 0);
  const terrain = new Terrain('w', '1', 320, { filled: () => {}, arrived: () => {}, failed: assert.fail }, true);
  await frames(terrain, () => terrain.still);
  const before = asked.length;
  terrain.renew('2', [3000, -100, 3100, 100]);
  await frames(terrain, () => terrain.still);
  const again = asked.length - before;
  assert.ok(again > 5 && again < 40, `${again} of ${before}`);
  assert.equal(terrain.revision, '2');
  assert.equal(terrain.height({ east: 3050, south: 0 }), 2);
  assert.equal(terrain.height(here), 1);
  terrain.renew('4', null);
  await frames(terrain, () => terrain.revision === '4');
  assert.equal(asked.length, before + again, 'nothing changed, nothing is asked');
});

test('where there are few layers the ground is coarser, and nothing is asked for twice', async () => {
  const { asked } = served(() => false);
  const terrain = new Terrain('w', '1', 48, { filled: () => {}, arrived: () => {}, failed: assert.fail }, true);
  await frames(terrain, () => terrain.still);
  assert.ok(terrain.blocks <= 48 && (terrain.spacing(here) ?? 0) > 0.5);
  assert.equal(new Set(asked).size, asked.length);
});
