// The view in space: examples' surfaces and curves, rays, what is picked in one view shown in both.
import assert from "node:assert/strict";
import { test } from "node:test";
import { deflateRawSync } from "node:zlib";
import { settled, settledAfter, useBrowser } from "./support.mjs";

const world = useBrowser();

async function opened(name) {
  const page = await world.open(`/#example=${name}`, { width: 1400, height: 560, pictures: name === "sphere-wall" });
  await settled(page);
  await page.getByRole("button", { name: "3-D" }).click();
  await page.waitForSelector("canvas.space[data-curves]");
  return page;
}
const number = (page, key) => page.$eval("canvas.space", (canvas, k) => Number(canvas.dataset[k]), key);

// A ball, a torus, an expression, heights, and two surfaces; ISOCAUSTIC_ALL_EXAMPLES=1 takes all.
const few = ["sphere-wall", "torus", "cuboid", "two-mirrors", "freeform-heights"];

test("examples have their surfaces and curves", async () => {
  const page = await opened("sphere-wall");
  const { examples } = await (await fetch(`${world.base}/v1/examples`)).json();
  for (const { name } of examples) {
    if (!process.env.ISOCAUSTIC_ALL_EXAMPLES && !few.includes(name)) continue;
    if (name !== "sphere-wall") await settledAfter(page, () => page.click(`[data-name="${name}"]`));
    const request = await (await fetch(`${world.base}/v1/examples/${name}`)).json();
    assert.equal(await number(page, "bodies"), request.scene.surfaces.length, name);
    const files = await page.getAttribute("#files a[data-format=geojson]", "href");
    const { features } = await (await fetch(world.base + files)).json();
    assert.equal(await number(page, "curves"), features.length, name);
  }
});

test("a picked curve shows the rays that light it", async () => {
  const page = await opened("sphere-ceiling");
  const [x, y] = await page.$eval(".curves path.isolux", (path) => {
    const at = path.getPointAtLength(0.3 * path.getTotalLength());
    const { a, d, e, f } = path.getScreenCTM();
    return [a * at.x + e, d * at.y + f];
  });
  await page.mouse.move(x, y);
  await page.waitForFunction(() => document.querySelector("canvas.space").dataset.rays === "1");
  await page.waitForSelector(".curves.stressed path.on");
  await page.mouse.click(x, y);
  await page.waitForFunction(() => Number(document.querySelector("canvas.space").dataset.rays) > 30);
});

test("what is under the pointer in space is read and stands out in the diagram", async () => {
  const page = await opened("sphere-ceiling");
  const box = await page.locator("canvas.space").boundingBox();
  let stressed = false;
  for (let i = 1; i < 100 && !stressed; ++i) {
    await page.mouse.move(box.x + box.width / 2, box.y + (i / 100) * box.height);
    stressed = (await page.locator(".curves.stressed").count()) > 0;
  }
  assert.ok(stressed);
  await page.waitForFunction(() => /sheets/.test(document.querySelector("#reading").innerText));
});

test("an aperture by an expression cuts its surface", async () => {
  const page = await opened("sphere-ceiling");
  const whole = await number(page, "triangles");
  const example = await (await fetch(`${world.base}/v1/examples/sphere-ceiling`)).json();
  const [x] = example.scene.surfaces[0].shape.center;
  example.scene.surfaces[0].aperture = [{ type: "expression", expression: `x - ${x}` }];
  const scene = deflateRawSync(JSON.stringify(example)).toString("base64url");
  await settledAfter(page, () => page.evaluate((hash) => (location.hash = hash), `#scene=${scene}`));
  const half = await number(page, "triangles");
  assert.ok(half > 0.45 * whole && half < 0.55 * whole, `${half} of ${whole}`);
});

test("it turns by keys", async () => {
  const page = await opened("torus");
  const canvas = page.locator("canvas.space");
  const before = await canvas.screenshot();
  await canvas.focus();
  for (const key of ["ArrowLeft", "ArrowLeft", "ArrowUp", "+"]) await page.keyboard.press(key);
  const after = await canvas.screenshot();
  assert.ok(!before.equals(after));
});
