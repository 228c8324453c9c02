// Chromium of the tests: where STARBREAK_TEST_CHROMIUM says, or on PATH.

import { existsSync } from "node:fs";
import { delimiter, join } from "node:path";
import { chromium } from "playwright-core";

export function launch(args = []) {
  const onPath = (process.env.PATH ?? "")
    .split(delimiter)
    .flatMap((folder) => ["chromium", "chromium-browser", "google-chrome"].map((name) => join(folder, name)))
    .find((path) => existsSync(path));
  return chromium.launch({ executablePath: process.env.STARBREAK_TEST_CHROMIUM ?? onPath, args: ["--no-sandbox", ...args] });
}
