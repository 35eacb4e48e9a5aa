import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { picture, settled, startBrowser } from './browser.mjs';
import { startServer } from './server.mjs';

let server;
let browser;

before(async () => {
  server = await startServer();
  browser = await startBrowser(server.url);
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

const calm = (page) => page.waitForFunction(() => document.querySelector('dialog.evolve') && !document.querySelector('dialog.evolve').hasAttribute('aria-busy'));
const status = (page, text) => page.waitForFunction((text) => document.querySelector('#evolve-status').textContent.includes(text), text);
const drawn = (page) => page.waitForFunction(() => {
  const image = document.querySelector('#evolve-best');
  return image.complete && image.naturalWidth === 512;
});
const points = (page) => page.$eval('#evolve-curve polyline.best', (line) => line.getAttribute('points').split(' ').length);

/** Goes on with the Tab key until this has the focus. */
async function tabTo(page, selector) {
  for (let i = 0; i < 120; i++) {
    if (await page.evaluate((selector) => document.activeElement?.matches(selector), selector)) return;
    await page.keyboard.press('Tab');
  }
  assert.fail(`${selector} cannot be reached with the keyboard`);
}

async function type(page, selector, text) {
  await tabTo(page, selector);
  await page.keyboard.press('Control+a');
  await page.keyboard.type(text);
}

test('with the keyboard alone terrain is evolved, laid aside over a reload, resumed, kept and made a world', async () => {
  const page = await browser.open('', { viewport: { width: 1280, height: 800 } });
  await settled(page);
  await page.keyboard.press('b');
  await tabTo(page, '#way-evolve');
  await page.keyboard.press('Enter');
  await page.locator('dialog.evolve').waitFor();
  await calm(page);
  await picture(page, 'evolve-form');
  await type(page, '#evolve-samples', '48');
  await type(page, '#evolve-generations', '300');
  await type(page, '#evolve-population', '8');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelector('#evolve-curve polyline.best')?.getAttribute('points').split(' ').length > 2);
  await page.keyboard.press('s');
  await status(page, 'is stopped');
  await drawn(page);
  await picture(page, 'evolve-stopped');
  const before = await points(page);
  assert.ok(before > 2 && before < 301, `${before}`);
  const [job] = (await server.get('jobs')).jobs;
  assert.deepEqual([job.kind, job.state], ['evolution', 'stopped']);

  await page.reload();
  await page.locator('dialog.evolve').waitFor();
  await status(page, 'is stopped');
  await drawn(page);
  assert.equal(await points(page), before);
  await calm(page);
  await page.keyboard.press('s');
  await status(page, 'is done');
  await drawn(page);
  assert.equal(await points(page), 301);
  const { best, curve } = await server.get(`jobs/${job.id}/evolution`);
  assert.equal(curve.length, 301);
  assert.equal(await page.textContent('#evolve-scores .all .number'), best.score.toFixed(3));
  assert.deepEqual(await page.$$eval('#evolve-scores th', (all) => all.slice(0, 2).map(({ textContent }) => textContent)), ['Ground that can be reached', 'Many obstacles']);
  await calm(page);
  await picture(page, 'evolve-done');

  await page.keyboard.press('k');
  await page.locator('#dialog-line-0').waitFor();
  await page.keyboard.press('Control+a');
  await page.keyboard.type('found-in-a-test');
  await page.keyboard.press('Enter');
  await status(page, 'Kept found-in-a-test');
  const programme = await server.get('programmes/found-in-a-test');
  assert.deepEqual([programme.scale, programme.seed], [best.scale, best.seed]);
  await calm(page);
  await page.keyboard.press('w');
  await page.locator('#dialog-line-0').waitFor();
  await page.keyboard.press('Control+a');
  await page.keyboard.type('evolved-in-a-test');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelector('#world').value === 'evolved-in-a-test');
  await settled(page);
  const world = await server.get('worlds/evolved-in-a-test');
  assert.deepEqual([world.base.amplitude, world.base.datum], [best.amplitude, best.datum]);
  await picture(page, 'evolve-world');
  await page.context().close();
});

test('what is wrong stands at its field, terrain is measured, and the best goes into breeding', async () => {
  const page = await browser.open('', { viewport: { width: 1280, height: 800 } }, ['422']);
  await settled(page);
  await page.click('#breed');
  await page.click('#way-evolve');
  await calm(page);
  await page.fill('#evolve-relief', '0');
  await page.click('#evolve-start');
  await page.waitForFunction(() => document.querySelector('#evolve-relief-error').textContent.includes('metres'));
  assert.equal(await page.getAttribute('#evolve-relief', 'aria-invalid'), 'true');
  assert.ok(await page.evaluate(() => document.activeElement.id === 'evolve-relief'));
  await picture(page, 'evolve-wrong');
  await page.fill('#evolve-relief', '300');
  await page.fill('#evolve-generations', '10000');
  await page.fill('#evolve-samples', '1024');
  await page.click('#evolve-start');
  await page.waitForFunction(() => document.querySelector('#evolve-generations-error').textContent.includes('hours'));

  await page.fill('#evolve-samples', '32');
  await page.fill('#evolve-generations', '3');
  await page.fill('#evolve-population', '8');
  await page.uncheck('#want-edges');
  await page.check('#want-likeness');
  await page.click('#likeness-measure');
  await page.waitForFunction(() => document.querySelector('#evolve-likeness-sample').value.includes('roughness'));
  await picture(page, 'evolve-likeness');
  await page.click('#evolve-start');
  await status(page, 'is done');
  await drawn(page);
  await calm(page);
  const [job] = (await server.get('jobs')).jobs;
  const { best } = await server.get(`jobs/${job.id}/evolution`);
  assert.deepEqual(best.criteria.map(({ criterion }) => criterion), ['accessibility', 'likeness']);
  await page.click('#evolve-breed');
  await page.waitForFunction(() => document.querySelector('#studio-session')?.value.startsWith('evolved-'));
  await page.waitForFunction(() => [...document.querySelectorAll('.terrain img')].every((image) => image.complete && image.naturalWidth === 256));
  assert.equal(await page.getAttribute('.terrain', 'title'), best.programme);
  await picture(page, 'evolve-bred');
  await page.context().close();
});

test('on a phone it fits and is started by touch', async () => {
  const page = await browser.open('', { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  await settled(page);
  await page.tap('#breed');
  await page.tap('#way-evolve');
  await calm(page);
  await page.screenshot({ path: new URL('out/evolve-phone-form.png', import.meta.url).pathname });
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  await page.fill('#evolve-samples', '32');
  await page.fill('#evolve-generations', '4');
  await page.fill('#evolve-population', '8');
  await page.fill('#evolve-seed', '9');
  await page.tap('#evolve-start');
  await status(page, 'is done');
  await drawn(page);
  await page.screenshot({ path: new URL('out/evolve-phone.png', import.meta.url).pathname });
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  assert.equal(await page.$eval('.evolve-body', ({ scrollWidth, clientWidth }) => scrollWidth - clientWidth), 0);
  await page.context().close();
});

test('no page had errors', () => assert.deepEqual(browser.faults, []));
