import { defineConfig, type Plugin } from "vite";

/** Lists the page's own files in its service worker, which keeps them for a visit without a network. */
function listFiles(): Plugin {
  return {
    name: "list-files",
    apply: "build",
    generateBundle(_, bundle) {
      const files = Object.keys(bundle).filter((name) => name !== "sw.js");
      const worker = bundle["sw.js"];
      if (worker?.type === "chunk") {
        worker.code = worker.code.replace("__FILES__", JSON.stringify(["./", ...files].sort()));
      }
    },
  };
}

const wasm = process.env.STARBREAK_WASM;
if (!wasm) throw new Error("STARBREAK_WASM is not set; build by cargo xtask web");

export default defineConfig({
  resolve: { alias: [{ find: /^starbreak\.wasm/, replacement: wasm }] },
  base: "./",
  // Everything is a file of the page: its rules forbid data in addresses.
  build: {
    assetsInlineLimit: 0,
    target: "es2022",
    modulePreload: { polyfill: false },
    rollupOptions: {
      input: { index: "index.html", sw: "src/sw.ts" },
      output: {
        entryFileNames: (chunk) => (chunk.name === "sw" ? "sw.js" : "assets/[name]-[hash].js"),
      },
    },
  },
  worker: { format: "es" },
  plugins: [listFiles()],
});
