import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Lru } from '../src/lru.ts';
import { HALF, TILE_SIZE, address, around, spacing, toLonLat, toMetres } from '../src/mercator.ts';
import { roundDown } from '../src/scale.ts';
import { bilinear, decode, decodePixels } from '../src/terrarium.ts';

const near = (actual: number, expected: number, tolerance: number) =>
  assert.ok(Math.abs(actual - expected) <= tolerance, `${actual} is not ${expected} ± ${tolerance}`);

test('the spacing is that of the web grid at 512 samples a tile', () => {
  assert.equal(spacing(0), 78271.51696402048);
  near(spacing(24) * 2 ** 24, 78271.51696402048, 1e-9);
});

test('longitude and latitude become Web Mercator metres and come back', () => {
  near(toMetres({ lon: 180, lat: 0 }).x, 20037508.342789244, 1e-6);
  near(toMetres({ lon: 0, lat: 45 }).y, 5621521.486192066, 1e-6);
  for (const [lon, lat] of [[0.3, 0.2], [-179.9, -85], [12.3456789, 66.6]] as const) {
    const back = toLonLat(toMetres({ lon, lat }));
    near(back.lon, lon, 1e-12);
    near(back.lat, lat, 1e-12);
  }
});

test('a sample lies at the centre of its pixel', () => {
  const z = 9;
  // the first sample of tile 9/256/255, whose south-west corner is the origin
  const centre = { x: 0.5 * spacing(z), y: (TILE_SIZE - 0.5) * spacing(z) };
  const { corner, east, south } = around(centre, z);
  near(corner.column + east, 256 * TILE_SIZE, 1e-6);
  near(corner.row + south, 255 * TILE_SIZE, 1e-6);
});

test('the four samples around a point at a tile edge come from both tiles', () => {
  const { corner, east } = around({ x: 0, y: 1000 }, 9);
  near(east, 0.5, 1e-6);
  assert.deepEqual(
    [address(corner).x, address({ ...corner, column: corner.column + 1 }).x],
    [255, 256],
  );
  assert.equal(address(corner).index % TILE_SIZE, TILE_SIZE - 1);
  assert.equal(address({ ...corner, column: corner.column + 1 }).index % TILE_SIZE, 0);
});

test('samples beyond the grid are in tiles with negative indices', () => {
  const { corner } = around({ x: -HALF, y: HALF }, 3);
  assert.deepEqual(address(corner), { x: -1, y: -1, index: TILE_SIZE * TILE_SIZE - 1 });
});

test('terrarium decodes sea level, heights, depths and the smallest step', () => {
  assert.equal(decode(128, 0, 0), 0);
  assert.equal(decode(128, 0, 1), 1 / 256);
  assert.equal(decode(127, 255, 255), -1 / 256);
  assert.equal(decode(162, 144, 128), 8848.5);
  assert.deepEqual([...decodePixels([128, 1, 0, 255, 127, 255, 0, 255])], [1, -1]);
});

test('bilinear interpolation gives the corners, the middle and whatever a plane gives', () => {
  const four = [1, 3, 5, 7] as const;
  assert.deepEqual([bilinear(four, 0, 0), bilinear(four, 1, 0), bilinear(four, 0, 1), bilinear(four, 1, 1)], [1, 3, 5, 7]);
  assert.equal(bilinear(four, 0.5, 0.5), 4);
  assert.equal(bilinear(four, 0.25, 0.75), 1 + 2 * 0.25 + 4 * 0.75);
});

test('the cache forgets what was used least recently', () => {
  const cache = new Lru<number>(2);
  cache.set('a', 1);
  cache.set('b', 2);
  assert.equal(cache.get('a'), 1);
  cache.set('c', 3);
  assert.deepEqual([cache.get('a'), cache.get('b'), cache.get('c')], [1, undefined, 3]);
});

test('the scale bar shows 1, 2 or 5 times a power of ten', () => {
  assert.deepEqual([9, 5, 4.9, 2, 1.9, 123, 0.07].map(roundDown), [5, 5, 2, 2, 1, 100, 0.05]);
});
