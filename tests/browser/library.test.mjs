import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { picture, settled, startBrowser } from './browser.mjs';
import { startServer } from './server.mjs';

const WORLD = 'browser-test';
const DOCUMENT = { title: 'Browser test', seed: 7, base: { programme: 'fbm(1, 2, 8)', scale: 20000, origin: [10, 20] } };

let server;
let browser;

before(async () => {
  server = await startServer();
  browser = await startBrowser(server.url);
  const response = await fetch(`${server.url}/worlds/${WORLD}`, { method: 'PUT', body: JSON.stringify(DOCUMENT) });
  assert.equal(response.status, 201, await response.text());
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

const field = (page, name) => page.locator(`#field-${name}`);
const status = (page, text) =>
  page.waitForFunction((part) => document.querySelector('#editor-status').textContent.includes(part), text);

/** The page with the form open; `tolerated` as in browser.open. */
async function editing(options, tolerated) {
  const page = await browser.open(`#world=${WORLD}`, options, tolerated);
  await settled(page);
  await page.locator('#edit').click();
  await page.locator('#panel').waitFor();
  return page;
}

/** Opens the gallery, and waits until every picture that can be seen is there. */
async function openGallery(page) {
  await page.getByRole('button', { name: 'Choose a programme…' }).click();
  await page.getByRole('dialog', { name: 'Choose a programme' }).waitFor();
  await page.waitForFunction(() => {
    const { bottom } = document.querySelector('.choices').getBoundingClientRect();
    const seen = [...document.querySelectorAll('.choice img')].filter((image) => image.getBoundingClientRect().top < bottom);
    return seen.length > 0 && seen.every((image) => image.complete && image.naturalWidth > 0);
  });
}

const visible = (page) => page.locator('.choice:visible .choice-title').allTextContents();

test('the gallery shows every programme with its picture, and narrows to tags and words', async () => {
  const page = await editing();
  await openGallery(page);
  const { programmes } = await server.get('programmes');
  assert.deepEqual(await visible(page), programmes.map(({ title }) => title));
  await picture(page, 'gallery');
  const measured = await browser.measure(await page.locator('.choice img').first().screenshot());
  assert.ok(measured.colours > 500 && measured.deviation > 10, JSON.stringify(measured));

  await page.getByRole('button', { name: 'desert', exact: true }).click();
  const deserts = (await server.get('programmes?tag=desert')).programmes.map(({ title }) => title);
  assert.ok(deserts.length > 0 && deserts.length < programmes.length);
  assert.deepEqual(await visible(page), deserts, 'the page and the server find the same');
  assert.equal(await page.locator('.gallery [role=status]').textContent(), `${deserts.length} of ${programmes.length} programmes`);
  await page.getByLabel('Search the library').fill('canyons');
  assert.deepEqual(await visible(page), (await server.get('programmes?tag=desert&q=canyons')).programmes.map(({ title }) => title));
  await page.getByLabel('Search the library').fill('no such thing');
  assert.deepEqual(await visible(page), []);
  await page.context().close();
});

test('a programme is chosen with the keyboard alone, fills the form, and can be undone', async () => {
  const page = await editing();
  const before = await field(page, 'base-programme').inputValue();
  const mesas = await server.get('programmes/mesas');
  await page.locator('#choose-programme').focus();
  await page.keyboard.press('Enter');
  await page.getByRole('dialog').waitFor();
  assert.equal(await page.evaluate(() => document.activeElement.id), 'gallery-search');
  await page.keyboard.type('mesas');
  await page.keyboard.press('Enter'); // to the first card found
  assert.equal(await page.evaluate(() => document.activeElement.value), 'mesas');
  await page.keyboard.press('Space');
  assert.match(await page.locator('.gallery .about').textContent(), /tables/);
  await page.keyboard.press('Enter');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
  await status(page, 'Filled in Mesas');
  const values = async () => Promise.all(
    ['base-programme', 'base-scale', 'base-amplitude', 'base-datum', 'sea_level', 'elevation-max', 'seed', 'base-origin-0', 'title']
      .map((name) => field(page, name).inputValue()));
  const filled = [mesas.programme, mesas.scale, mesas.amplitude, mesas.datum, mesas.sea_level, mesas.elevation.max, 7, 10, 'Browser test'];
  assert.deepEqual(await values(), filled.map(String));
  await picture(page, 'gallery-filled');
  assert.ok(await page.locator('#changed').isVisible());
  await page.getByRole('button', { name: 'Undo' }).click();
  assert.equal(await field(page, 'base-programme').inputValue(), before);
  assert.ok(await page.locator('#changed').isHidden());

  // Leaving without choosing changes nothing.
  await openGallery(page);
  await page.getByRole('radio').first().check();
  await page.keyboard.press('Escape');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
  assert.equal(await field(page, 'base-programme').inputValue(), before);
  assert.ok(await page.locator('#panel').isVisible(), 'Escape closes the gallery alone');
  await page.context().close();
});

test('the focus stays in the gallery', async () => {
  const page = await editing();
  await openGallery(page);
  for (let i = 0; i < 40; i++) {
    await page.keyboard.press('Tab');
    // Past the last stop comes the browser's own bar, which is the body to the page.
    const outside = await page.evaluate(() => !document.activeElement.closest('dialog') && document.activeElement !== document.body);
    assert.ok(!outside, await page.evaluate(() => document.activeElement.outerHTML.slice(0, 80)));
  }
  await page.context().close();
});

test('a programme is saved to the library, found there, and not saved over by accident', async () => {
  const page = await editing({}, ['409']);
  await field(page, 'base-programme').fill('ridged_multifractal(1, 2, 6, 1, 2)');
  const save = async (fill) => {
    await page.getByRole('button', { name: 'Save to library…' }).click();
    await page.getByRole('dialog').waitFor();
    await fill();
  };
  await save(async () => {
    await page.getByRole('dialog').getByLabel('Title').fill('My Ridges');
    assert.equal(await page.getByRole('dialog').getByLabel('Name').inputValue(), 'my-ridges', 'the name follows the title');
    await page.getByRole('dialog').getByLabel('Tags').fill('Mountains, mine');
    await picture(page, 'library-save');
    await page.keyboard.press('Enter');
  });
  await status(page, 'Saved to the library as my-ridges.');
  const stored = await server.get('programmes/my-ridges');
  assert.deepEqual(
    [stored.title, stored.tags, stored.origin, stored.programme, stored.scale, stored.seed],
    ['My Ridges', ['mountains', 'mine'], `from the world ${WORLD}`, 'ridged_multifractal(1, 2, 6, 1, 2)', 20000, 7],
  );

  await field(page, 'base-amplitude').fill('555');
  await save(async () => {
    await page.getByRole('dialog').getByLabel('Name').fill('my-ridges');
    await page.keyboard.press('Enter');
    await page.locator('dialog .error').getByText('already named').waitFor();
    assert.equal(await page.evaluate(() => document.activeElement === document.querySelector('#dialog-line-1')), true);
    assert.equal((await server.get('programmes/my-ridges')).amplitude, 1000);
    await page.getByRole('button', { name: 'Replace it' }).click();
  });
  await status(page, 'Saved to the library as my-ridges.');
  const replaced = await server.get('programmes/my-ridges');
  assert.deepEqual([replaced.amplitude, replaced.tags], [555, ['mountains', 'mine']], 'tags that were not given again stay');

  await openGallery(page);
  await page.getByRole('button', { name: 'mine', exact: true }).click();
  assert.equal(await page.locator('.choice:visible').count(), 1);
  await page.context().close();
});

test('what is wrong is said where it can be mended', async () => {
  const page = await editing({}, ['422']);
  const save = page.getByRole('button', { name: 'Save to library…' });
  await save.click();
  await page.getByRole('dialog').getByLabel('Title').fill('Wrong tags');
  await page.getByRole('dialog').getByLabel('Tags').fill('über');
  await page.keyboard.press('Enter');
  await page.locator('dialog .error').getByText('a tag is').waitFor();
  await picture(page, 'library-wrong');
  assert.equal(await page.getByRole('dialog').getByLabel('Title').inputValue(), 'Wrong tags');
  await page.getByRole('button', { name: 'Cancel' }).click();
  await page.getByRole('dialog').waitFor({ state: 'detached' });

  await field(page, 'base-programme').fill('fmb(1, 2, 8)');
  await save.click();
  await page.getByRole('dialog').getByLabel('Name').fill('wrong');
  await page.keyboard.press('Enter');
  await page.locator('.programme mark').waitFor();
  assert.deepEqual(await page.locator('.programme mark').allTextContents(), ['fmb']);
  assert.equal((await fetch(`${server.url}/programmes/wrong`)).status, 404);
  await page.context().close();
});

test('the gallery is usable on a phone', async () => {
  const page = await browser.open(`#world=${WORLD}`, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, colorScheme: 'dark' });
  await settled(page);
  await page.locator('#edit').tap();
  await openGallery(page);
  assert.notEqual(await page.evaluate(() => document.activeElement.id), 'gallery-search', 'no keyboard comes up by itself');
  await picture(page, 'gallery-phone');
  const faults = await page.evaluate(() => [...document.querySelectorAll('.gallery button, .gallery .choice, #gallery-search')]
    .filter((element) => !element.closest('.chips'))
    .filter((element) => element.getBoundingClientRect().left < 0 || element.getBoundingClientRect().right > 390)
    .map((element) => element.textContent));
  assert.deepEqual(faults, []);
  const card = await page.locator('.choice').first().boundingBox();
  assert.ok(card.height > card.width, `a card is ${card.width} × ${card.height}`);
  await page.locator('.choice').nth(1).tap();
  const use = await page.getByRole('button', { name: 'Use it' });
  const box = await use.boundingBox();
  assert.ok(box.y + box.height <= 844, 'the answer is in view');
  await use.tap();
  await status(page, 'Filled in');
  await page.context().close();
});

test('nothing went wrong on the way, in the pages or in the server\'s log', async () => {
  assert.deepEqual(browser.faults, []);
  const bad = server.log().split('\n').filter((line) => /\b(WARN|ERROR)\b|panicked/.test(line));
  assert.deepEqual(bad, []);
});
