import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ancestors, bred, newRecord, parentsOf, told, upTo, worldOf, type Generation, type Origin } from '../src/studio/record.ts';

test('breeding adds a choice, and the same choice again asks for other children', () => {
  let record = bred(bred(newRecord(7), 0, [3]), 1, [0, 5]);
  assert.deepEqual(record.choices, [{ parents: [3] }, { parents: [0, 5] }]);
  record = bred(record, 1, [0, 5]);
  record = bred(record, 1, [0, 5]);
  assert.deepEqual(record.choices, [{ parents: [3] }, { parents: [0, 5], again: 2 }]);
  assert.deepEqual(bred(record, 0, [4]).choices, [{ parents: [4] }], 'another way gives up what came after');
  assert.deepEqual(upTo(record, 1).choices, [{ parents: [3] }]);
});

test('every origin is told and has its parents', () => {
  const origins: [Origin, number[], string][] = [
    ['given', [], 'given'],
    ['grown', [], 'grown at random'],
    [{ chosen: 2 }, [2], 'chosen: 3 lives on'],
    [{ copied: 0 }, [0], 'child of 1, the same'],
    [{ refused: 4 }, [4], '5 again: its children grew too large'],
    [{ mutated: { parent: 1, mutation: 'shrink' } }, [1], 'child of 2, a part cut out'],
    [{ crossed: { parents: [0, 11] } }, [0, 11], 'child of 1 and 12'],
  ];
  for (const [origin, parents, words] of origins) {
    assert.deepEqual(parentsOf(origin), parents);
    assert.equal(told(origin), words);
  }
});

test('a family goes back to what was grown', () => {
  const generation = (generation: number, origins: Origin[]): Generation => ({
    generation, generations: 3, seed: 1, individuals: origins.map((origin) => ({ programme: 'x', origin, values: [0, 1] })),
  });
  const generations = [
    generation(0, ['grown', 'grown', 'grown']),
    generation(1, [{ chosen: 2 }, { crossed: { parents: [0, 2] } }]),
    generation(2, [{ crossed: { parents: [0, 1] } }]),
  ];
  assert.deepEqual(ancestors(generations, 2, 0), [
    { generation: 2, individuals: [0] }, { generation: 1, individuals: [0, 1] }, { generation: 0, individuals: [0, 2] },
  ]);
});

test('a world is as high as it is wide, whatever the values', () => {
  const of = (values: [number, number]) => worldOf({ programme: 'x', origin: 'grown', values }, 5, 't')['base'] as { amplitude: number; datum: number };
  for (const values of [[0, 1], [-3, 2], [100, 100.5], [-1e-3, 1e-3]] as [number, number][]) {
    const { amplitude, datum } = of(values);
    assert.ok(Math.abs(datum + amplitude * values[0]) < 1 && Math.abs(datum + amplitude * values[1] - 2000) < 1, values.join());
  }
  for (const values of [[5, 5], [0, 1e-9], [1e6, 1e6 + 1]] as [number, number][]) {
    const { amplitude, datum } = of(values);
    assert.ok(Math.abs(amplitude) <= 1e6 && Math.abs(datum) <= 1e6, 'within what worlds may have');
  }
});
