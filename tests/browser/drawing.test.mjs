import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { picture, settled, startBrowser } from './browser.mjs';
import { startServer } from './server.mjs';

const WORLD = 'drawing-test';
const VIEW = `#world=${WORLD}&at=0.31,0.22&zoom=9.7`;

let server;
let browser;

before(async () => {
  server = await startServer();
  browser = await startBrowser(server.url);
  const response = await fetch(`${server.url}/worlds?name=${WORLD}`, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify({ title: 'Drawing test', seed: 7, base: { programme: 'fbm(1, 2, 6)', scale: 30000, amplitude: 60, datum: 200 } }),
  });
  assert.equal(response.status, 201, await response.text());
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

const status = (page, text) => page.waitForFunction((part) => document.querySelector('#draw-status').textContent.includes(part), text);
const world = () => server.get(`worlds/${WORLD}`);
const elevation = async (x, y) => (await server.get(`worlds/${WORLD}/elevation?x=${x}&y=${y}`)).elevation;

/** Metres of the plane under a pixel, as the readout has them. */
async function metresAt(page, x, y) {
  await page.mouse.move(x, y);
  const handle = await page.waitForFunction(() => {
    const { where, x, y } = document.querySelector('#readout').dataset;
    return where === 'pointer' ? { x: +x, y: +y } : undefined;
  });
  return handle.jsonValue();
}

test('a ridge is drawn, previewed, made, seen in 3D, changed and taken out again', async () => {
  const page = await browser.open(VIEW, { viewport: { width: 1280, height: 800 } });
  await settled(page);
  await page.keyboard.press('d');
  await page.locator('#draw').waitFor();
  await settled(page);
  const empty = await picture(page, 'drawing-empty');

  const middle = await metresAt(page, 450, 420);
  await page.click('#pen-line');
  for (const [x, y] of [[300, 500], [450, 420], [620, 380]]) await page.mouse.click(x, y);
  await page.keyboard.press('Enter');
  await page.click('#pen-point');
  await page.mouse.click(600, 600);
  await page.keyboard.press('Escape');
  await status(page, 'Preview: up to');
  await settled(page);
  const preview = await picture(page, 'drawing-preview');
  const { difference } = await browser.measure(preview, empty);
  assert.ok(difference > 3, `the preview changes the map by ${difference} only`);
  assert.equal((await world()).layers.length, 0, 'nothing is stored yet');
  assert.deepEqual(await server.get('jobs'), { jobs: [] });

  // The ridge gets another height; the curve is bent with the keyboard and becomes the user's own.
  await page.mouse.click(450, 420);
  await page.waitForFunction(() => document.querySelector('#stroke-legend').textContent.startsWith('Stroke 1'));
  await page.fill('#stroke-height', '3600');
  await page.locator('.curve circle').nth(2).focus();
  for (let i = 0; i < 5; i++) await page.keyboard.press('ArrowUp');
  assert.equal(await page.inputValue('#stroke-profile'), 'own');
  await status(page, 'Preview: up to 3,600');
  await picture(page, 'drawing-changed');

  const before = await elevation(middle.x, middle.y);
  await page.click('#draw-make');
  await status(page, `part of ${WORLD}`);
  const { layers } = await world();
  assert.equal(layers.length, 1);
  assert.equal(layers[0].name, 'drawn');
  const raised = (await elevation(middle.x, middle.y)) - before;
  assert.ok(raised > 3000 && raised <= 3610, `the crest stands ${raised} m above the ground`);
  await page.waitForFunction(() => location.hash.includes('view=3d'));
  await settled(page);
  await picture(page, 'drawing-made');

  // What was drawn survives the page; a lower ridge takes the place of the layer.
  await page.reload();
  await settled(page);
  await page.keyboard.press('d');
  await page.waitForFunction(() => document.querySelector('#drawn-layers li'));
  await page.waitForFunction(() => document.querySelector('#draw-make').textContent === 'Make it anew');
  await page.click('#draw-clear');
  await page.click('dialog button:has-text("New drawing")');
  await page.click('#drawn-layers button:has-text("Edit")');
  await page.waitForFunction(() => document.querySelector('#draw-make').textContent === 'Make it anew');
  await page.evaluate(() => document.querySelector('#draw-roughness').focus());
  await page.keyboard.press('ArrowLeft');
  await page.click('#draw-make');
  await status(page, `part of ${WORLD}`);
  const anew = await world();
  assert.equal(anew.layers.length, 1);
  assert.notEqual(anew.layers[0].source.raster.hash, layers[0].source.raster.hash);

  await page.click('#drawn-layers button:has-text("Remove")');
  await status(page, 'Removed drawn');
  assert.equal((await world()).layers.length, 0);
  assert.equal(await elevation(middle.x, middle.y), before);
  await page.click('#draw-status button');
  await status(page, 'is back');
  assert.equal((await world()).layers.length, 1);
  await page.context().close();
});

test('undo goes back step by step, and all of it goes without a pointer', async () => {
  const page = await browser.open(VIEW);
  await settled(page);
  await page.locator('.maplibregl-canvas').focus();
  await page.keyboard.press('d');
  await page.locator('#pen-line:focus').waitFor();
  await page.keyboard.press('l');
  await page.keyboard.press('p');
  await page.locator('.maplibregl-canvas').focus();
  await page.keyboard.press('ArrowRight');
  await settled(page);
  await page.keyboard.press('p');
  await page.locator('#pen-finish').focus();
  await page.keyboard.press('Enter');
  await status(page, 'Preview: up to');
  const strokes = () => page.evaluate((name) => JSON.parse(localStorage.getItem(`terrane-sketch-${name}`)).sketch.strokes.length, WORLD);
  assert.equal(await strokes(), 1);
  await page.keyboard.press('Escape');
  await page.keyboard.press('Control+z');
  assert.equal(await strokes(), 0);
  assert.ok(await page.isDisabled('#draw-make'));
  await page.keyboard.press('Escape');
  assert.ok(await page.isHidden('#draw'));
  await page.context().close();
});

test('what the server refuses is said in the form', async () => {
  const page = await browser.open(VIEW, {}, ['422']);
  await settled(page);
  // The form itself lets nothing wrong through: it is made wrong on its way.
  await page.route('**/jobs/preview', (route) => {
    const work = route.request().postDataJSON();
    work.paths.drawing.bias = 5000;
    return route.continue({ postData: JSON.stringify(work) });
  });
  await page.keyboard.press('d');
  await page.keyboard.press('k');
  await page.mouse.click(300, 300);
  await page.waitForFunction(() => document.querySelector('#draw-status').className === 'error');
  assert.match(await page.textContent('#draw-status'), /The drawing cannot be made\. \/bias: must be 0 … 1000/);
  await picture(page, 'drawing-refused');
  await page.context().close();
});

test('on a phone the panel is a sheet and strokes are drawn by touch', async () => {
  const page = await browser.open(VIEW, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  await settled(page);
  await page.tap('#draw-button');
  await page.tap('#pen-point');
  await page.touchscreen.tap(200, 200);
  await status(page, 'Preview: up to');
  await settled(page);
  await picture(page, 'drawing-phone');
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.equal(width, 390, 'nothing is wider than the screen');
  await page.context().close();
});

test('no page had errors', () => assert.deepEqual(browser.faults, []));
