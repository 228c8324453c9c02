// The playground in a browser: playground.mjs SITE STARBREAK, with Chromium in STARBREAK_TEST_CHROMIUM or on PATH.
// Ends with a line `test result: …` as cargo's tests do.

import { AsyncLocalStorage } from "node:async_hooks";
import { execFile } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { promisify } from "node:util";
import { launch } from "./browser.mjs";
import { serve } from "./serve.mjs";

const [site, starbreak] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const model = join(import.meta.dirname, "spot.onnx");
const scratch = mkdtempSync(join(tmpdir(), "playground-"));
const server = await serve(site);
const start = `http://127.0.0.1:${server.address().port}/`;
const browser = await launch(["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"]);

/** What the test that runs has opened. */
const contextsOfTest = new AsyncLocalStorage();
const complaints = [];
const strangers = [];

/** A page of its own, with everything that it complains of and asks for noted. */
async function open(options = {}, address = "") {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true, ...options });
  contextsOfTest.getStore().push(context);
  const page = await context.newPage();
  page.setDefaultTimeout(30_000);
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(String(error)));
  context.on("request", (request) => {
    if (!request.url().startsWith(start) && !request.url().startsWith("blob:")) strangers.push(request.url());
  });
  await page.goto(start + address);
  await shown(page, 0);
  await page.waitForTimeout(100);
  return page;
}

const nShown = async (page) => Number(await page.locator(".page").getAttribute("data-shown"));
/** Waits until more than so many breaks were shown, and no other is under way. */
const shown = (page, before) =>
  page.waitForFunction((before) => Number(document.querySelector(".page")?.dataset.shown) > before, before);
/** Does something that breaks the glass, and waits for it. */
async function after(page, act) {
  const before = await nShown(page);
  await act();
  await shown(page, before);
  await page.waitForTimeout(50);
}
const view = (page, value) => page.getByLabel("View").selectOption(value);
/** The canvas, as bytes in base 64. */
const pixels = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let text = "";
    for (let at = 0; at < data.length; at += 0x8000) text += String.fromCharCode(...data.subarray(at, at + 0x8000));
    return btoa(text);
  });
const bytesOf = async (page) => Buffer.from(await pixels(page), "base64");
async function download(page, name) {
  const [file] = await Promise.all([
    page.waitForEvent("download"),
    page.getByLabel("Download").getByRole("button", { name, exact: true }).click(),
  ]);
  return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
}
/** Pixels of a PNG file, by the browser. */
const decode = (page, png) =>
  page
    .evaluate(async (text) => {
      const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes]), { colorSpaceConversion: "none" });
      const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
      const context = canvas.getContext("2d");
      context.drawImage(bitmap, 0, 0);
      const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
      let out = "";
      for (let at = 0; at < data.length; at += 0x8000) out += String.fromCharCode(...data.subarray(at, at + 0x8000));
      return btoa(out);
    }, png.toString("base64"))
    .then((text) => Buffer.from(text, "base64"));
const linear = (code) => (code <= 10.31475 ? code / 255 / 12.92 : ((code / 255 + 0.055) / 1.055) ** 2.4);
const clickAt = async (page, x, y) => {
  await page.locator("canvas").scrollIntoViewIfNeeded();
  const box = await page.locator("canvas").boundingBox();
  await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
};
function must(isSo, what) {
  if (!isSo) throw new Error(what);
}
/** What the command says, of an error where it fails. */
async function command(...args) {
  try {
    return (await promisify(execFile)(starbreak, args, { cwd: scratch })).stdout;
  } catch (error) {
    return error.stderr;
  }
}

await command("demo", "-o", "demo");
copyFileSync(join(scratch, "demo", "scene.png"), join(scratch, "scene.png"));

const tests = {
  async a_click_breaks_the_glass_there_and_nothing_outside_the_region() {
    const page = await open({}, "#preset=windshield-star&severity=3&seed=5");
    await after(page, () => clickAt(page, 0.25, 0.5));
    const damaged = await bytesOf(page);
    await view(page, "clean");
    const clean = await bytesOf(page);
    const region = await decode(page, (await download(page, "Region mask")).bytes);
    const recipe = (await download(page, "Recipe")).bytes.toString();
    const threshold = Number(/^region_threshold = (.*)$/m.exec(recipe)[1]);
    let [sumX, n, worst] = [0, 0, 0];
    for (let at = 0; at < clean.length; at += 4) {
      if (region[at] > 0) {
        sumX += (at / 4) % 1242;
        n += 1;
      } else {
        for (const c of [0, 1, 2]) worst = Math.max(worst, Math.abs(linear(damaged[at + c]) - linear(clean[at + c])));
      }
    }
    must(n > 200, `${n} pixels in the region`);
    must(Math.abs(sumX / n / 1242 - 0.25) < 0.15, `the middle of the region is at ${sumX / n / 1242} of the width`);
    // One code of 255 above is what rounding adds.
    must(worst < threshold + 0.01, `outside the region linear light changes by ${worst}, not less than ${threshold}`);
    must(/^position = \[0\.25\d*, 0\.5\d*\]$/m.test(recipe), "the recipe has the hit");
  },

  async several_hits_add_up_and_are_cleared() {
    const page = await open({}, "#preset=windshield-star&severity=1&seed=5");
    const share = async () => Number((await page.locator(".figures dd").first().textContent()).split(" ")[0]);
    await after(page, () => clickAt(page, 0.2, 0.3));
    const one = await share();
    await after(page, () => clickAt(page, 0.7, 0.6));
    const two = await share();
    must(two > one, `two hits affect ${two} %, one ${one} %`);
    must(await page.getByText("2 hits", { exact: true }).isVisible(), "they are counted");
    await after(page, () => page.getByRole("button", { name: "Undo hit" }).click());
    must((await share()) === one, "one hit again");
    await after(page, () => page.getByRole("button", { name: "Clear hits" }).click());
    must(!page.url().includes("hit="), "none in the address");
  },

  async a_drag_gives_speed_and_direction() {
    const page = await open();
    const box = await page.locator("canvas").boundingBox();
    await page.mouse.move(box.x + 0.3 * box.width, box.y + 0.5 * box.height);
    await after(page, async () => {
      await page.mouse.down();
      await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height, { steps: 4 });
      await page.mouse.up();
      await page.waitForFunction(() => location.hash.includes("hit="));
    });
    const hit = new URLSearchParams(new URL(page.url()).hash.slice(1)).get("hit").split(",").map(Number);
    must(hit.length === 4 && hit[2] === 0 && Math.abs(hit[3] - 24) < 1, `to the right at 24 m/s: ${hit}`);
  },

  async keys_throw_a_stone() {
    const page = await open();
    await page.locator("canvas").focus();
    for (const key of ["ArrowRight", "ArrowRight", "ArrowUp"]) await page.keyboard.press(key);
    await after(page, () => page.keyboard.press("Enter"));
    must(page.url().includes("hit=0.54%2C0.46"), page.url());
  },

  async each_preset_and_severity_shows_something() {
    const page = await open();
    const presets = await page.locator("input[name=preset]").evaluateAll((all) => all.map((one) => one.value));
    must(presets.length === 50, `${presets.length} presets`);
    for (const preset of presets) {
      const isGlass = /cover|windshield|paper/.test(preset);
      for (const severity of isGlass ? [1, 2, 3, 4, 5] : [1, 5]) {
        const address = `#preset=${preset}&severity=${severity}${isGlass ? "&hit=0.5,0.45" : ""}&seed=2`;
        await after(page, () => page.evaluate((address) => (location.hash = address), address));
        const words = await page.locator(".figures dd").first().textContent();
        must(!(await page.locator(".trouble").textContent()), `${address}: ${await page.locator(".trouble").textContent()}`);
        // Of half a million pixels, one in a million is defective, or has a wrong bit, where there is one.
        const isRare = (/pixels|bit-errors/.test(preset) && severity === 1) || preset === "blank-frames";
        must(isRare || Number(words.split(" ")[0]) > 0, `${address}: ${words}`);
      }
    }
  },

  async a_link_shows_the_same_pixels() {
    const page = await open();
    await after(page, () => page.getByLabel("Camera").selectOption("dashcam"));
    await after(page, () => clickAt(page, 0.6, 0.3));
    await after(page, async () => {
      await page.getByLabel("f-number").first().fill("4");
      await page.keyboard.press("Tab");
    });
    const there = await open({}, page.url().slice(start.length));
    must((await pixels(page)) === (await pixels(there)), "other pixels");
    must((await there.getByLabel("f-number").first().inputValue()) === "4", "f-number");
  },

  // WebAssembly beside the processor of this machine. `cargo xtask processors` compares golden digests on it, too.
  async two_dozen_recipes_give_the_pixels_of_the_command() {
    const page = await open();
    await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
    const addresses = [
      "preset=windshield-star&severity=4&seed=1",
      "preset=windshield-bullseye&hit=0.3,0.4&seed=2",
      "preset=windshield-combination&severity=5&hit=0.7,0.5&seed=3",
      "preset=windshield-long-crack&camera=dashcam&seed=4",
      "preset=windshield-spiderweb&severity=2&hit=0.5,0.5,30,40&seed=5",
      "preset=windshield-gravel&severity=3&seed=6",
      "preset=tempered-cover&hit=0.4,0.6&seed=7",
      "preset=lens-cover-shattered&set=camera.f_number=4&seed=8",
      "preset=paper&severity=4&seed=9",
      "preset=windshield-star&severity=2&hit=0.2,0.3&hit=0.6,0.5,90,25&seed=10",
      "preset=noise&severity=2&hit=0.5,0.5&hit=0.6,0.6&seed=11",
      "preset=windshield-spiderweb&set=exposure.ev=-1&set=noise.white_e=300&hit=0.4,0.5&seed=12",
      "preset=windshield-hail&severity=2&seed=14",
      "preset=lens-cover-star&seed=15",
      "preset=paper&set=fracture.neighbourhood=mesh-edges&set=fracture.branches=2&set=camera.focus_distance_m=short&seed=16",
      "preset=rain&severity=4&seed=17",
      "preset=frosted&severity=2&seed=18",
      "preset=fogged&severity=4&seed=19",
      "preset=muddy&set=dust.coverage_percent=5&seed=20",
      "preset=greasy&seed=21",
      "preset=night-drive&seed=22",
      "preset=distortion&seed=23",
      "preset=compression&set=spots.count=9&set=isp.unsharp=1&set=isp.tone=0.5&set=link.bit_error_rate=0.001&seed=13",
    ];
    for (const address of addresses) {
      await after(page, () => page.evaluate((address) => (location.hash = address), address));
      await page.getByRole("button", { name: "Copy command" }).click();
      await page.getByText("Copied: Command").waitFor();
      const words = await page.evaluate(() => navigator.clipboard.readText());
      const recipe = await download(page, "Recipe");
      writeFileSync(join(scratch, recipe.name), recipe.bytes);
      const args = words.replace(/^starbreak /, "").match(/'[^']*'|\S+/g).map((word) => word.replaceAll("'", ""));
      const said = await command(...args, "--replace");
      const file = join(scratch, "out", "scene.png");
      must(existsSync(file), `${words}: ${said}`);
      const ours = await decode(page, readFileSync(file));
      must(ours.equals(await decode(page, (await download(page, "Picture")).bytes)), `${words}: other pixels in the file`);
      must(ours.equals(await bytesOf(page)), `${words}: other pixels on the page`);
      rmSync(join(scratch, "out"), { recursive: true });
    }
  },

  async faults_are_shown_alone_and_beside_cracks() {
    const page = await open({}, "#preset=noise&severity=4");
    const figures = () => page.locator(".figures").textContent();
    const trouble = () => page.locator(".trouble").textContent();
    must((await figures()).includes("green at 18 %5"), await figures());
    must(!(await figures()).includes("a point of the glass"), "there is no glass");
    must(await page.getByLabel("white, electrons").first().isVisible(), "its parameters");
    await clickAt(page, 0.5, 0.5);
    await page.waitForFunction(() => document.querySelector(".trouble").textContent.includes("nothing breaks"));
    must(!page.url().includes("hit="), "no hit is counted");
    await view(page, "region");
    await page.waitForTimeout(300);
    must((await trouble()) === "", await trouble());
    must(await page.locator("option[value=stress]").isDisabled(), "there are no cracks");
    await after(page, () => page.locator("input[name=preset][value=windshield-spiderweb]").dispatchEvent("click"));
    const clean = await figures();
    await after(page, () => page.locator("fieldset", { hasText: "Add" }).getByRole("button", { name: "Noise" }).click());
    must((await figures()).includes("green at 18 %10") && !clean.includes("green at 18 %"), await figures());
    must(page.url().includes("noise.white_e"), page.url());
  },

  async a_photo_is_taken_and_a_broken_file_is_refused_as_by_the_command() {
    const page = await open();
    const png = (await download(page, "Crack mask")).bytes;
    const choose = (name, bytes) => page.getByLabel("Open a photo").setInputFiles({ name, mimeType: "image/png", buffer: bytes });
    await after(page, () => choose("mine.png", png));
    must((await download(page, "Picture")).name === "mine.damaged.png", "its name");
    const cut = png.subarray(0, png.length - 40);
    writeFileSync(join(scratch, "cut.png"), cut);
    const said = await command("crack", "cut.png", "-o", "cut");
    await choose("cut.png", cut);
    await page.waitForFunction(() => document.querySelector(".trouble").textContent !== "");
    const words = await page.locator(".trouble").textContent();
    must(words.includes("cut.png") && said.includes(words), `${words}, the command: ${said}`);
  },

  async a_wrong_value_is_refused_as_by_the_command_and_the_picture_stays() {
    const page = await open();
    const [before, n] = [await pixels(page), await nShown(page)];
    await page.getByLabel("f-number").first().fill("0");
    await page.keyboard.press("Tab");
    await page.waitForFunction(() => document.querySelector(".trouble").textContent !== "");
    const words = await page.locator(".trouble").textContent();
    // What was good before is shown again.
    await shown(page, n);
    const said = await command("crack", "scene.png", "--set", "camera.f_number=0", "-o", "wrong");
    must(said.includes(words), `${words}, the command: ${said}`);
    must(before === (await pixels(page)), "the picture changed");
    must(!page.url().includes("f_number"), "what was refused is not in the address");
    await after(page, () => clickAt(page, 0.4, 0.4));
    must(!(await page.locator(".trouble").textContent()), "it goes on");
  },

  async a_bad_address_says_so_and_shows_the_start() {
    const bads = {
      "#preset=nope": ["nope"],
      "#set=camera.nope=3": ["camera.nope"],
      "#set=x&hit=a,b&severity=9&seed=-1&speed=3": ["set=x ", "hit=a,b ", "severity=9 ", "seed=-1 ", "speed "],
      "#hit=5,-3": ["impact.position"],
    };
    for (const [bad, parts] of Object.entries(bads)) {
      const page = await open({}, bad);
      await page.waitForTimeout(200);
      const words = await page.locator(".trouble").textContent();
      for (const part of parts) must(words.includes(part), `${bad}: nothing is said of ${part}: ${words}`);
      must(page.url().includes("preset=windshield-spiderweb&severity=3&seed=1"), `${bad}: ${page.url()}`);
      await page.context().close();
    }
  },

  async growth_plays_and_ends_as_the_whole() {
    const page = await open();
    const whole = await pixels(page);
    const slider = page.getByLabel("Growth", { exact: true });
    await slider.fill("0");
    await page.waitForFunction(() => document.querySelector(".time").textContent !== "");
    await view(page, "damaged");
    const none = await pixels(page);
    await slider.fill("0.5");
    await page.waitForFunction(() => !/^0 /.test(document.querySelector(".time").textContent));
    await page.waitForTimeout(200);
    const half = await pixels(page);
    must(none !== half && half !== whole, "it grows");
    await page.getByRole("button", { name: "Play growth" }).click();
    await page.getByRole("button", { name: "Play growth" }).waitFor();
    must((await pixels(page)) === whole, "in the end it is the whole");
  },

  async every_view_differs_and_masks_and_networks_are_files() {
    const page = await open();
    const looks = await page.getByLabel("View").locator("option").evaluateAll((all) => all.map((one) => one.value));
    const seen = new Set();
    for (const look of looks) {
      await view(page, look);
      // A view that is as another stays so, however slow the machine.
      let shown = "";
      for (let tries = 0; tries < 20 && (shown === "" || seen.has(shown)); tries++) {
        await page.waitForTimeout(250);
        shown = await pixels(page);
      }
      seen.add(shown);
    }
    must(seen.size === looks.length, `${seen.size} of ${looks.length} views differ`);
    const network = JSON.parse((await download(page, "Network")).bytes);
    must(network.segments.from.length > 10, "a network");
    must((await download(page, "Drawing")).bytes.toString().includes("<svg"), "a drawing");
  },

  async the_webcam_is_seen_through_the_glass() {
    const page = await open();
    await after(page, () => page.getByRole("button", { name: "Webcam" }).click());
    await page.waitForTimeout(500);
    const [first] = [await pixels(page), await page.waitForTimeout(400)];
    must(first !== (await pixels(page)), "it moves");
    await view(page, "clean");
    await page.waitForTimeout(300);
    const [clean] = [await pixels(page), await page.waitForTimeout(400)];
    must(clean !== (await pixels(page)), "the clean view moves with it");
    must(!(await page.locator(".trouble").textContent()), "no trouble");
    const name = () => page.locator("canvas").getAttribute("aria-label");
    must((await name()).startsWith("webcam.png"), await name());
    // A photo takes its place.
    await page.getByRole("button", { name: "The street" }).click();
    await page.getByRole("button", { name: "Webcam", exact: true }).waitFor();
    await view(page, "damaged");
    await page.waitForFunction(() => document.querySelector("canvas").height === 375);
    must(!(await page.locator(".trouble").textContent()), "no trouble then, either");
  },

  async a_model_finds_the_boxes_that_the_command_finds() {
    const page = await open({}, "#preset=windshield-spiderweb&severity=5&hit=0.5,0.5&seed=4");
    await page.getByLabel("Open a model").setInputFiles(model);
    await page.locator(".found[aria-busy=false]").waitFor();
    await page.getByLabel("Score ≥").fill("0.05");
    const shown = () =>
      page.locator(".marks:not(.were) div").evaluateAll((all) =>
        all.map(({ style, textContent }) => [textContent, style.left, style.top, style.width, style.height].join(" ")),
      );
    mkdirSync(join(scratch, "frames"));
    for (const [k, name] of ["Clean picture", "Picture"].entries()) {
      writeFileSync(join(scratch, "frames", `${k}.png`), (await download(page, name)).bytes);
    }
    const said = await command("detect", "clip:frames", "--model", model, "-o", "boxes.json");
    must(existsSync(join(scratch, "boxes.json")), said);
    const names = ["", "red", "always"];
    const expected = JSON.parse(readFileSync(join(scratch, "boxes.json"))).map(({ image_id, category_id, score, bbox }) => {
      const [x, y, w, h] = bbox;
      const share = (value, of) => Math.round((value / of) * 1e4);
      return [image_id, names[category_id], score.toFixed(2), share(x, 1242), share(y, 375), share(w, 1242), share(h, 375)].join(" ");
    });
    must(expected.length === 4, `${expected.length} boxes in both pictures`);
    for (const [k, look] of ["clean", "damaged"].entries()) {
      await view(page, look);
      const found = (await shown()).map((text) => text.replace(/[\d.-]+(e-\d+)?%/g, (part) => Math.round(Number.parseFloat(part) * 100)));
      const wanted = expected.filter((text) => text.startsWith(`${k + 1} `)).map((text) => text.slice(2));
      must(found.join("; ") === wanted.join("; "), `${look}: ${found.join("; ")}, the command: ${wanted.join("; ")}`);
    }
    const scores = expected.map((text) => text.split(" ")).filter(([, name]) => name === "red");
    must(scores[0][2] !== scores[1][2], "the glass changes what the model sees");
    must((await page.locator(".found tbody tr").last().textContent()) === "all22", "they are counted");
    // Growth ends where it was.
    const n = await page.locator(".marks:not(.were) div").count();
    const slider = page.getByLabel("Growth", { exact: true });
    await slider.fill("0.4");
    await page.waitForFunction(() => !document.querySelector(".marks div"));
    await slider.fill("1");
    await page.waitForFunction((n) => document.querySelectorAll(".marks:not(.were) div").length === n, n);
    await page.getByRole("button", { name: "Remove the model" }).click();
    await page.waitForFunction(() => !document.querySelector(".marks div"));
  },

  async a_broken_model_is_refused_as_by_the_command() {
    const page = await open();
    const cut = readFileSync(model).subarray(0, 60);
    writeFileSync(join(scratch, "cut.onnx"), cut);
    mkdirSync(join(scratch, "one"), { recursive: true });
    writeFileSync(join(scratch, "one", "0.png"), (await download(page, "Crack mask")).bytes);
    const said = await command("detect", "clip:one", "--model", "cut.onnx", "-o", "cut.json");
    await page.getByLabel("Open a model").setInputFiles({ name: "cut.onnx", mimeType: "", buffer: cut });
    await page.waitForFunction(() => document.querySelector(".trouble").textContent !== "");
    const words = await page.locator(".trouble").textContent();
    must(words.includes("cut.onnx") && said.includes(words), `${words}, the command: ${said}`);
    // A good model stays where another is refused, and gives way to a good one.
    await page.getByLabel("Open a model").setInputFiles(model);
    await page.locator(".found[aria-busy=false]").waitFor();
    await page.getByLabel("Open a model").setInputFiles({ name: "cut.onnx", mimeType: "", buffer: cut });
    await page.waitForTimeout(300);
    must(await page.getByText("spot.onnx, read as yolov8").isVisible(), "it stays");
    // One that stops its module is gone, and the page goes on.
    const names = await Promise.all(page.workers().map((worker) => worker.evaluate(() => self.name)));
    await page.workers()[names.indexOf("detector")].evaluate(() => {
      TextDecoder.prototype.decode = () => {
        throw new Error("unreachable");
      };
    });
    await after(page, () => clickAt(page, 0.5, 0.5));
    await page.waitForFunction(() => document.querySelector(".trouble").textContent.includes("run this model by the command"));
    must((await page.locator(".found").count()) === 0, "the model is gone");
  },

  async a_module_that_stops_is_started_anew_with_the_picture() {
    const page = await open();
    const png = (await download(page, "Crack mask")).bytes;
    const photo = { name: "mine.png", mimeType: "image/png", buffer: png };
    await after(page, () => page.getByLabel("Open a photo").setInputFiles(photo));
    await page.workers()[0].evaluate(() => {
      TextDecoder.prototype.decode = () => {
        throw new Error("out of memory");
      };
    });
    const before = await pixels(page);
    await page.getByLabel("Seed").fill("77");
    await page.keyboard.press("Tab");
    await page.waitForFunction(() => document.querySelector(".trouble").textContent.includes("out of memory"));
    await page.waitForTimeout(1500);
    must((await download(page, "Picture")).name === "mine.damaged.png", "the picture is there");
    must(before === (await pixels(page)), "as it was");
  },

  async it_opens_without_a_network_after_the_first_visit() {
    const page = await open();
    await page.evaluate(() => navigator.serviceWorker.ready);
    await page.waitForFunction(() => navigator.serviceWorker.controller !== null);
    await page.getByLabel("Open a model").setInputFiles(model);
    await page.locator(".found[aria-busy=false]").waitFor();
    await page.waitForTimeout(300);
    await page.context().setOffline(true);
    await page.reload();
    await shown(page, 0);
    await page.getByLabel("Open a model").setInputFiles(model);
    await page.locator(".found[aria-busy=false]").waitFor();
  },

  async nothing_is_in_the_way_of_anybody() {
    for (const colorScheme of ["light", "dark"]) {
      const page = await open({ colorScheme });
      await page.getByText("All parameters").click();
      await page.getByLabel("Open a model").setInputFiles(model);
      await page.locator(".found[aria-busy=false]").waitFor();
      await page.evaluate(axe);
      const { violations } = await page.evaluate(() => window.axe.run());
      const serious = violations.filter((one) => ["serious", "critical"].includes(one.impact));
      must(serious.length === 0, serious.map((one) => `${one.id}: ${one.nodes[0].html}`).join("\n"));
    }
    const phone = await open({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
    const width = await phone.evaluate(() => document.documentElement.scrollWidth);
    must(width <= 390, `a phone has to scroll sideways: ${width} px`);
  },

  async nobody_complained_and_nothing_left_the_page() {
    const csp = await (await open()).locator("meta[http-equiv]").getAttribute("content");
    must(!csp.includes("unsafe-inline") && !csp.includes("'unsafe-eval'") && csp.includes("default-src 'none'"), csp);
    must(complaints.length === 0, complaints.join("\n"));
    must(strangers.length === 0, strangers.join("\n"));
  },
};

const wanted = process.argv[4];
let [nPassed, nFailed] = [0, 0];
async function run([name, test]) {
  if (wanted && !name.includes(wanted)) return;
  const begin = performance.now();
  const contexts = [];
  try {
    await contextsOfTest.run(contexts, test);
    nPassed += 1;
    console.log(`test playground::${name} ... ok`);
  } catch (error) {
    nFailed += 1;
    console.log(`test playground::${name} ... FAILED\n${error.message}`);
  }
  if (process.env.TIMES) console.log(`  ${Math.round(performance.now() - begin)} ms`);
  for (const context of contexts) await context.close();
}
const waiting = Object.entries(tests);
// What the others have gathered is looked at in the end.
const last = waiting.pop();
const worker = async () => {
  while (waiting.length > 0) await run(waiting.shift());
};
await Promise.all([worker(), worker()]);
await run(last);
console.log(`test result: ${nFailed ? "FAILED" : "ok"}. ${nPassed} passed; ${nFailed} failed; 0 ignored`);
await browser.close();
server.close();
rmSync(scratch, { recursive: true });
process.exit(nFailed ? 1 : 0);
