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

/** All twelve pictures are there, and nothing is under way. */
const ready = (page) => page.waitForFunction(() => {
  const studio = document.querySelector('dialog.studio');
  const pictures = [...studio.querySelectorAll('.terrain img')];
  return !studio.hasAttribute('aria-busy') && pictures.length === 12 && pictures.every((image) => image.complete && image.naturalWidth === 256);
});
const chosen = (page) => page.$$eval('.terrain', (cards) => cards.flatMap((card, i) => (card.getAttribute('aria-pressed') === 'true' ? [i] : [])));
const sessions = async () => (await server.get('breeding')).sessions;
const origins = (page) => page.$$eval('.terrain .hint', (all) => all.map(({ textContent }) => textContent));
const generations = (page, count) => page.waitForFunction((n) => document.querySelectorAll('#studio-history li').length === n, count);

test('terrain is bred with the keyboard alone, undone, and survives the page', async () => {
  const page = await browser.open('', { viewport: { width: 1280, height: 800 } });
  await settled(page);
  await page.keyboard.press('b');
  await ready(page);
  await picture(page, 'studio-first');
  assert.deepEqual(await origins(page), Array(12).fill('grown at random'));

  await page.keyboard.press('3');
  await page.keyboard.press('0');
  assert.deepEqual(await chosen(page), [2, 9]);
  await page.keyboard.press('Enter');
  await generations(page, 2);
  await ready(page);
  assert.deepEqual((await origins(page)).slice(0, 2), ['chosen: 3 lives on', 'chosen: 10 lives on']);
  assert.ok((await origins(page)).includes('child of 3 and 10'));

  // Other children of the same parents, then one parent, then undo.
  await page.keyboard.press('1');
  await page.keyboard.press('Enter');
  await generations(page, 3);
  await ready(page);
  await page.keyboard.press('u');
  await generations(page, 2);
  const [session] = await sessions();
  assert.equal(session.generations, 2);

  await page.reload();
  await page.locator('dialog.studio').waitFor();
  await ready(page);
  await generations(page, 2);
  await page.keyboard.press('f');
  await page.keyboard.press('5');
  await page.keyboard.press('f');
  await page.locator('.family').waitFor();
  await page.waitForFunction(() => [...document.querySelectorAll('.family img')].every((image) => image.complete && image.naturalWidth > 0));
  assert.ok((await page.$$('.family li')).length >= 2);
  await picture(page, 'studio-family');
  // One Escape closes one dialog.
  await page.keyboard.press('Escape');
  await page.locator('.family').waitFor({ state: 'detached' });
  assert.ok(await page.isVisible('dialog.studio'));
  await page.keyboard.press('Escape');
  await page.locator('dialog.studio').waitFor({ state: 'detached' });
  await page.context().close();
});

test('going back keeps both ways, what is kept stays, and a world is made of it', async () => {
  const page = await browser.open('', { viewport: { width: 1280, height: 800 } });
  await settled(page);
  await page.click('#breed');
  await ready(page);
  await page.click('#studio-new');
  await ready(page);
  for (const i of [4, 1]) {
    const before = (await page.$$('#studio-history li')).length;
    await page.evaluate(() => document.activeElement.blur());
    for (const pressed of await chosen(page)) await page.click(`.terrain:nth-child(${pressed + 1})`);
    await page.click(`.terrain:nth-child(${i + 1})`);
    await page.click('#studio-next');
    await generations(page, before + 1);
    await ready(page);
  }
  await page.click('#studio-history li:first-child button');
  await page.waitForFunction(() => document.querySelector('#studio-history [aria-current]').parentElement === document.querySelector('#studio-history').firstElementChild);
  await ready(page);
  for (const pressed of await chosen(page)) await page.click(`.terrain:nth-child(${pressed + 1})`);
  await page.click('.terrain:nth-child(8)');
  await page.click('#studio-next');
  await page.click('dialog button:has-text("Keep both")');
  await page.waitForFunction(() => document.querySelector('#studio-session').value.includes('-branch-1'));
  await ready(page);

  await page.click('.terrain:nth-child(1)');
  await page.click('#studio-keep');
  await page.click('dialog button:has-text("Also to the library")');
  await page.waitForFunction(() => document.querySelector('#studio-kept button'));
  assert.ok((await server.get('programmes')).programmes.some(({ name }) => name.startsWith('terrain-2-')));
  await picture(page, 'studio-kept');

  await page.click('#studio-world');
  await page.fill('#dialog-line-0', 'bred-in-a-test');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelector('#world').value === 'bred-in-a-test');
  await settled(page);
  await picture(page, 'studio-world');
  const { base } = await server.get('worlds/bred-in-a-test');
  assert.equal(base.scale, 6000);
  await page.context().close();
});

test('on a phone the twelve fit and are chosen by touch', async () => {
  const page = await browser.open('', { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  await settled(page);
  await page.tap('#breed');
  await ready(page);
  await page.tap('.terrain:nth-child(6)');
  await page.waitForFunction(() => document.querySelector('.terrain:nth-child(6)').getAttribute('aria-pressed') === 'true');
  await page.screenshot({ path: new URL('out/studio-phone.png', import.meta.url).pathname });
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  await page.context().close();
});

test('no page had errors', () => assert.deepEqual(browser.faults, []));
