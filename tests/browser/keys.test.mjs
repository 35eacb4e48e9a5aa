import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startBrowser } from './browser.mjs';
import { startServer } from './server.mjs';

let server, browser;

before(async () => {
  server = await startServer({ keyed: true });
  browser = await startBrowser(server.url);
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

test('a server that is closed asks for a key, once, and then shows and saves everything', async () => {
  const page = await browser.open('#world=hills&at=0,0&zoom=9', {}, ['answer: 401', 'status of 401']);
  const dialog = page.locator('dialog');
  await dialog.waitFor();
  await page.screenshot({ path: new URL('out/key.png', import.meta.url).pathname });
  await dialog.getByLabel('Key').fill('terrane_wrong');
  await page.keyboard.press('Enter');
  await page.getByText('The server knows no such key.').waitFor();
  assert.equal(await page.locator('dialog').count(), 1);
  await dialog.getByLabel('Key').fill(server.key);
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => !document.querySelector('dialog') && document.querySelector('#world').options.length > 5);
  const tile = await page.waitForResponse((response) => response.url().includes('/web/terrarium/') && response.status() === 200);
  assert.match((await tile.request().allHeaders())['authorization'], /^Bearer terrane_/);
  // The key is the tab's: another one asks again.
  const other = await browser.open('', {}, ['answer: 401', 'status of 401']);
  await other.locator('dialog').waitFor();
  await other.close();

  await page.getByRole('button', { name: 'Edit' }).click();
  await page.getByRole('button', { name: 'Choose a programme…' }).click();
  const picture = page.locator('dialog img').first();
  await page.waitForFunction((image) => image?.complete && image.naturalWidth > 0, await picture.elementHandle());
  await page.screenshot({ path: new URL('out/key-gallery.png', import.meta.url).pathname });
  await page.keyboard.press('Escape');
  await page.getByLabel('Title').fill('Hills with a key');
  const saved = page.waitForResponse((response) => response.request().method() === 'PUT');
  await page.getByRole('button', { name: 'Save', exact: true }).click();
  assert.equal((await saved).status(), 200);
});

test('nothing else went wrong', () => {
  assert.deepEqual(browser.faults, []);
});
