import { createHash } from "node:crypto";
import { join } from "node:path";
import { defineConfig, type Plugin } from "vite";

/** Lists the page's own files in its service worker, which keeps them for a visit without a network; the module of
 * detectors is kept by those who use it. */
function listFiles(): Plugin {
  return {
    name: "list-files",
    apply: "build",
    enforce: "post",
    generateBundle(_, bundle) {
      const files = Object.keys(bundle).filter((name) => name !== "sw.js" && !name.includes("detector"));
      const worker = bundle["sw.js"];
      if (worker?.type === "chunk") {
        const html = bundle["index.html"];
        if (html?.type !== "asset") throw new Error("there is no index.html to keep");
        // Names of other files hold what is in them.
        const version = createHash("sha256").update(files.sort().join(" ")).update(html.source).digest("hex");
        worker.code = worker.code
          .replace("__FILES__", JSON.stringify(["./", ...files]))
          .replace("__VERSION__", JSON.stringify(version.slice(0, 16)));
      }
    },
  };
}

/** The folder of the modules in Rust. */
const wasm = process.env.STARBREAK_WASM;
if (!wasm) throw new Error("STARBREAK_WASM is not set; build by cargo xtask web");

export default defineConfig({
  resolve: {
    alias: [
      { find: /^glass\.wasm/, replacement: join(wasm, "starbreak_web.wasm") },
      { find: /^detector\.wasm/, replacement: join(wasm, "starbreak_web_detector.wasm") },
    ],
  },
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
