import { defineConfig } from "vite";

// Built for the service that will serve it: nothing inline (its Content-Security-Policy forbids that),
// file names by content (so they may be kept for ever), no source maps (they would triple the binary).
export default defineConfig({
  build: {
    target: "es2022",
    outDir: "../build/web/dist",
    emptyOutDir: true,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    reportCompressedSize: false,
    chunkSizeWarningLimit: 2000,
    rollupOptions: { input: ["index.html", "docs.html"] },
  },
  server: {
    // `npm run dev` against a service started by ./dev run.
    proxy: { "/v1": "http://127.0.0.1:8080", "/openapi.json": "http://127.0.0.1:8080" },
  },
});
