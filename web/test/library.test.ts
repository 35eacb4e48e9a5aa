import assert from 'node:assert/strict';
import { test } from 'node:test';
import { toValues } from '../src/fields.ts';
import { inWorld, isFound, readTags, tagsOf, toProgramme, withProgramme } from '../src/library.ts';

const WORLD = {
  title: 'Alps',
  seed: 7,
  elevation: { min: -500, max: 4500 },
  sea_level: 12,
  base: { programme: 'fbm(1, 2, 8)', scale: 16000, origin: [5, 6], amplitude: 2300, datum: -150 },
  layers: [],
};

const PROGRAMME = {
  programme: 'fbm(1, 2, 8)',
  scale: 16000,
  amplitude: 2300,
  datum: -150,
  sea_level: 12,
  elevation: { min: -500, max: 4500 },
  seed: 7,
};

const entry = (name: string, tags: string[], title = name) => ({ name, title, tags, origin: 'shipped', revision: '0' });

test('the programme of a world takes its measures along', () => {
  assert.deepEqual(toProgramme(WORLD), PROGRAMME);
  assert.deepEqual(toProgramme({ seed: 1, base: { programme: 'x' } }), { programme: 'x', seed: 1 });
});

test('a chosen programme changes the ground and leaves the rest of the form', () => {
  const before = toValues({ title: 'Mine', seed: 99, base: { programme: 'x', scale: 1, origin: [3, 4] } });
  const after = withProgramme(before, { ...PROGRAMME, title: 'Other', tags: ['a'], origin: 'shipped' });
  assert.deepEqual(
    Object.keys(after).filter((pointer) => after[pointer] !== before[pointer]),
    ['/base/programme', '/base/scale', '/base/amplitude', '/base/datum', '/sea_level', '/elevation/min', '/elevation/max'],
  );
  assert.deepEqual([after['/base/programme'], after['/base/datum'], after['/elevation/min']], ['fbm(1, 2, 8)', '-150', '-500']);
  const tree = { op: 'sin', args: ['x'] };
  assert.deepEqual(JSON.parse(withProgramme(before, { programme: tree })['/base/programme'] ?? ''), tree);
});

test('faults of a library programme find their place in the world', () => {
  const moved = (pointer: string) => inWorld({ pointer, detail: '' }).pointer;
  assert.deepEqual(
    ['/programme', '/programme/args/0', '/scale', '/sea_level', '/elevation/min', '/tags/0', ''].map(moved),
    ['/base/programme', '/base/programme/args/0', '/base/scale', '/sea_level', '/elevation/min', '/tags/0', ''],
  );
});

test('tags are read as people type them', () => {
  assert.deepEqual(readTags(' Mountains, alpine  alpine;#snow '), ['mountains', 'alpine', 'snow']);
  assert.deepEqual(readTags(' , '), []);
});

test('the most used tags come first', () => {
  const all = [entry('a', ['wet', 'high']), entry('b', ['dry', 'high']), entry('c', ['high', 'dry'])];
  assert.deepEqual(tagsOf(all), ['high', 'dry', 'wet']);
});

test('programmes are found by every tag and every word', () => {
  const dunes = entry('dunes', ['desert', 'sand'], 'Long Dunes');
  const found = (tags: string[], text: string) => isFound(dunes, new Set(tags), text);
  assert.deepEqual([found([], ''), found(['desert', 'sand'], ' LONG  sand '), found(['des'], ''), found([], 'dunes snow')], [true, true, false, false]);
});
