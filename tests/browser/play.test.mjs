import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { settled, startBrowser } from './browser.mjs';
import { startServer } from './server.mjs';

let server, browser;

before(async () => {
  server = await startServer();
  browser = await startBrowser(server.url);
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

/** Pictures only when something has changed: without a graphics card each takes long. */
const CALM = { reducedMotion: 'reduce' };
const SMALL = { viewport: { width: 480, height: 320 }, ...CALM };
const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, ...CALM };

/** What the page says of itself. */
const said = async (page) => {
  const told = await page.locator('#play').evaluate(({ dataset }) => ({ ...dataset }));
  const number = (name) => Number(told[name]);
  return { ...told, east: number('east'), north: number('north'), eye: number('eye'), ground: number('ground'), aim: number('aim'), far: number('far') };
};

const ready = (page) => page.waitForFunction(() => document.querySelector('#play').dataset.ready);

/** Waits until nothing moves or is being loaded, and the page has said so. */
async function still(page) {
  await page.waitForTimeout(300);
  await page.waitForFunction(() => document.querySelector('#play').dataset.still === 'true');
  return said(page);
}

const generation = (page, number) => page.waitForFunction((n) => document.querySelector('#life').dataset.generation === String(n), number);

const screenshot = (page, name) => page.screenshot({ path: new URL(`out/${name}.png`, import.meta.url).pathname });

/** Holds a key until the page says what `until` waits for, a function of what it says now and said before. */
async function hold(page, key, until) {
  const before = await page.locator('#play').evaluate(({ dataset }) => ({ ...dataset }));
  await page.keyboard.down(key);
  await page.waitForFunction(([until, before]) => new Function('now', 'before', `return ${until}`)(document.querySelector('#play').dataset, before), [until, before]);
  await page.keyboard.up(key);
}

const WALKED = 'Math.hypot(now.east - before.east, now.north - before.north) > 4';

const feed = async (body) => {
  const response = await fetch(`${server.url}/worlds/living/feedback`, { method: 'POST', body: JSON.stringify(body) });
  assert.equal(response.status, 200);
  return response.json();
};

/** Of a lattice of points that whose ground two revisions differ most about. */
async function mostChanged(old, now) {
  const points = Array.from({ length: 400 }, (_, i) => [-1500.5 + 157.9 * (i % 20), -1500.5 + 157.9 * Math.floor(i / 20)]);
  const ask = async (revision) => {
    const response = await fetch(`${server.url}/worlds/living@${revision}/elevation`, { method: 'POST', body: JSON.stringify({ points, spacing: 0.5 }) });
    assert.equal(response.status, 200, await response.clone().text());
    return (await response.json()).elevation;
  };
  const [were, are] = await Promise.all([ask(old), ask(now)]);
  const by = points.map((_, i) => Math.abs(were[i] - are[i]));
  const most = by.indexOf(Math.max(...by));
  return { place: points[most], were: were[most], are: are[most] };
}

test('one walks by keyboard alone, on the ground, and shapes what lies ahead', async () => {
  const page = await browser.open('#world=living&zoom=13&at=0,0', { viewport: { width: 900, height: 640 }, ...CALM });
  await settled(page);
  await page.keyboard.press('p'); // from the map into the world
  await page.waitForURL(/play\.html\?world=living#at=/);
  await ready(page);
  const first = await still(page);
  await page.setViewportSize({ width: 1280, height: 800 });
  await still(page);
  await screenshot(page, 'play');
  await page.setViewportSize({ width: 640, height: 420 });
  assert.ok(Math.abs(first.eye - Math.max(0, first.ground) - 1.7) < 1e-3, `stands: ${first.eye} over ${first.ground}`);
  assert.equal(first.spacing, '0.5');
  const spot = `x=${first.east}&y=${first.north}`;
  const exact = await server.get(`worlds/living/elevation?${spot}&spacing=0.5`);
  assert.ok(Math.abs(exact.elevation - first.ground) < 0.05, `${exact.elevation} ${first.ground}`);

  await hold(page, 'w', WALKED);
  const walked = await still(page);
  assert.ok(Math.abs(walked.eye - Math.max(0, walked.ground) - 1.7) < 0.01, 'on the ground');
  await hold(page, 'ArrowRight', 'now.heading - before.heading > 0.3');

  // Up, to see far; from the air nobody is promised anything.
  await page.keyboard.press('f');
  await hold(page, 'r', 'now.eye - now.ground > 60');
  await hold(page, 'PageDown', 'now.pitch - before.pitch < -0.2');
  const high = await still(page);
  assert.equal(high.flying, 'true');
  assert.ok(high.eye > high.ground + 50, `${high.eye} over ${high.ground}`);
  await page.selectOption('#reach', '');
  await page.locator('#ground').focus();
  const before = await said(page);
  await page.keyboard.press('Enter');
  await generation(page, 1);
  await page.waitForFunction((old) => document.querySelector('#play').dataset.revision !== old, before.revision);
  const after = await still(page);
  assert.ok(Number(after.moved) > 20, `${after.moved} of ${after.blocks} blocks have moved`);
  await page.setViewportSize({ width: 1280, height: 800 });
  await still(page);
  await screenshot(page, 'play-shaped');
  await page.setViewportSize({ width: 640, height: 420 });

  // Where it has changed most, the page shows what the server tells, and what it told before once one has gone back to the first generation.
  const { place, were, are } = await mostChanged(before.revision, after.revision);
  assert.ok(Math.abs(were - are) > 1, `${were} m became ${are} m`);
  await page.goto(`${server.url}/play.html?world=living&there#at=${place}`);
  await ready(page);
  await page.keyboard.press('f');
  const changed = await still(page);
  assert.ok(Math.abs(changed.ground - are) < 0.05, `${changed.ground} instead of ${are}`);
  const strip = page.locator('#past');
  await page.waitForFunction(() => !document.querySelector('#past').disabled);
  await strip.focus();
  await page.keyboard.press('Home');
  await generation(page, 0);
  await page.waitForFunction((old) => document.querySelector('#play').dataset.revision !== old, changed.revision);
  const back = await still(page);
  assert.ok(Math.abs(back.ground - were) < 0.05, `${back.ground} instead of ${were}`);
  assert.equal(await strip.getAttribute('max'), '1', 'what came after can be gone on to');
  await page.locator('#ground').focus();
  await page.keyboard.press('f');
  await page.waitForFunction(() => document.querySelector('#past').disabled);
  assert.match(await page.locator('#past-reason').textContent(), /fly/);

  const help = page.locator('#help');
  const wasShown = await help.isVisible();
  await page.keyboard.press('h');
  assert.notEqual(await help.isVisible(), wasShown, 'H shows the keys, or puts them away');
  await page.keyboard.press('m');
  await page.waitForURL(/#world=living&at=/);
  await settled(page);
  await page.context().close();
});

test('the ground ahead adapts to who walks, and the ground below stays', async () => {
  const page = await browser.open('play.html?world=living#at=-600,-500&to=40', SMALL);
  await ready(page);
  const { generations } = await server.get('worlds/living/generations');
  await page.keyboard.press('g');
  assert.ok(await page.locator('#ahead').isChecked());
  await page.keyboard.down('Shift');
  await page.keyboard.down('w');
  await generation(page, generations.length);
  const there = await said(page);
  await page.keyboard.up('w');
  await page.keyboard.up('Shift');
  const rested = await still(page);
  const old = await server.get(`worlds/living@${there.revision}/elevation?x=${rested.east}&y=${rested.north}&spacing=0.5`);
  const now = await server.get(`worlds/living/elevation?x=${rested.east}&y=${rested.north}&spacing=0.5`);
  assert.ok(Math.hypot(rested.east + 600, rested.north + 500) > 40);
  assert.equal(old.elevation, now.elevation, 'what is under the player does not move');
  const refused = await fetch(`${server.url}/worlds/living/generation`, { method: 'PUT', body: '{"generation": 0}' });
  assert.equal(refused.status, 409);
  await screenshot(page, 'play-ahead');
  await page.context().close();
});

test('on a phone a tap shapes', async () => {
  const page = await browser.open('play.html?world=living#at=300,200&to=300', PHONE);
  await ready(page);
  await still(page);
  await screenshot(page, 'play-phone');
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  const old = await page.locator('#life').getAttribute('data-generation');
  await page.touchscreen.tap(195, 560);
  await generation(page, Number(old) + 1);
  await page.tap('#help-button');
  await screenshot(page, 'play-phone-help');
  assert.ok(await page.locator('#help').isVisible());
  await page.context().close();
});

test('what others do is seen at once, on the map and in the game', async () => {
  const map = await browser.open('#world=living&zoom=13&at=0,0', CALM);
  await settled(map);
  const game = await browser.open('play.html?world=living#at=900,900&to=200', SMALL);
  await ready(game);
  await game.keyboard.press('f');
  const before = await still(game);
  const tile = map.waitForRequest((request) => /living@[0-9a-f]{32}\/web\/terrarium/.test(request.url()));
  const { generation: bred, revision } = await feed({ points: [[before.east, before.north]] });
  assert.ok((await tile).url().includes(revision), 'the map asks for the new revision');
  await settled(map);
  await generation(game, bred.number);
  await game.waitForFunction((revision) => document.querySelector('#play').dataset.revision === revision, revision);
  await screenshot(map, 'play-map');
  await map.context().close();
  await game.context().close();
});

test('an event comes soon after the answer', async (t) => {
  // A page of JSON names no picture for its tab, so that the browser asks for one of the common name.
  const page = await browser.open('healthz', CALM, ['/favicon.ico']);
  const times = await page.evaluate(async () => {
    const events = new EventSource('events?world=living');
    const heard = new Map();
    events.addEventListener('generation', ({ data }) => heard.set(JSON.parse(data).revision, performance.now()));
    await new Promise((resolve) => (events.onopen = resolve));
    const times = [];
    for (let i = 0; i < 50; i++) {
      const asked = performance.now();
      const response = await fetch('worlds/living/feedback', { method: 'POST', body: JSON.stringify({ heights: [60 + 5 * i] }) });
      const { revision } = await response.json();
      const answered = performance.now();
      while (!heard.has(revision)) await new Promise((resolve) => setTimeout(resolve, 0));
      times.push({ asked: answered - asked, heard: heard.get(revision) - asked, after: heard.get(revision) - answered });
    }
    events.close();
    return times;
  });
  const quantile = (name, q) => times.map((time) => time[name]).sort((a, b) => a - b)[Math.min(49, Math.ceil(50 * q) - 1)].toFixed(1);
  for (const name of ['asked', 'heard', 'after']) t.diagnostic(`${name}: p50 ${quantile(name, 0.5)} ms, p99 ${quantile(name, 0.99)} ms`);
  assert.equal(times.length, 50);
  await page.context().close();
});

test('a world without such ground is there to be walked in', async () => {
  const page = await browser.open('play.html?world=alps#at=114000,-88000&to=60', { viewport: { width: 900, height: 640 }, ...CALM });
  await ready(page);
  await still(page);
  await page.click('#help-close');
  await screenshot(page, 'play-alps');
  assert.ok(await page.locator('#life').isHidden());
  await page.context().close();
});

test('no page had errors', () => assert.deepEqual(browser.faults, []));
