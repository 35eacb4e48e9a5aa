import assert from 'node:assert/strict';
import { test } from 'node:test';
import { FIELDS, fieldFor, toDocument, toValues } from '../src/fields.ts';
import { EXAGGERATION, formatLink, parseLink } from '../src/link.ts';
import { lineAndColumn, slug, utf16Offset } from '../src/text.ts';

const DOCUMENT = {
  title: 'Alps',
  seed: 9007199254740991,
  generator: 1,
  elevation: { min: -500, max: 4500 },
  sea_level: 0,
  base: { programme: 'fbm(1.0, 2.0, 8)', scale: 20000, origin: [0, 0], amplitude: 1500, datum: 300 },
  layers: [],
  later: { unknown: 'to this viewer' },
};

test('a link restores world, place and view', () => {
  const link = {
    world: 'alps',
    camera: { lon: 12.345678, lat: -45.678901, zoom: 14.25, bearing: -30.5, pitch: 62 },
    tilted: true,
    exaggeration: 2,
    overlays: ['contours' as const],
  };
  const text = formatLink(link);
  assert.equal(text, '#world=alps&at=12.345678,-45.678901&zoom=14.25&bearing=-30.5&pitch=62&view=3d&height=2&show=contours');
  assert.deepEqual(parseLink(text), link);
});

test('a link is as precise as a tenth of a pixel', () => {
  for (const zoom of [0, 9, 16, 24]) {
    const camera = { lon: 1 / 3, lat: 2 / 3, zoom, bearing: 0, pitch: 0 };
    const read = parseLink(formatLink({ world: 'w', camera, tilted: false, exaggeration: 1 })).camera;
    const pixel = 360 / (512 * 2 ** zoom);
    assert.ok(Math.abs((read?.lon ?? 9) - camera.lon) <= pixel / 10, `zoom ${zoom}`);
  }
});

test('a mangled link still opens something', () => {
  const plain = { tilted: false, exaggeration: EXAGGERATION.default, overlays: [] };
  assert.deepEqual(parseLink(''), plain);
  assert.deepEqual(parseLink('#map'), plain);
  assert.deepEqual(parseLink('#show=roads,features'), { ...plain, overlays: ['features'] });
  assert.deepEqual(parseLink('#world=../etc&at=1&zoom=x&height=99'), { ...plain, exaggeration: EXAGGERATION.max });
  assert.deepEqual(parseLink('#at=999,-999&zoom=99&pitch=45').camera, {
    lon: 180, lat: -85.051129, zoom: 24, bearing: 0, pitch: 0,
  });
});

test('offsets in scalar values become offsets in UTF-16', () => {
  assert.equal(utf16Offset('fmb(x)', 3), 3);
  assert.equal(utf16Offset('\u{1F3D4}fmb', 1), 2);
  assert.equal(utf16Offset('\u{1F3D4}fmb', 99), 5);
});

test('places are counted in lines and columns from 1', () => {
  assert.deepEqual(lineAndColumn('plus(x,\n  fmb)', 10), { line: 2, column: 3 });
  assert.deepEqual(lineAndColumn('x', 0), { line: 1, column: 1 });
});

test('a title becomes a name', () => {
  assert.equal(slug(' Zürich Alps, 2nd '), 'zurich-alps-2nd');
  assert.match(slug(`${'a'.repeat(62)} b`), /^[a-z0-9][a-z0-9-]{0,62}$/);
});

test('a form that nobody touched gives the same document', () => {
  const { document, faults } = toDocument(toValues(DOCUMENT), DOCUMENT);
  assert.deepEqual(document, DOCUMENT);
  assert.equal(faults.size, 0);
});

test('blank optional fields are left to the server, and blank texts go away', () => {
  const { document } = toDocument({ ...toValues(DOCUMENT), '/title': '', '/base/datum': ' ' }, DOCUMENT);
  assert.ok(!('title' in document));
  assert.ok(!('datum' in (document['base'] as object)));
});

test('numbers that are none are reported at their field', () => {
  const values = { ...toValues(DOCUMENT), '/seed': '1.5', '/base/scale': 'wide', '/base/origin/0': '', '/layers': '[' };
  assert.deepEqual([...toDocument(values, DOCUMENT).faults.keys()].sort(), ['/base/origin/0', '/base/scale', '/layers', '/seed']);
});

test('a programme that is a tree is shown as JSON text and sent back as a tree', () => {
  const tree = { op: 'fbm', args: [1, 2, 8] };
  const document = { seed: 1, base: { programme: tree, scale: 1 } };
  const values = toValues(document);
  assert.deepEqual(JSON.parse(values['/base/programme'] ?? ''), tree);
  assert.deepEqual(toDocument(values, document).document, document);
  assert.ok(toDocument({ ...values, '/base/programme': '{"op":' }, document).faults.has('/base/programme'));
});

test('every error finds the field it belongs to', () => {
  const label = (pointer: string) => fieldFor(pointer)?.label;
  assert.deepEqual(
    ['/base/programme', '/base/programme/args/1', '/elevation', '/layers/0/blend', '/base/scale'].map(label),
    ['Programme', 'Programme', 'Lowest', 'Layers', 'Scale'],
  );
  assert.equal(label(''), undefined);
  assert.equal(label('/nowhere'), undefined);
  assert.equal(new Set(FIELDS.map(({ pointer }) => pointer)).size, FIELDS.length);
});
