import { readFile, stat } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname } from 'node:path';
import { fileURLToPath } from 'node:url';

const DOCUMENT = new URL('../../docs/clients.md', import.meta.url);
/** The server as the documentation calls it. */
const DOCUMENTED = 'http://127.0.0.1:8080';

const MODULES = new URL('node_modules/', import.meta.url);
/** Where a page finds what it imports: by the first part of a path, a file or a folder of a package. */
const PLACES = {
  'maplibre-gl': 'maplibre-gl/dist/',
  cesium: 'cesium/Build/Cesium/',
  'deck.gl': 'deck.gl/dist.min.js',
  'terrain-worker.js': '@loaders.gl/terrain/dist/terrain-worker.js',
};

const TYPES = {
  '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css', '.json': 'application/json', '.wasm': 'application/wasm',
  '.png': 'image/png', '.jpg': 'image/jpeg', '.svg': 'image/svg+xml', '.xml': 'application/xml',
};

/** What a page needs before its snippet: head and the modules that the snippet imports by name. */
const HEADS = {
  'maplibre-gl-js': { imports: { 'maplibre-gl': '/maplibre-gl/maplibre-gl.mjs' }, head: '<link rel="stylesheet" href="/maplibre-gl/maplibre-gl.css">' },
  cesium: {
    imports: { cesium: '/cesium/index.js' },
    head: '<link rel="stylesheet" href="/cesium/Widgets/widgets.css"><script>window.CESIUM_BASE_URL = "/cesium/"</script>',
  },
  // The bundle is a plain script, which makes `deck` of the window; a bundler would import the package.
  deckgl: { imports: { 'deck.gl': '/deck.gl.mjs' }, head: '<script src="/deck.gl"></script>' },
};

/** The first block of code below a heading of docs/clients.md; headings are named as links to them are. */
export async function snippet(section, language = 'js') {
  const sections = (await readFile(DOCUMENT, 'utf8')).split(/^## /m).slice(1);
  const name = (text) => text.split('\n')[0].toLowerCase().replaceAll(' ', '-').replace(/[^a-z0-9-]/g, '');
  const found = sections.find((text) => name(text) === section);
  const code = new RegExp(`^\`\`\`${language}\\n([^]*?)^\`\`\`$`, 'm').exec(found ?? '')?.[1];
  if (code === undefined) throw new Error(`docs/clients.md has no ${language} below ## ${section}`);
  return code;
}

/** Ten frames a second at most: without a graphics card, more leave no time for what has to be drawn. */
const SLOW = `<script>{
  const frame = requestAnimationFrame;
  window.requestAnimationFrame = (run) => setTimeout(() => frame(run), 100);
  window.cancelAnimationFrame = clearTimeout;
}</script>`;

/** A page that runs a section's snippet against a server and then offers `shown`, names of its variables, to the test. */
async function page(section, server, shown) {
  const { imports, head } = HEADS[section];
  const code = (await snippet(section)).replaceAll(DOCUMENTED, server);
  return `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,"><style>html, body, #map { margin: 0; height: 100%; overflow: hidden }</style>
<script type="importmap">${JSON.stringify({ imports })}</script>${SLOW}${head}
<div id="map"></div>
<script type="module">
${code}
window.snippet = { ${shown} };
</script>`;
}

/** Serves `/SECTION?shown=NAME,…` and the packages that snippets import, edited if need be, on another origin than the server's. */
export async function startSite(server, edit = (text) => text) {
  const listener = createServer(async (request, response) => {
    const { pathname, searchParams } = new URL(request.url, 'http://site');
    const [, first, ...rest] = pathname.split('/');
    try {
      if (first in HEADS && rest.length === 0) {
        response.setHeader('Content-Type', 'text/html; charset=utf-8');
        response.end(await page(first, server, searchParams.get('shown')));
        return;
      }
      if (first === 'deck.gl.mjs') {
        response.setHeader('Content-Type', 'text/javascript');
        response.end('export const { Deck, TerrainLayer } = globalThis.deck;');
        return;
      }
      const file = fileURLToPath(new URL(PLACES[first] + rest.join('/'), MODULES));
      if (!(first in PLACES) || !(await stat(file)).isFile()) throw new Error(`no ${pathname}`);
      response.setHeader('Content-Type', TYPES[extname(file)] ?? 'application/octet-stream');
      response.end(extname(file) === '.js' ? edit(await readFile(file, 'utf8')) : await readFile(file));
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => listener.listen(0, '127.0.0.1', resolve));
  return {
    url: `http://127.0.0.1:${listener.address().port}`,
    close: () => new Promise((resolve) => {
      listener.close(resolve);
      listener.closeAllConnections();
    }),
  };
}
