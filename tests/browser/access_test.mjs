// For everybody: names for all that can be focused, contrast, narrow and wide windows; and /docs.
import assert from "node:assert/strict";
import { test } from "node:test";
import { settled, useBrowser } from "./support.mjs";

const world = useBrowser();

test("tabbing goes through all of it, in order, and everything has a name", async () => {
  const page = await world.open("/#example=desk");
  await settled(page);
  const expected = await page.$$eval("a[href], button, input, select, textarea, summary, [tabindex='0']", (all) =>
    all.filter((e) => e.checkVisibility() && e.tabIndex >= 0).length);
  const seen = [];
  for (let i = 0; i < expected; ++i) {
    await page.keyboard.press("Tab");
    seen.push(await page.evaluate(() => {
      const e = document.activeElement;
      e.dataset.order ??= String(document.querySelectorAll("[data-order]").length);
      const label = e.labels?.[0]?.textContent;
      return { order: Number(e.dataset.order), tag: e.tagName, name: e.getAttribute("aria-label") ?? label ?? e.textContent.trim() };
    }));
  }
  assert.deepEqual(seen.map((s) => s.order), seen.map((_, i) => i), "each once");
  assert.deepEqual(seen.filter((s) => !s.name), []);
});

/** The contrast of every text with what lies under it, as WCAG reckons it. */
const contrasts = () => {
  const numbers = (colour) => colour.match(/[\d.]+/g).map(Number);
  const light = (rgb) => {
    const [r, g, b] = rgb.map((c) => ((c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = (e) => {
    for (; e; e = e.parentElement) {
      const [r, g, b, a = 1] = numbers(getComputedStyle(e).backgroundColor);
      if (a > 0.99) return [r, g, b];
    }
    return [255, 255, 255];
  };
  const low = [];
  for (const e of document.querySelectorAll("body *")) {
    const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
    if (!own || !e.checkVisibility() || e.closest("svg")) continue;
    const [a, b] = [light(numbers(getComputedStyle(e).color).slice(0, 3)), light(ground(e))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < 4.5) low.push(`${e.tagName} ${e.textContent.trim().slice(0, 30)}: ${ratio.toFixed(2)}`);
  }
  return low;
};

for (const colorScheme of ["light", "dark"])
  test(`texts can be read, ${colorScheme}`, async () => {
    const page = await world.open("/#example=desk", { colorScheme });
    await settled(page);
    assert.deepEqual(await page.evaluate(contrasts), []);
    await page.getByRole("button", { name: "Dark" }).click();
    assert.deepEqual(await page.evaluate(contrasts), [], "and after the switch");
  });

for (const [width, height] of [[360, 740], [800, 1100], [1440, 900], [2560, 1400]])
  test(`nothing sticks out at ${width} pixels`, async () => {
    const page = await world.open("/#example=nephroid", { width, height });
    await settled(page);
    const { wide, plot } = await page.evaluate(() => ({
      wide: document.documentElement.scrollWidth,
      plot: document.querySelector(".receiver").getBoundingClientRect().width,
    }));
    assert.ok(wide <= width, `${wide} pixels wide`);
    assert.ok(plot > 0.2 * width, `${plot} pixels of the receiver`);
  });

test("/docs shows every call", async () => {
  const page = await world.open("/docs");
  const { paths } = await (await fetch(`${world.base}/openapi.json`)).json();
  const calls = Object.values(paths).reduce((sum, methods) => sum + Object.keys(methods).length, 0);
  await page.waitForFunction((n) => document.querySelectorAll(".opblock").length === n, calls);
});
