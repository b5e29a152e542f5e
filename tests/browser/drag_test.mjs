// Curves follow what is dragged: one request at a time, unstored; the exact ones come on release.
import assert from "node:assert/strict";
import { test } from "node:test";
import { drawn, field, settled, settledAfter, useBrowser } from "./support.mjs";

const world = useBrowser();
const LIGHT = '.handle[data-pointer="/scene/light"]';

async function opened() {
  const page = await world.open("/#example=sphere-ceiling");
  await settled(page);
  return page;
}

async function middleOf(page, selector) {
  const box = await page.locator(selector).boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
}

test("the light is dragged", async () => {
  const page = await opened();
  const asked = [];
  const inFlight = new Set();
  let most = 0;
  page.on("request", (r) => {
    if (!r.url().endsWith("/v1/contours")) return;
    asked.push(r.postDataJSON().store);
    most = Math.max(most, inFlight.add(r).size);
  });
  const ended = (r) => inFlight.delete(r);
  page.on("requestfinished", ended);
  page.on("requestfailed", ended);
  const before = Number(await page.getAttribute(".diagram", "data-updates"));
  const seen = new Set();
  const [x, y] = await page.locator(`${LIGHT} .grip`).boundingBox().then((b) => [b.x + b.width / 2, b.y + b.height / 2]);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 60; ++i) {
    await page.mouse.move(x + 2 * i, y - i);
    seen.add(await drawn(page));
  }
  await page.waitForFunction(() => document.querySelector(".diagram").dataset.coarse === "true");
  const during = Number(await page.getAttribute(".diagram", "data-updates")) - before;
  await page.mouse.up();
  await settled(page);
  assert.ok(during > 5 && seen.size > 5, `${during} updates, ${seen.size} of them seen`);
  assert.equal(most, 1, "requests at the same time");
  assert.deepEqual([asked.at(-1), ...new Set(asked.slice(0, -1))], [true, false]);
  assert.notEqual(await field(page, "Position, x").inputValue(), "0.3");
});

test("with Shift it leaves the receiver's plane", async () => {
  const page = await opened();
  const at = (axis) => field(page, `Position, ${axis}`).inputValue();
  const [x0, z0] = [await at("x"), await at("z")];
  const [x, y] = await middleOf(page, `${LIGHT} .grip`);
  await page.keyboard.down("Shift");
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 5, y - 20, { steps: 4 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  await settled(page);
  assert.equal(await at("x"), x0);
  assert.notEqual(await at("z"), z0);
});

test("keys move things, levels and the meter", async () => {
  const page = await opened();
  await page.focus('.handle[data-pointer="/scene/surfaces/0"]');
  await settledAfter(page, () => page.keyboard.press("ArrowRight"));
  assert.notEqual(await field(page, "Centre, x").inputValue(), "0");
  const level = page.getByRole("slider", { name: "Level 1" });
  const before = Number(await level.getAttribute("aria-valuenow"));
  await level.focus();
  await settledAfter(page, () => page.keyboard.press("ArrowUp"));
  const after = Number(await page.getByRole("slider", { name: "Level 1" }).getAttribute("aria-valuenow"));
  assert.ok(after > before);
  assert.match(await page.getByLabel(/Levels in/).inputValue(), new RegExp(String(after)));
  await page.focus(".diagram");
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction(() => /sheets 1/.test(document.querySelector("#reading").innerText));
});

test("zoom keeps what is under the cursor", async () => {
  const page = await opened();
  const [x, y] = await middleOf(page, `${LIGHT} .grip`);
  await page.mouse.move(x, y);
  await page.mouse.wheel(0, -600);
  await page.waitForSelector(".diagram.zoomed");
  const [x1, y1] = await middleOf(page, `${LIGHT} .grip`);
  assert.ok(Math.hypot(x1 - x, y1 - y) < 2);
  await page.getByRole("button", { name: "Show all" }).click();
  await page.waitForSelector(".diagram:not(.zoomed)");
});
