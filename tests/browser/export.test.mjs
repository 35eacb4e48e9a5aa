// Exported shaders compute the server's heights: WebGL 2 and WebGPU, both on SwiftShader, against exact r32 tiles.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { startBrowser } from './browser.mjs';
import { runWebGl, runWebGpu } from './gpu.mjs';
import { startServer } from './server.mjs';

const WEBGPU = ['--enable-unsafe-webgpu', '--use-webgpu-adapter=swiftshader', '--enable-features=Vulkan'];
/** Vertices a side of the tiles that are compared, and metres between them: level 13 of the metric grid. */
const SIDE = 33;
const SPACING = 128;
/** Metres a programme unit: no power of two, so that no sample lies on a lattice. */
const SCALE = 531.7;
const ORIGIN = [2040.3, -2051.9];
/** Tiles around the programme's origin, and 1.5 million programme units away. */
const NEAR = { x: 0, y: 0 };
const FAR = { x: 200_000, y: -150_000 };
/** How far off a jump may lie, in programme units: f32 has 24 bits for a fraction of a cell, and values that decide are rounded. */
const MARGIN = 1e-6;
/** The same for derivatives by differences, which a server without analytic ones takes over 2e-4 units. */
const DIFFERENCE = 2e-4;
/** Most points that may lie within the margin of a jump. */
const MOST_JUMPS = 0.02;

let server;
let browser;
let page;
/** Whether the server has the formulas of all fractals and analytic derivatives of noises. */
let complete;

before(async () => {
  server = await startServer();
  browser = await startBrowser(server.url, WEBGPU);
  // A page that is no document of ours has no icon.
  page = await browser.open('openapi.json', {}, ['404 (Not Found)', '/favicon.ico']);
  complete = await hasFormulas();
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

async function put(name, programme, more = {}) {
  const document = {
    seed: 77, elevation: { min: -10000, max: 32767 },
    base: { programme, scale: SCALE, origin: ORIGIN, amplitude: 1, ...more },
  };
  const response = await fetch(`${server.url}/worlds/${name}`, { method: 'PUT', body: JSON.stringify(document) });
  assert.ok(response.ok, `${programme}: ${await response.text()}`);
}

const text = async (path) => {
  const response = await fetch(`${server.url}/${path}`);
  assert.equal(response.status, 200, path);
  return response.text();
};

const at = async (name, x, y) => (await server.get(`worlds/${name}/elevation?x=${x}&y=${y}`)).elevation;

/** Elevations of a tile's vertices as the function is, row by row from the north. */
async function heights(name, { x, y }) {
  const response = await fetch(`${server.url}/worlds/${name}/metric/r32/13/${x}/${y}@${SIDE}.bin?filter=exact`);
  assert.equal(response.status, 200);
  return new Float32Array(await response.arrayBuffer());
}

/** Plane metres of a tile's vertex; its column and row count from the north-west. */
const metres = ({ x, y }, index) => {
  const side = SPACING * (SIDE - 1);
  return [x * side + (index % SIDE) * SPACING, -y * side - Math.floor(index / SIDE) * SPACING];
};

/** With one octave, a multifractal is 1 + n; a server that has its name alone answers n. */
async function hasFormulas() {
  await put('formula', 'minus(multifractal(1, 2, 1, seed=3), o_perlin(seed=3))');
  return (await at('formula', 100, 100)) > 0.5;
}

const lines = readFileSync(new URL('programmes.txt', import.meta.url), 'utf8').split('\n').filter((line) => line && !line.startsWith('#'));
const cases = lines.map((line) => {
  const [, later, tolerance, programmes] = /^(later )?(\S+): (.*)$/.exec(line);
  const [programme, like = programme] = programmes.split(' == ');
  const derivative = /gradient|slope/.test(programme);
  // Plain coordinates are exempt far out, where one f32 cannot hold them.
  const far = !/\b(x|y|plane)\b/.test(programme);
  return { programme, like, later: later !== undefined, derivative, far, tolerance: Number(tolerance) };
});

/**
 * The worst difference in parts of the range, and how many points lie too near to a jump to be compared: where the
 * server's own heights within d metres differ by more than the tolerance, and the shader's is among them.
 */
async function compare(name, place, got, want, tolerance, d) {
  const range = Math.max(...want) - Math.min(...want);
  const allowed = tolerance * Math.max(range, 1e-3);
  let worst = { difference: 0 };
  let jumps = 0;
  for (let i = 0; i < want.length; i += 1) {
    const difference = Math.abs(got[i] - want[i]);
    if (difference > allowed || Number.isNaN(difference)) {
      const [x, y] = metres(place, i);
      const around = await Promise.all([-d, 0, d].flatMap((dx) => [-d, 0, d].map((dy) => at(name, x + dx, y + dy))));
      const [least, greatest] = [Math.min(...around), Math.max(...around)];
      if (greatest - least > allowed && got[i] >= least - allowed && got[i] <= greatest + allowed) {
        jumps += 1;
        continue;
      }
    }
    if (!(difference <= worst.difference)) worst = { difference, x: metres(place, i)[0], y: metres(place, i)[1], got: got[i], want: want[i] };
  }
  return { ...worst, part: worst.difference / Math.max(range, 1e-3), jumps };
}

async function check(t, language, run) {
  const faults = [];
  const parts = new Map();
  for (const { programme, like, later, derivative, far, tolerance } of cases) {
    if (later && !complete && !derivative) {
      t.diagnostic(`left out until the server has its formula: ${programme}`);
      continue;
    }
    const allowed = later && !complete ? tolerance * 100 : tolerance;
    await put('shader', programme);
    const source = await text(`worlds/shader/shader.${language}`);
    await put('like', like);
    for (const place of far ? [NEAR, FAR] : [NEAR]) {
      const got = await page.evaluate(run, { source, west: metres(place, 0)[0], north: metres(place, 0)[1], side: SIDE, spacing: SPACING });
      assert.ok(!got.skip, got.skip);
      const found = await compare('like', place, got.values, await heights('like', place), allowed, SCALE * (later && !complete ? DIFFERENCE : MARGIN));
      const where = place === FAR ? ' far out' : '';
      parts.set(`${programme}${where}`, found);
      if (!(found.part <= allowed)) faults.push(`${programme}${where}: off by ${found.part.toExponential(2)} of the range, ${JSON.stringify(found)}`);
      if (found.jumps > MOST_JUMPS * SIDE * SIDE) faults.push(`${programme}${where}: ${found.jumps} points at jumps`);
    }
  }
  for (const [name, { part, jumps }] of parts) {
    if (process.env.TERRANE_SHOW) t.diagnostic(`${part.toExponential(1)} ${jumps > 0 ? `(${jumps} jumps) ` : ''}${name.slice(0, 100)}`);
  }
  const worst = [...parts].reduce((a, b) => (b[1].part > a[1].part ? b : a));
  t.diagnostic(`${parts.size} comparisons of ${SIDE * SIDE} points, the worst ${worst[1].part.toExponential(1)} of the range: ${worst[0].slice(0, 100)}`);
  assert.deepEqual(faults, []);
}

test('WebGL 2 computes the heights of the server', { timeout: 600_000 }, (t) => check(t, 'glsl', runWebGl));

test('WebGPU computes the heights of the server', { timeout: 600_000 }, async (t) => {
  const probe = await page.evaluate(runWebGpu, { source: '', side: 1, spacing: 1, west: 0, north: 0, probe: true });
  if (probe.skip) {
    console.error(`\n*** WebGPU NOT TESTED: ${probe.skip} ***\n`);
    t.skip(probe.skip);
    return;
  }
  await check(t, 'wgsl', runWebGpu);
});

test('the example worlds are the same in metres, by every function that a shader offers', { timeout: 600_000 }, async (t) => {
  const examples = (await server.get('worlds')).worlds.map(({ name }) => name).filter((name) => !['shader', 'like', 'formula'].includes(name));
  const [west, north] = metres(NEAR, 0);
  const number = (value) => value.toFixed(4);
  let refused = 0;
  for (const name of examples) {
    const { base: { programme, scale, origin, amplitude, datum }, elevation: { min, max }, layers } = await server.get(`worlds/${name}`);
    // A shader is the world's base; what lies over it is on the server alone.
    if (layers.length > 0) continue;
    if (JSON.stringify(programme).includes('erosion')) {
      const response = await fetch(`${server.url}/worlds/${name}/shader.glsl`);
      assert.equal(response.status, 404);
      assert.match((await response.json()).detail, /erosion/);
      refused += 1;
      continue;
    }
    const want = await heights(name, NEAR);
    const source = await text(`worlds/${name}/shader.glsl`);
    const units = `(vec2(metres) - vec2(${origin.map(number)})) / ${number(scale)}`;
    const value = `clamp(${number(datum)} + ${number(amplitude)} * terrane_value(${units}), ${number(min)}, ${number(max)})`;
    for (const call of ['terrane_elevation_at(metres - ivec2(3), vec2(3.0))', 'terrane_elevation(vec2(metres))', value]) {
      const got = await page.evaluate(runWebGl, { source, call, west, north, side: SIDE, spacing: SPACING });
      const found = await compare(name, NEAR, got.values, want, 1e-5, scale * MARGIN);
      t.diagnostic(`${name}: ${found.difference.toExponential(1)} m (${found.jumps} jumps) by ${call.slice(0, 40)}`);
      assert.ok(found.part <= 1e-5, `${name}: ${JSON.stringify(found)} by ${call}`);
      // The seven logarithms of Equation 2 leave every thirtieth point near one of their poles.
      assert.ok(found.jumps <= (name === 'eq2' ? 0.05 : MOST_JUMPS) * SIDE * SIDE, `${name}: ${found.jumps} points at jumps`);
    }
  }
  assert.equal(refused, 1, 'cordillera');
  assert.deepEqual(browser.faults, []);
});
