// The picture of the playground in the README: picture.mjs SITE FILE.jpg, with Chromium as in the tests.

import { launch } from "./browser.mjs";
import { serve } from "./serve.mjs";

const [site, file] = process.argv.slice(2);
const server = await serve(site);
const browser = await launch();
const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme: "light" });
const page = await context.newPage();
await page.goto(`http://127.0.0.1:${server.address().port}/#preset=windshield-spiderweb&severity=3&hit=0.55,0.45&seed=7`);
await page.waitForFunction(() => Number(document.querySelector(".page")?.dataset.shown) > 0);
// Thumbnails come after the first picture.
await page.waitForLoadState("networkidle");
await page.waitForTimeout(300);
await page.screenshot({ path: file, type: "jpeg", quality: 82 });
await browser.close();
server.close();
