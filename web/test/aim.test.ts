import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { JsonObject } from '../src/api.ts';
import { emptyWish, fieldOf, wishOf, workOf } from '../src/studio/aim.ts';
import { place, ticks } from '../src/studio/fitness.ts';

const aim = (work: JsonObject) => (work['evolution'] as JsonObject)['aim'] as JsonObject;

test('a form becomes a job and a job a form', () => {
  const wish = emptyWish();
  wish.wanted = ['accessibility', 'slopes', 'elevations', 'likeness'];
  wish.values['accessibility-share'] = '29';
  wish.values['goal'] = '99.5';
  wish.values['likeness-sample'] = '{"slopes":[0,9],"heights":[0,1],"relief":5,"roughness":0.25}';
  const work = workOf(wish);
  assert.deepEqual((aim(work)['wanted'] as JsonObject[])[0], { weight: 3, criterion: { accessibility: { slope: 15, share: 0.29 } } });
  assert.equal((work['evolution'] as JsonObject)['goal'], 0.995);
  assert.deepEqual(wishOf(work), wish);
  assert.equal('goal' in (workOf(emptyWish())['evolution'] as JsonObject), false, 'without a goal all generations are bred');
});

test('what is no number is left to the server, which says where it stands', () => {
  const wish = emptyWish();
  wish.values['relief'] = '';
  wish.values['side'] = 'wide';
  assert.deepEqual([aim(workOf(wish))['relief'], aim(workOf(wish))['side']], [null, 'wide']);
  const at = (pointer: string) => fieldOf({ pointer, detail: '' }, wish);
  assert.equal(at('/evolution/aim/side'), 'side');
  assert.equal(at('/evolution/aim/seed'), 'world-seed');
  assert.equal(at('/evolution/seed'), 'seed');
  assert.equal(at('/evolution/settings/population'), 'population');
  assert.equal(at('/evolution/aim/wanted/1/criterion/edges/density'), 'edges-density');
  assert.equal(at('/evolution/aim/wanted/0/weight'), 'accessibility-weight');
  assert.equal(at('/evolution/aim/wanted/9/weight'), undefined);
  assert.equal(at('/evolution/settings/elite'), undefined);
  wish.wanted = ['slopes', 'likeness'];
  assert.equal(at('/evolution/aim/wanted/0/criterion/slopes/degrees'), 'slopes-least');
  assert.equal(at('/evolution/aim/wanted/1/criterion/likeness/sample/slopes'), 'likeness-sample');
});

test('the curve runs from the first generation to the last', () => {
  assert.deepEqual(place(0, 1, 40), [44, 10]);
  assert.deepEqual(place(40, 0, 40), [468, 186]);
  assert.deepEqual(ticks(40, 6), [0, 10, 20, 30, 40]);
  assert.deepEqual(ticks(0, 6), [0]);
});
