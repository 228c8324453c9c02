// How fast and how large the playground is: playground.mjs SITE, with Chromium in STARBREAK_TEST_CHROMIUM or on
// PATH, after `cargo xtask web`. Medians, over the worker's messages.

import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { launch } from "../apps/web/page/test/browser.mjs";
import { serve } from "../apps/web/page/test/serve.mjs";

const N = 15;

const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];
const site = process.argv[2];
const files = readdirSync(join(site, "assets")).map((name) => join(site, "assets", name));
const code = [...files.filter((name) => /\.(js|wasm)$/.test(name)), join(site, "sw.js")].map((name) => readFileSync(name));
const size = (pack) => (code.map((bytes) => pack(bytes).length).reduce((a, b) => a + b) / 1e6).toFixed(2);
console.log(`module and scripts: ${size(brotliCompressSync)} MB by Brotli, ${size((bytes) => gzipSync(bytes, { level: 9 }))} MB by gzip; at most 1.5 was asked for`);

const server = await serve(site);
const address = `http://127.0.0.1:${server.address().port}/`;
const browser = await launch();

async function open() {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const tab = await context.newPage();
  const begin = performance.now();
  await tab.goto(address);
  await tab.waitForFunction(() => Number(document.querySelector(".page")?.dataset.shown) > 0);
  return { tab, context, took: performance.now() - begin };
}

const firsts = [];
for (let k = 0; k < N; k += 1) {
  const { context, took } = await open();
  firsts.push(took);
  await context.close();
}
say("first picture, nothing kept", firsts, 0, 1500);

const { tab } = await open();
/** Times, ms, of a question that is asked again and again. */
async function times(questions, bytes) {
  return tab.evaluate(
    async ([questions, nBytes]) => {
      const asset = performance.getEntriesByType("resource").find((entry) => /worker-.*\.js$/.test(entry.name)).name;
      const worker = new Worker(asset, { type: "module" });
      const ask = (words, bytes = new Uint8Array()) =>
        new Promise((done) => {
          worker.onmessage = (event) => done(event.data);
          worker.postMessage({ id: 1, words: JSON.stringify(words), bytes });
        });
      const street = await ask({ ask: "street" });
      const times = [];
      for (const question of questions) {
        const begin = performance.now();
        const said = await ask(question, nBytes ? street.bytes.slice() : undefined);
        const { trouble } = JSON.parse(said.words);
        if (trouble) throw new Error(trouble);
        times.push(performance.now() - begin);
      }
      worker.terminate();
      return times;
    },
    [questions, bytes],
  );
}
const star = (more) => ({ ask: "break", preset: "windshield-star", seed: 1, ...more });
const each = (of) => Array.from({ length: N }, (_, k) => of(k));
function say(what, all, skip, bound) {
  const ms = Math.round(median(all.slice(skip)));
  if (bound && ms > bound) process.exitCode = 1;
  console.log(`${what}: ${ms} ms${bound ? ` (at most ${bound}: ${ms > bound ? "FAIL" : "ok"})` : ""}`);
}
say("another stop of the lens, 1242 x 375", await times([star(), ...each((k) => star({ set: [`camera.f_number=${2 + 0.1 * k}`] }))]), 1, 50);
say("another light", await times([star(), ...each((k) => star({ set: [`optics.sun_elevation_deg=${10 + k}`] }))]), 1, 50);
say("a fresh star on the fast mesh", await times(each((k) => star({ seed: k, is_draft: true }))), 0, 250);
say("a fresh star on the default mesh", await times(each((k) => star({ seed: k }))), 0);
const frames = await times([star(), ...each(() => ({ ask: "frame", width_px: 1242, height_px: 375 }))], true);
say("the glass over a frame of the webcam, 1242 x 375", frames, 1, 40);
await browser.close();
server.close();
