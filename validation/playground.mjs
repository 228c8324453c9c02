// How fast and how large the playground is: playground.mjs SITE, with Chromium in STARBREAK_TEST_CHROMIUM or on
// PATH, after `cargo xtask web`. Medians, over the worker's messages.

import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { launch } from "../apps/web/page/test/browser.mjs";
import { serve } from "../apps/web/page/test/serve.mjs";

const N = 15;

const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];
const site = process.argv[2];
// The module of detectors comes with a model.
const files = readdirSync(join(site, "assets")).filter((name) => !name.includes("detector")).map((name) => join(site, "assets", name));
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
      const worker = new Worker(asset, { type: "module", name: "glass" });
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

// The webcam as a whole: a clip in the place of the camera, and how often the page shows another moment of it.
const folder = mkdtempSync(join(tmpdir(), "playground-"));
const clip = join(folder, "camera.y4m");
const [width, height, nFrames] = [1242, 376, 30];
const picture = (k) => Buffer.concat([Buffer.from("FRAME\n"), Buffer.alloc((width * height * 3) / 2, 60 + 4 * k)]);
writeFileSync(clip, Buffer.concat([Buffer.from(`YUV4MPEG2 W${width} H${height} F60:1 Ip A1:1 C420jpeg\n`), ...Array.from({ length: nFrames }, (_, k) => picture(k))]));
const camera = await launch(["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream", `--use-file-for-fake-video-capture=${clip}`]);
const viewer = await (await camera.newContext({ viewport: { width: 1440, height: 900 } })).newPage();
await viewer.addInitScript(() => {
  window.nShown = 0;
  let last = 0;
  const put = CanvasRenderingContext2D.prototype.putImageData;
  CanvasRenderingContext2D.prototype.putImageData = function (...words) {
    // A corner without cracks, which tells two moments of the clip apart.
    if (words[0].data[0] !== last) window.nShown += 1;
    last = words[0].data[0];
    return put.apply(this, words);
  };
});
await viewer.goto(address);
await viewer.waitForFunction(() => Number(document.querySelector(".page")?.dataset.shown) > 0);
await viewer.getByRole("button", { name: "Webcam" }).click();
await viewer.waitForFunction(() => document.querySelector("canvas").height === 376);
await viewer.waitForTimeout(2000);
const [from, n0] = [performance.now(), await viewer.evaluate(() => window.nShown)];
await viewer.waitForTimeout(5000);
const perS = ((await viewer.evaluate(() => window.nShown)) - n0) / ((performance.now() - from) / 1000);
if (perS < 25) process.exitCode = 1;
console.log(`the webcam at ${width} x ${height}, from camera to screen: ${perS.toFixed(0)} frames/s (at least 25: ${perS < 25 ? "FAIL" : "ok"})`);
await camera.close();
rmSync(folder, { recursive: true });
server.close();
