// How the page looks, loosely: the mean colours of a coarse grid over it, compared with those of look.json, which
// somebody has looked at (ISOCAUSTIC_RECORD=1 writes them anew).
import assert from "node:assert/strict";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { settled, useBrowser } from "./support.mjs";

const world = useBrowser();
const file = new URL("look.json", import.meta.url);
const seen = existsSync(file) ? JSON.parse(readFileSync(file, "utf8")) : {};
const [COLUMNS, ROWS] = [24, 15];
const FARTHEST_MEAN = 4; // of 255; fonts differ between machines
const FARTHEST_CELL = 60;

/** Mean red, green and blue of each cell, read by the browser itself. */
const gridOf = async (page, picture) =>
  page.evaluate(
    async ([base64, columns, rows]) => {
      const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
      const image = await createImageBitmap(new Blob([bytes]), { resizeWidth: columns, resizeHeight: rows, resizeQuality: "high" });
      const context = new OffscreenCanvas(columns, rows).getContext("2d");
      context.drawImage(image, 0, 0);
      return [...context.getImageData(0, 0, columns, rows).data].filter((_, i) => i % 4 < 3);
    },
    [picture.toString("base64"), COLUMNS, ROWS],
  );

for (const [name, example, colorScheme, width, height] of [
  ["dark", "torus", "dark", 1440, 900],
  ["light", "desk", "light", 1440, 900],
  ["narrow", "nephroid", "light", 360, 740],
])
  test(`it looks as it did: ${name}`, async () => {
    const page = await world.open(`/#example=${example}`, { colorScheme, width, height });
    await settled(page);
    await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
    const now = await gridOf(page, await page.screenshot());
    if (process.env.ISOCAUSTIC_RECORD) {
      seen[name] = now;
      writeFileSync(file, JSON.stringify(seen) + "\n");
    }
    const off = now.map((c, i) => Math.abs(c - seen[name][i]));
    const mean = off.reduce((a, b) => a + b, 0) / off.length;
    assert.ok(mean < FARTHEST_MEAN && Math.max(...off) < FARTHEST_CELL, `mean ${mean}, most ${Math.max(...off)}`);
  });
