import { defineConfig } from 'vite';

export default defineConfig({
  // Relative, so that the page works under any base path.
  base: './',
  build: {
    target: 'es2022',
    chunkSizeWarningLimit: 1500,
    rollupOptions: {
      // The map, and the game with a library of its own that the map does not load.
      input: ['index.html', 'play.html'],
      output: {
        // MapLibre's worker is an .mjs file; as .js every server knows its media type.
        assetFileNames: (asset) =>
          asset.names[0]?.endsWith('.mjs') ? 'assets/[name]-[hash].js' : 'assets/[name]-[hash][extname]',
      },
    },
  },
  // `npm run dev` beside a running `terrane serve`.
  server: {
    proxy: Object.fromEntries(
      ['/catalog', '/worlds', '/programmes', '/breeding', '/jobs', '/rasters', '/events'].map((path) => [path, process.env['TERRANE_URL'] ?? 'http://127.0.0.1:8080']),
    ),
  },
});
