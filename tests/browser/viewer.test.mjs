import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { picture, pointAt, settled, startBrowser } from './browser.mjs';
import { startServer } from './server.mjs';

const WORLD = 'browser-test';
const PROGRAMME = 'ridged_multifractal(1.0, 2.0, 8, 1.0, 2.0)';
const DOCUMENT = {
  title: 'Browser test',
  seed: 7,
  base: { programme: PROGRAMME, scale: 20000, amplitude: 1500, datum: 300 },
};
const FLAT = `#world=${WORLD}&at=0.31,0.22&zoom=9.7`;
const TILTED = `#world=${WORLD}&at=0.31,0.22&zoom=9.7&bearing=20&pitch=35&view=3d`;
/** Half the side of the web grid. */
const HALF = Math.PI * 6378137;
/** One step of the terrarium encoding. */
const STEP = 1 / 256;

let server;
let browser;

before(async () => {
  server = await startServer();
  browser = await startBrowser(server.url);
  const response = await fetch(`${server.url}/worlds?name=${WORLD}`, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify(DOCUMENT),
  });
  assert.equal(response.status, 201, await response.text());
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

const assertTerrain = ({ colours, deviation }) => {
  assert.ok(colours > 500, `only ${colours} colours`);
  assert.ok(deviation > 4, `brightness varies by ${deviation} only`);
};

const programme = (page) => page.locator('#field-base-programme');
const status = (page, text) =>
  page.waitForFunction((part) => document.querySelector('#editor-status').textContent.includes(part), text);

/** Opens the form by its key and replaces the programme, all with the keyboard. */
async function typeProgramme(page, text) {
  await page.locator('.maplibregl-canvas').focus();
  await page.keyboard.press('e');
  await programme(page).waitFor();
  await page.keyboard.press('Control+a');
  await page.keyboard.type(text);
}

/**
 * Holds what the readout says against the server.
 *
 * The readout interpolates between the four pixel centres around the point. Each of them is the server's elevation,
 * rounded to the nearest 1/256 m, and an interpolation cannot enlarge that. So the readout equals the interpolation
 * of the server's own four values within one step.
 *
 * How far may that lie from the server's elevation at the point itself? Along one axis a line between two samples
 * misses a smooth function by at most |d²|/8, d² being the second difference, and a kink (a ridge) of strength k at
 * the place t between them by k·t·(1-t), while the second differences at the two samples are k·(1-t) and k·t: by at
 * most half of the larger one. So: half the largest second difference along x plus half of that along y, taken over
 * the 4 × 4 samples around the point.
 */
async function assertElevation(shown) {
  const { x, y, spacing } = shown;
  const ask = async (px, py) =>
    (await server.get(`worlds/${WORLD}/elevation?x=${px}&y=${py}&spacing=${spacing}`)).elevation;
  const column = (x + HALF) / spacing - 0.5;
  const row = (HALF - y) / spacing - 0.5;
  const [c, r] = [Math.floor(column), Math.floor(row)];
  const rows = await Promise.all([-1, 0, 1, 2].map((dr) => Promise.all([-1, 0, 1, 2].map((dc) =>
    ask((c + dc + 0.5) * spacing - HALF, HALF - (r + dr + 0.5) * spacing)))));
  const [east, south] = [column - c, row - r];
  const mix = (a, b, t) => a + (b - a) * t;
  const expected = mix(mix(rows[1][1], rows[1][2], east), mix(rows[2][1], rows[2][2], east), south);
  assert.ok(Math.abs(shown.elevation - expected) <= STEP, `${JSON.stringify(shown)}: the four samples give ${expected}`);

  const bend = (a, b, d) => Math.abs(a - 2 * b + d);
  const bends = (lines) => Math.max(...lines.flatMap(([p, q, s, t]) => [bend(p, q, s), bend(q, s, t)]));
  const columns = [0, 1, 2, 3].map((i) => rows.map((line) => line[i]));
  const bound = (bends(rows) + bends(columns)) / 2 + STEP;
  const there = await ask(x, y);
  assert.ok(Math.abs(shown.elevation - there) <= bound, `${JSON.stringify(shown)}: the server says ${there} ± ${bound}`);
}

test('without a link the page opens where a world shows relief', async () => {
  const page = await browser.open('');
  await settled(page);
  assertTerrain(await browser.measure(await picture(page, 'start')));
  const { worlds } = await server.get('catalog');
  assert.equal(await page.locator('#world option').count(), worlds.length);
  assert.ok(worlds.some(({ name }) => page.url().includes(`#world=${name}&at=`)), page.url());
  await page.context().close();
});

test('the map shows terrain flat and tilted, and the elevation under the pointer is the server\'s', async () => {
  const page = await browser.open(FLAT);
  await settled(page);
  const flat = await picture(page, 'flat');
  assertTerrain(await browser.measure(flat));
  for (const [x, y] of [[450, 320], [711, 187], [383, 555], [800, 600]]) {
    const shown = await pointAt(page, x, y);
    assert.equal(shown.zoom, 10, 'MapLibre rounds the zoom for 512 px raster tiles');
    assert.equal(shown.spacing, 78271.51696402048 / 2 ** 10);
    await assertElevation(shown);
  }

  await page.keyboard.press('t');
  await page.waitForFunction(() => /pitch=60.*view=3d/.test(location.hash));
  await settled(page);
  const tilted = await picture(page, 'tilted');
  assertTerrain(await browser.measure(tilted));
  const { difference } = await browser.measure(tilted, flat);
  assert.ok(difference > 4, `tilted differs from flat by ${difference} only`);
  for (const [x, y] of [[460, 330], [700, 250], [360, 500]]) await assertElevation(await pointAt(page, x, y));

  await page.keyboard.press('t');
  await page.waitForFunction(() => !/view=3d|pitch/.test(location.hash));
  await settled(page);
  const back = await browser.measure(await picture(page, 'flat-again'), flat);
  assert.ok(back.difference < 1, `flat again differs by ${back.difference}`);
  await page.context().close();
});

test('the elevation is right at the edge between two tiles', async () => {
  // The middle of the view is lon 0, lat 0: the corner of four tiles. The pointer stands half a pixel beside it.
  const page = await browser.open(`#world=${WORLD}&at=0,0&zoom=10`);
  await settled(page);
  const { width, height } = page.viewportSize();
  await pointAt(page, width / 2 + 40, height / 2 + 40);
  const shown = await pointAt(page, width / 2, height / 2);
  assert.ok(Math.abs(shown.x) <= shown.spacing / 2 && Math.abs(shown.y) <= shown.spacing / 2, JSON.stringify(shown));
  await assertElevation(shown);
  await page.context().close();
});

test('a programme edited and saved with the keyboard changes the picture and the catalog', async () => {
  const page = await browser.open(FLAT);
  await settled(page);
  const [picture0, revision0, view0] = [await picture(page, 'edit-before'), await server.revision(WORLD), page.url()];
  await typeProgramme(page, 'plus(fbm(1.0, 1.97, 6), multiply(0.1, x))');
  await page.keyboard.press('Control+Enter');
  await status(page, 'Saved.');
  await settled(page);
  assert.notEqual(await server.revision(WORLD), revision0);
  const stored = await server.get(`worlds/${WORLD}`);
  assert.equal(stored.base.programme, 'plus(fbm(1.0, 1.97, 6), multiply(0.1, x))');
  await page.keyboard.press('Escape');
  await page.locator('#panel').waitFor({ state: 'hidden' });
  await settled(page);
  assert.equal(page.url(), view0, 'the view stays');
  const picture1 = await picture(page, 'edit-after');
  assertTerrain(await browser.measure(picture1));
  const { difference } = await browser.measure(picture1, picture0);
  assert.ok(difference > 4, `the picture differs by ${difference} only`);
  await assertElevation(await pointAt(page, 700, 300));

  // What was swapped in place must be what a fresh page shows: old tiles or old tile edges would differ.
  const fresh = await browser.open(FLAT);
  await settled(fresh);
  const same = await browser.measure(await picture(fresh, 'edit-fresh'), picture1);
  assert.ok(same.difference < 0.01, `a fresh page differs by ${same.difference}`);
  await fresh.context().close();
  await page.context().close();
});

test('an unknown function is marked at its place and nothing is saved', async () => {
  const page = await browser.open(FLAT, {}, ['422']);
  const refused = page.waitForResponse((response) => response.request().method() === 'PUT');
  await settled(page);
  const revision = await server.revision(WORLD);
  const text = 'plus(fbm(1.0, 1.97, 6), fmb(1.0, 2.0, 4))';
  await typeProgramme(page, text);
  await page.keyboard.press('Control+Enter');
  assert.equal((await refused).status(), 422);
  await page.locator('.programme mark').waitFor();
  assert.deepEqual(await page.locator('.programme mark').allTextContents(), ['fmb']);
  const state = await programme(page).evaluate((area) => ({
    selected: area.value.slice(area.selectionStart, area.selectionEnd),
    at: area.selectionStart,
    focused: document.activeElement === area,
    invalid: area.getAttribute('aria-invalid'),
    value: area.value,
  }));
  assert.deepEqual(state, { selected: 'fmb', at: text.indexOf('fmb'), focused: true, invalid: 'true', value: text });
  assert.match(await page.locator('#field-base-programme-error').textContent(), /Line 1, column 25: .*fmb/);
  await status(page, 'Not saved');
  await picture(page, 'error');
  assert.equal(await server.revision(WORLD), revision);

  // Another world is not opened over what has not been saved, unless the user says so.
  const { worlds } = await server.get('catalog');
  const other = worlds.find(({ name }) => name !== WORLD);
  if (other) {
    await page.locator('#world').selectOption(other.name);
    await page.locator('dialog').getByRole('button', { name: 'Keep editing' }).click();
    assert.equal(await programme(page).inputValue(), text);
    await page.waitForFunction((name) => document.querySelector('#world').value === name, WORLD);
  }
  await page.context().close();
});

test('somebody else\'s saving is noticed and the user\'s text survives', async () => {
  const page = await browser.open(FLAT, {}, ['412']);
  await settled(page);
  await typeProgramme(page, 'fbm(1.0, 2.0, 5)');
  const theirs = { ...(await server.get(`worlds/${WORLD}`)), seed: 1234 };
  await fetch(`${server.url}/worlds/${WORLD}`, {
    method: 'PUT', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(theirs),
  });
  await page.keyboard.press('Control+Enter');
  await page.locator('dialog').getByRole('button', { name: 'Load theirs' }).click();
  await status(page, 'Loaded');
  assert.equal(await page.locator('#field-seed').inputValue(), '1234');
  await page.getByRole('button', { name: 'Bring my changes back' }).click();
  assert.equal(await programme(page).inputValue(), 'fbm(1.0, 2.0, 5)');
  await programme(page).press('Control+Enter');
  await status(page, 'Saved.');
  assert.equal((await server.get(`worlds/${WORLD}`)).base.programme, 'fbm(1.0, 2.0, 5)');
  await page.context().close();
});

test('a link restores the view', async () => {
  const page = await browser.open(TILTED, { viewport: { width: 740, height: 420 } });
  await settled(page);
  await page.locator('.maplibregl-canvas').focus();
  const hash = () => page.evaluate(() => location.hash);
  const before = await hash();
  await page.keyboard.press('ArrowRight');
  await page.waitForFunction((old) => location.hash !== old, before);
  await settled(page);
  const [link, first] = [await hash(), await picture(page, 'link')];
  assert.match(link, new RegExp(`^#world=${WORLD}&at=.*&zoom=9\\.7&bearing=20&pitch=35&view=3d$`));
  await page.reload();
  await settled(page);
  assert.equal(await hash(), link);
  assert.equal(await page.locator('#tilt').getAttribute('aria-pressed'), 'true');
  const { difference } = await browser.measure(await picture(page, 'link-again'), first);
  assert.ok(difference < 1, `the picture differs by ${difference}`);

  // A link to where MapLibre starts anyway is a link too.
  await page.goto('about:blank');
  await page.goto(`${server.url}/#world=${WORLD}&at=0,0&zoom=0`);
  await settled(page);
  assert.match(await hash(), /at=0,0&zoom=[01](\.\d+)?$/);
  await page.context().close();
});

test('the page is usable on a phone', async () => {
  const phone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, colorScheme: 'dark' };
  const page = await browser.open(FLAT, phone);
  await settled(page);
  /** Nothing sticks out, no control lies under another thing, and the page cannot be scrolled sideways. */
  const assertLayout = async (where) => {
    const faults = await page.evaluate(() => {
      const found = [];
      const root = document.documentElement;
      if (root.scrollWidth > 390 || innerWidth > 390) found.push(`the page is ${root.scrollWidth} wide`);
      for (const element of document.querySelectorAll('button, select, input, textarea, summary, .card')) {
        const { left, right, top, bottom, width } = element.getBoundingClientRect();
        const inside = element.closest('.fields')?.getBoundingClientRect();
        const [x, y] = [(left + right) / 2, (top + bottom) / 2];
        if (width === 0 || (inside && (y < inside.top || y > inside.bottom))) continue;
        const name = element.id || element.className || element.textContent;
        if (left < 0 || right > 390 || top < 0 || bottom > 844 && !inside) found.push(`${name} sticks out`);
        const hit = document.elementFromPoint(x, y);
        if (!hit || !(element.contains(hit) || hit.contains(element))) found.push(`${name} lies under ${hit?.outerHTML.slice(0, 80)}`);
      }
      return found;
    });
    assert.deepEqual(faults, [], where);
  };
  await assertLayout('map');
  await page.touchscreen.tap(200, 300);
  await page.waitForFunction(() => document.querySelector('#readout').dataset.where === 'tap');
  await picture(page, 'phone');
  await page.locator('#edit').tap();
  await page.locator('#panel').waitFor();
  await settled(page);
  await assertLayout('form');
  const map = await page.locator('#map').boundingBox();
  assert.ok(map.height > 250, `the map keeps ${map.height} px`);
  await page.locator('#field-sea_level').fill('-50');
  await page.getByRole('button', { name: 'Save', exact: true }).tap();
  await status(page, 'Saved.');
  await settled(page);
  await picture(page, 'phone-form');
  await assertLayout('saved');
  assert.equal((await server.get(`worlds/${WORLD}`)).sea_level, -50);
  await page.context().close();
});

test('the keyboard reaches everything, and the first stop leads to the map', async () => {
  const page = await browser.open(FLAT);
  await settled(page);
  const focused = () => page.evaluate(() => document.activeElement.id || document.activeElement.className);
  await page.keyboard.press('Tab');
  assert.equal(await focused(), 'skip');
  await page.keyboard.press('Enter');
  assert.match(await focused(), /maplibregl-canvas/);
  const before = page.url();
  await page.keyboard.press('+');
  await page.waitForFunction((old) => location.href !== old, before);
  await page.locator('.skip').focus();
  const stops = [];
  for (let i = 0; i < 12; i++) {
    await page.keyboard.press('Tab');
    stops.push(await focused());
  }
  for (const stop of ['world', 'edit', 'tilt']) assert.ok(stops.includes(stop), `${stop} is not among ${stops}`);
  await page.context().close();
});

test('a server that is gone is named, and the page recovers by itself when asked', async () => {
  const page = await browser.open('robots-not-there#', {}, ['']); // any page of the origin; all its faults are provoked
  await page.route('**/catalog', (route) => route.abort());
  await page.goto(`${server.url}/${FLAT}`);
  const notice = page.locator('#notice');
  await notice.getByText('does not answer').waitFor();
  await page.unroute('**/catalog');
  await notice.getByRole('button', { name: 'Try again' }).click();
  await settled(page);
  assertTerrain(await browser.measure(await picture(page, 'recovered')));
  await page.context().close();
});

test('nothing went wrong on the way, in the pages or in the server\'s log', async () => {
  assert.deepEqual(browser.faults, []);
  const bad = server.log().split('\n').filter((line) => /\b(WARN|ERROR)\b|panicked/.test(line));
  assert.deepEqual(bad, []);
});
