import { defineConfig } from "vite";

const pages = ["index", "results", "subject", "archive"];

export default defineConfig({
  base: "/",
  publicDir: "public",
  build: {
    target: "es2022",
    emptyOutDir: true,
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    reportCompressedSize: false,
    rollupOptions: { input: Object.fromEntries(pages.map((page) => [page, `${page}.html`])) },
  },
});
