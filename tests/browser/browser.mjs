import { mkdir } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const OUT = fileURLToPath(new URL('out/', import.meta.url));

/** One Chromium with software rendering, and a record of everything that goes wrong in its pages. They may ask `friends`, other origins, too. */
export async function startBrowser(url, more = [], friends = []) {
  await mkdir(OUT, { recursive: true });
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    headless: true,
    args: [
      '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
      '--ignore-gpu-blocklist', ...more,
    ],
  });
  const blank = await browser.newPage(); // where pictures are measured
  const faults = [];

  /** `tolerated` are texts of faults that the test provokes; `origin` is a friend's. */
  async function open(hash, options = {}, tolerated = [], origin = url) {
    const context = await browser.newContext({ viewport: { width: 900, height: 640 }, ...options });
    const page = await context.newPage();
    page.setDefaultTimeout(120_000);
    const note = (text) => {
      if (!tolerated.some((part) => text.includes(part))) faults.push(text);
    };
    page.on('console', (message) => {
      if (['error', 'warning'].includes(message.type())) note(`console: ${message.text()} ${message.location().url ?? ''}`.trim());
    });
    page.on('pageerror', (error) => note(`page error: ${error.stack}`));
    page.on('requestfailed', (request) => {
      const reason = request.failure()?.errorText;
      // Maps cancel tiles that have left the view, a closed gallery its pictures; a page that is left listens no longer. Nothing else may be cancelled.
      const cancelled = reason === 'net::ERR_ABORTED' && /\/web\/(terrarium|contours|features|relief|quantized-mesh)\/|\/preview\.png|\/events\?/.test(request.url());
      if (!cancelled) note(`failed: ${request.url()} ${reason}`);
    });
    page.on('response', (response) => {
      if (response.status() >= 400) note(`answer: ${response.status()} ${response.url()}`);
    });
    page.on('request', (request) => {
      if (!/^(data|blob):/.test(request.url()) && ![url, ...friends].some((origin) => request.url().startsWith(`${origin}/`))) note(`foreign: ${request.url()}`);
    });
    await page.goto(`${origin}/${hash}`);
    return page;
  }

  /** What a picture is like: how many colours, how strongly its brightness varies, how much it differs from another. */
  async function measure(picture, other = picture) {
    return blank.evaluate(async (images) => {
      const [a, b] = await Promise.all(images.map(async (base64) => {
        const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
        const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
        const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
        context.drawImage(bitmap, 0, 0);
        return context.getImageData(0, 0, bitmap.width, bitmap.height).data;
      }));
      const colours = new Set();
      let sum = 0, squares = 0, difference = 0;
      for (let i = 0; i < a.length; i += 4) {
        colours.add((a[i] << 16) | (a[i + 1] << 8) | a[i + 2]);
        const grey = (a[i] + a[i + 1] + a[i + 2]) / 3;
        sum += grey;
        squares += grey * grey;
        difference += Math.abs(grey - (b[i] + b[i + 1] + b[i + 2]) / 3);
      }
      const pixels = a.length / 4;
      const mean = sum / pixels;
      return { colours: colours.size, deviation: Math.sqrt(squares / pixels - mean * mean), difference: difference / pixels };
    }, [picture.toString('base64'), other.toString('base64')]);
  }

  return {
    open,
    measure,
    faults,
    close: () => browser.close(),
  };
}

/** Waits until the map has drawn all it was asked for. */
export async function settled(page) {
  await page.waitForFunction(() =>
    !document.querySelector('#stage').hasAttribute('aria-busy') && document.querySelector('#readout').dataset.elevation);
}

/** The middle of the map, where nothing lies over it; the whole page is kept in out/ to be looked at. */
export async function picture(page, name) {
  await page.screenshot({ path: `${OUT}${name}.png` });
  const { x, y, width, height } = await page.locator('#map').boundingBox();
  return page.screenshot({
    clip: { x: x + width * 0.35, y: y + height * 0.2, width: width * 0.5, height: height * 0.6 },
  });
}

/** What the readout says, once it speaks of the pointer at this pixel of the page. */
export async function pointAt(page, x, y) {
  const before = await page.locator('#readout').evaluate(({ dataset }) => `${dataset.where} ${dataset.x} ${dataset.y}`);
  await page.mouse.move(x, y);
  const handle = await page.waitForFunction((old) => {
    const { where, x, y, elevation, zoom, spacing } = document.querySelector('#readout').dataset;
    if (where !== 'pointer' || `${where} ${x} ${y}` === old || elevation === '') return undefined;
    return { x: +x, y: +y, elevation: +elevation, zoom: +zoom, spacing: +spacing };
  }, before);
  return handle.jsonValue();
}
