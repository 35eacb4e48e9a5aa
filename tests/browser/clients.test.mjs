// The snippets of docs/clients.md, run as they stand: other people's clients draw the server's terrain, with the server's heights and without gaps.
import assert from 'node:assert/strict';
import { mkdir, writeFile } from 'node:fs/promises';
import { after, before, test } from 'node:test';
import { startBrowser } from './browser.mjs';
import { startServer } from './server.mjs';
import { startSite } from './site.mjs';

const OUT = new URL('out/', import.meta.url);
const WORLD = 'alps';
const SMALL = { viewport: { width: 320, height: 240 } };
/** Where gaps are looked for. */
const FINE = { viewport: { width: 480, height: 360 } };
/** Metres between the heights that terrarium can tell. */
const STEP = 1 / 256;
/** Metres round the equator of Web Mercator. */
const ROUND = 40075016.68557849;
/** Where heights are compared: in the middle of what the snippets show. */
const PLACES = [[1.2, 0.8], [1.2137, 0.7911], [1.1803, 0.8123], [1.2249, 0.8277], [1.1711, 0.7702]];

let server;
let site;
let exactSite;
let browser;

before(async () => {
  await mkdir(OUT, { recursive: true });
  server = await startServer();
  site = await startSite(server.url);
  exactSite = await startSite(server.url, unrounded);
  browser = await startBrowser(site.url, [], [server.url, exactSite.url]);
});

after(async () => {
  await browser?.close();
  await exactSite?.close();
  await site?.close();
  await server?.stop();
});

const query = (parameters) => server.get(`worlds/${WORLD}/elevation?${new URLSearchParams(parameters)}`);

async function raster(path, Type) {
  const response = await fetch(`${server.url}/worlds/${WORLD}/${path}`);
  assert.equal(response.status, 200, path);
  return new Type(await response.arrayBuffer());
}

/** Keeps a screenshot, and says that it shows something of many colours. */
async function assertPicture(name, picture) {
  await writeFile(new URL(`client-${name}.png`, OUT), picture);
  const { colours, deviation } = await browser.measure(picture);
  assert.ok(colours > 1000 && deviation > 15, `${name}: ${colours} colours, deviation ${deviation}`);
}

/** What a data URL holds. */
const bytes = (url) => Buffer.from(url.split(',')[1], 'base64');

const worst = (differences) => differences.reduce((a, b) => Math.max(a, Math.abs(b)), 0);

test('MapLibre GL JS', { timeout: 180_000 }, async (t) => {
  const page = await browser.open('maplibre-gl-js?shown=map', SMALL);
  const levels = new Set();
  page.on('response', (response) => {
    const level = /\/web\/terrarium\/(\d+)\//.exec(response.url())?.[1];
    if (level) levels.add(Number(level));
  });
  await page.waitForFunction(() => window.snippet?.map.loaded() && window.snippet.map.areTilesLoaded());
  const shown = await page.evaluate((places) => {
    const { map } = window.snippet;
    return places.map((place) => map.queryTerrainElevation(place) / map.getTerrain().exaggeration);
  }, PLACES);
  await assertPicture('maplibre', await page.screenshot());
  await page.context().close();

  // MapLibre draws lines between the samples of a tile, which lie in the middle of pixels.
  const expected = async ([lon, lat], z) => {
    const spacing = ROUND / 512 / 2 ** z;
    const { x, y } = await query({ lon, lat });
    const [column, row] = [(x + ROUND / 2) / spacing - 0.5, (ROUND / 2 - y) / spacing - 0.5];
    const [c, r] = [Math.floor(column), Math.floor(row)];
    const at = async (dc, dr) =>
      (await query({ x: (c + dc + 0.5) * spacing - ROUND / 2, y: ROUND / 2 - (r + dr + 0.5) * spacing, spacing })).elevation;
    const mix = (a, b, share) => a + (b - a) * share;
    return mix(mix(await at(0, 0), await at(1, 0), column - c), mix(await at(0, 1), await at(1, 1), column - c), row - r);
  };
  const found = await Promise.all([...levels].map(async (z) =>
    [worst(await Promise.all(PLACES.map(async (place, i) => shown[i] - (await expected(place, z))))), z]));
  const [difference, level] = found.sort(([a], [b]) => a - b)[0];
  t.diagnostic(`heights off by ${difference.toFixed(5)} m at most, from level ${level} of ${[...levels].sort((a, b) => a - b)}`);
  assert.ok(difference <= STEP, `the nearest level is ${level}, off by ${difference} m; shown are ${shown}`);
});

test('deck.gl', { timeout: 180_000 }, async (t) => {
  const page = await browser.open('deckgl?shown=deck', SMALL);
  await page.waitForFunction(() => window.snippet?.deck.props.layers[0].isLoaded);
  const tiles = await page.evaluate(() => {
    const meshes = window.snippet.deck.layerManager.getLayers().filter(({ props }) => props.mesh?.attributes && props.tile);
    return meshes.map(({ props: { tile, mesh } }) => ({
      ...tile.index,
      positions: [...mesh.attributes.POSITION.value],
      texture: [...mesh.attributes.TEXCOORD_0.value],
      skirt: mesh.header.boundingBox[0][2],
    }));
  });
  await assertPicture('deckgl', await page.screenshot());
  await page.context().close();

  const side = 256;
  let [vertices, difference] = [0, 0];
  for (const { x, y, z, positions, texture, skirt } of tiles.slice(0, 8)) {
    const heights = await raster(`web/r32/${z}/${x}/${y}.bin`, Float32Array);
    for (let i = 0; i < texture.length / 2; i += 1) {
      // Texture coordinates say which sample a vertex shows; the last row and column are shown twice.
      const at = (share) => Math.min(Math.round(share * side), side - 1);
      const [u, v, height] = [at(texture[2 * i]), at(texture[2 * i + 1]), positions[3 * i + 2]];
      if (height < skirt) continue;
      const off = Math.abs(height - heights[v * side + u]);
      // A skirt hangs under an edge, with the edge's texture.
      if (off > STEP && [0, side - 1].some((edge) => edge === u || edge === v)) continue;
      vertices += 1;
      difference = Math.max(difference, off);
    }
  }
  t.diagnostic(`${tiles.length} meshes; heights of ${vertices} vertices off by ${difference.toFixed(5)} m at most`);
  assert.ok(tiles.length >= 4 && vertices > 1000);
  assert.ok(difference <= STEP, `${difference}`);
});

/** Cesium without its own rounding of near tiles to 12 bits, which moves their edges by up to 0.6 m, every tile's otherwise. */
function unrounded(text) {
  return text.replace(/=(\w+)\.BITS12:(\w+)=\1\.NONE/, '=$1.NONE:$2=$1.NONE');
}

/** In the page: nothing but bare ground, white under one light, before magenta. */
function undress() {
  const { viewer, Cesium } = window.snippet;
  const { scene } = viewer;
  const { globe } = scene;
  viewer.useDefaultRenderLoop = false;
  viewer.imageryLayers.removeAll();
  for (const shown of [scene.skyBox, scene.skyAtmosphere, scene.sun, scene.moon]) shown.show = false;
  Object.assign(scene, { backgroundColor: Cesium.Color.MAGENTA, msaaSamples: 1, highDynamicRange: false });
  scene.fog.enabled = false;
  scene.postProcessStages.fxaa.enabled = false;
  scene.light = new Cesium.DirectionalLight({ direction: new Cesium.Cartesian3(-0.6, -0.3, -0.7) });
  Object.assign(globe, { baseColor: Cesium.Color.WHITE, enableLighting: true, showGroundAtmosphere: false, showWaterEffect: false, dynamicAtmosphereLighting: false });
}

/** In the page: draws a view until all of it has come; how much of the background shows, and what levels are drawn. */
async function draw({ place: [lon, lat, height], heading = 0, pitch, skirts }) {
  const { viewer: { scene, camera }, Cesium } = window.snippet;
  const { globe, canvas } = scene;
  globe.showSkirts = skirts;
  camera.setView({
    destination: Cesium.Cartesian3.fromDegrees(lon, lat, height),
    orientation: { heading: Cesium.Math.toRadians(heading), pitch: Cesium.Math.toRadians(pitch), roll: 0 },
  });
  const drawn = () => globe._surface._tilesToRender;
  const started = performance.now();
  for (let still = 0; still < 4;) {
    if (performance.now() - started > 50_000) throw new Error('Cesium has not finished in 50 s');
    scene.initializeFrame();
    scene.render();
    still = globe.tilesLoaded && drawn().length > 0 ? still + 1 : 0;
    await new Promise((resolve) => { setTimeout(resolve, 10); });
  }
  scene.render();
  const context = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d');
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  let background = 0;
  for (let i = 0; i < data.length; i += 4) background += data[i] > data[i + 1] + 12 && data[i + 2] > data[i + 1] + 12;
  const levels = [...new Set(drawn().map(({ level }) => level))].sort((a, b) => a - b);
  return { background, levels, tiles: drawn().length, picture: canvas.toDataURL('image/png') };
}

const VIEWS = [
  { name: 'far', place: [1.2, 0.8, 400_000], pitch: -90, even: true },
  { name: 'down', place: [1.2, 0.8, 40_000], pitch: -90, even: true },
  { name: 'near', place: [1.2, 0.8, 5_500], pitch: -90, even: true },
  { name: 'oblique', place: [1.2, 0.5, 12_000], pitch: -32 },
  { name: 'slant', place: [1.2, 0.5, 6_500], heading: 40, pitch: -35 },
];
/** The share of pixels that may show the background between tiles of different levels when nothing hangs under their edges. */
const BETWEEN_LEVELS = 1e-3;

async function drawViews(t, page, grid, views, skirts, name) {
  const pictures = {};
  for (const view of views) {
    const { picture, ...got } = await page.evaluate(draw, { ...view, skirts });
    pictures[view.name] = bytes(picture);
    await writeFile(new URL(`client-cesium-${grid}-${view.name}-${name}.png`, OUT), pictures[view.name]);
    t.diagnostic(`${grid} ${view.name}, ${name}: ${got.background} pixels of background; ${got.tiles} tiles of levels ${got.levels}`);
    assert.equal(got.levels.length === 1, view.even === true, `${view.name} shows levels ${got.levels}`);
    const allowed = skirts || view.even ? 0 : BETWEEN_LEVELS * 480 * 360;
    assert.ok(got.background <= allowed, `${grid} ${view.name}, ${name}: ${got.background} pixels of background`);
  }
  return pictures;
}

async function bareGlobe(at) {
  const page = await browser.open('cesium?shown=viewer,Cesium', FINE, [], at.url);
  await page.waitForFunction(() => window.snippet);
  await page.evaluate(undress);
  return page;
}

/** In the page: the other grid instead of the snippet's. */
async function takeGeo(url) {
  const { viewer, Cesium } = window.snippet;
  viewer.terrainProvider = await Cesium.CesiumTerrainProvider.fromUrl(url, { requestVertexNormals: true });
}

test('Cesium draws the snippet', { timeout: 180_000 }, async () => {
  const page = await browser.open('cesium?shown=viewer', SMALL);
  await page.waitForFunction(() => window.snippet);
  const picture = await page.evaluate(async () => {
    const { viewer } = window.snippet;
    const { scene } = viewer;
    // Its own loop leaves a slow machine no time for the tiles.
    viewer.useDefaultRenderLoop = false;
    for (let still = 0; still < 4;) {
      viewer.render();
      still = scene.globe.tilesLoaded && scene.globe._surface._tilesToRender.length > 0 ? still + 1 : 0;
      await new Promise((resolve) => { setTimeout(resolve, 50); });
    }
    return scene.canvas.toDataURL('image/png');
  });
  await assertPicture('cesium', bytes(picture));
  await page.context().close();
});

test('Cesium draws without gaps, with and without skirts', { timeout: 300_000 }, async (t) => {
  const grids = { web: VIEWS, geo: VIEWS.filter(({ name }) => ['down', 'oblique'].includes(name)) };
  const drawn = { skirts: {}, bare: {} };
  for (const [name, at] of [['bare', exactSite], ['skirts', site]]) {
    const page = await bareGlobe(at);
    for (const [grid, views] of Object.entries(grids)) {
      if (grid === 'geo') await page.evaluate(takeGeo, `${server.url}/worlds/${WORLD}/geo/quantized-mesh`);
      drawn[name][grid] = await drawViews(t, page, grid, views, name === 'skirts', name);
    }
    await page.context().close();
  }
  for (const [grid, views] of Object.entries(grids)) {
    for (const { name } of views) {
      const { difference } = await browser.measure(drawn.bare[grid][name], drawn.skirts[grid][name]);
      t.diagnostic(`${grid} ${name}: with and without skirts differ by ${difference.toFixed(4)} of 255`);
      assert.ok(difference < 0.25, `${name}: ${difference}`);
    }
  }
});

test('Cesium reads the heights of the server', { timeout: 180_000 }, async (t) => {
  const page = await browser.open('cesium?shown=viewer,Cesium', SMALL);
  await page.waitForFunction(() => window.snippet);
  const { levelZeroTolerance, edgeStep } = await server.get(`worlds/${WORLD}/web/quantized-mesh/layer.json`);
  const sample = (level, places) => page.evaluate(async ([z, points]) => {
    const { viewer: { terrainProvider }, Cesium } = window.snippet;
    const positions = points.map(([lon, lat]) => Cesium.Cartographic.fromDegrees(lon, lat));
    await (z === null ? Cesium.sampleTerrainMostDetailed(terrainProvider, positions) : Cesium.sampleTerrain(terrainProvider, z, positions));
    return positions.map(({ height }) => height);
  }, [level, places]);

  for (const z of [9, 12, 15]) {
    // The samples of the tile in the middle of the snippet's view, but for its edges.
    const [lon, lat] = PLACES[0];
    const radians = (lat * Math.PI) / 180;
    const x = Math.floor(((lon + 180) / 360) * 2 ** z);
    const y = Math.floor((0.5 - Math.asinh(Math.tan(radians)) / (2 * Math.PI)) * 2 ** z);
    const heights = await raster(`web/r32/${z}/${x}/${y}@65.bin`, Float32Array);
    const points = Array.from({ length: 49 }, (_, i) => [5 + 9 * (i % 7), 5 + 9 * Math.floor(i / 7)]);
    const places = points.map(([column, row]) => [
      ((x + column / 64) / 2 ** z) * 360 - 180,
      (Math.atan(Math.sinh(Math.PI * (1 - (2 * (y + row / 64)) / 2 ** z))) * 180) / Math.PI,
    ]);
    const got = await sample(z, places);
    const difference = worst(got.map((height, i) => height - heights[points[i][1] * 65 + points[i][0]]));
    const allowed = levelZeroTolerance / 2 ** z + edgeStep;
    t.diagnostic(`level ${z}: off by ${difference.toFixed(3)} m at most, ${allowed.toFixed(3)} are stated`);
    assert.ok(difference <= allowed, `level ${z}: ${difference} m`);
  }
  const deepest = await sample(null, PLACES);
  const there = await Promise.all(PLACES.map(async ([lon, lat]) => (await query({ lon, lat })).elevation));
  const difference = worst(deepest.map((height, i) => height - there[i]));
  t.diagnostic(`most detailed: off by ${difference.toFixed(4)} m at most`);
  assert.ok(difference <= levelZeroTolerance / 2 ** 24 + edgeStep, `${difference} m`);
  await page.context().close();
});

test('Cesium reads meshes without options', async () => {
  const page = await browser.open('cesium?shown=Cesium', SMALL);
  await page.waitForFunction(() => window.snippet);
  const fault = await page.evaluate(async (url) => {
    const provider = await window.snippet.Cesium.CesiumTerrainProvider.fromUrl(url);
    return provider.requestTileGeometry(0, 0, 0).then(() => '', ({ message }) => message);
  }, `${server.url}/worlds/${WORLD}/web/quantized-mesh`);
  await page.context().close();
  assert.equal(fault, '');
});

test('nothing went wrong on the way, in the pages or in the server\'s log', () => {
  assert.deepEqual(browser.faults, []);
  assert.deepEqual(server.log().split('\n').filter((line) => /\b(WARN|ERROR)\b|panicked/.test(line)), []);
});
