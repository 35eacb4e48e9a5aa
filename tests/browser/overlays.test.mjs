import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { picture, settled, startBrowser } from './browser.mjs';
import { startServer } from './server.mjs';

const WORLD = 'overlays';
const DOCUMENT = {
  seed: 7,
  base: { programme: 'fbm(1, 2, 8)', scale: 20000, amplitude: 300, datum: 200 },
};
const crest = [{ name: 'elevation', value: 'shape', weight: 'linear', range: 900 }];
const river = [{ name: 'elevation', value: 'shape', range: 300, channel: { half_width: 40 } }];
const line = (id, attributes, coordinates) => ({
  type: 'Feature',
  id,
  geometry: { type: 'LineString', coordinates },
  properties: { attributes, detail: { iterations: 6, displacement: 0.09 } },
});
const FEATURES = {
  type: 'FeatureCollection',
  attributes: { crest, river },
  features: [
    line('ridge', 'crest', [[-6000, 2000, 900], [0, 4000, 1200], [6000, 2500, 800]]),
    line('river', 'river', [[-6000, -1000, 300], [0, -2500, 200], [6000, -2000, 100]]),
    { type: 'Feature', id: 'peak', geometry: { type: 'Point', coordinates: [0, 4000, 1250] }, properties: { attributes: 'crest' } },
  ],
};
const VIEW = `#world=${WORLD}&at=0,0.01&zoom=11.5`;

let server;
let browser;

before(async () => {
  server = await startServer();
  browser = await startBrowser(server.url);
  const send = (path, method, body) =>
    fetch(`${server.url}/worlds/${path}`, { method, body: JSON.stringify(body), headers: { 'Content-Type': 'application/json' } });
  for (const response of [await send(WORLD, 'PUT', DOCUMENT), await send(`${WORLD}/features`, 'POST', FEATURES), await send('bare', 'PUT', DOCUMENT)]) {
    assert.equal(response.status, 201, await response.text());
  }
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

test('contours and features are shown and hidden, and the link keeps them', async () => {
  const page = await browser.open(VIEW);
  await settled(page);
  const plain = await picture(page, 'overlays-none');
  const different = async (name) => (await browser.measure(await picture(page, name), plain)).difference;
  await page.locator('#contours').click();
  await page.waitForFunction(() => /show=contours$/.test(location.hash));
  await settled(page);
  const contours = await different('overlays-contours');
  await page.keyboard.press('f');
  await page.waitForFunction(() => /show=contours,features$/.test(location.hash));
  await settled(page);
  const both = await different('overlays-both');
  assert.ok(contours > 0.1 && both > contours, `${contours} ${both}`);
  assert.equal(await page.locator('#features').getAttribute('aria-pressed'), 'true');
  await page.locator('#contours').click();
  await page.locator('#features').click();
  await settled(page);
  assert.ok((await different('overlays-gone')) < contours / 10, 'nothing is left of them');
  const linked = await browser.open(`${VIEW}&show=features&bearing=20&pitch=50&view=3d`);
  await settled(linked);
  assert.equal(await linked.locator('#features').getAttribute('aria-pressed'), 'true');
  await picture(linked, 'overlays-3d');
  assert.deepEqual(browser.faults, []);
});

test('a world without layers has no button for features, and a phone has room for all', async () => {
  const page = await browser.open('#world=bare&at=0,0.01&zoom=11.5&show=contours,features', { viewport: { width: 390, height: 780 } });
  await settled(page);
  assert.equal(await page.locator('#features').isVisible(), false);
  assert.equal(await page.locator('#contours').getAttribute('aria-pressed'), 'true');
  await picture(page, 'overlays-phone');
  assert.deepEqual(browser.faults, []);
});
