// Form and JSON are one request; what the service finds wrong stands at the field.
import assert from "node:assert/strict";
import { test } from "node:test";
import { drawn, field, settled, settledAfter, useBrowser } from "./support.mjs";

const world = useBrowser();
const request = async (page) => {
  await page.click("#tab-json");
  const text = await page.locator("textarea.json").inputValue();
  await page.click("#tab-form");
  return JSON.parse(text);
};

test("an edited field changes the curves and the JSON", async () => {
  const page = await world.open("/#example=sphere-ceiling");
  await settled(page);
  const before = await drawn(page);
  await settledAfter(page, () => field(page, "Radius").fill("0.5"));
  assert.notEqual(await drawn(page), before);
  assert.equal((await request(page)).scene.surfaces[0].shape.radius, 0.5);
});

test("edited JSON changes the form; what is not JSON is said", async () => {
  const page = await world.open("/#example=sphere-ceiling");
  await settled(page);
  const now = await request(page);
  now.scene.light.position = [1, 2, 3];
  await page.click("#tab-json");
  const area = page.locator("textarea.json");
  await settledAfter(page, () => area.fill(JSON.stringify(now)));
  await area.fill('{"scene":');
  assert.match(await page.textContent("#json-fault"), /JSON/);
  await page.click("#tab-form");
  assert.equal(await field(page, "Position, y").inputValue(), "2");
});

test("faults stand at their fields and lead there", async () => {
  const page = await world.open("/#example=sphere-ceiling");
  await settled(page);
  await field(page, "Radius").fill("-1");
  await field(page, "Reflectance").fill("2");
  await page.waitForFunction(() => document.querySelectorAll("#form [aria-invalid=true]").length === 2);
  const at = (label) => page.locator(".field", { has: field(page, label) }).locator(".fault").textContent();
  assert.equal(await at("Radius"), "must be > 0");
  assert.equal(await at("Reflectance"), "must be > 0 and <= 1");
  await page.getByRole("button", { name: /optics\/reflectance/ }).click();
  assert.equal(await field(page, "Reflectance").evaluate((e) => e === document.activeElement), true);
  await field(page, "Radius").fill("one");
  await settledAfter(page, async () => {
    await field(page, "Reflectance").fill("1");
    await field(page, "Radius").fill("1");
  });
  assert.equal(await page.locator(".fault:visible").count(), 0);
});

test("every kind of surface, light and aperture can be chosen", async () => {
  const page = await world.open("/#example=sphere-ceiling");
  await settled(page);
  await page.getByText("Tolerances and limits").click();
  await settledAfter(page, () => field(page, "Time, ms").fill("200"));
  const select = (label) => page.getByRole("combobox", { name: label, exact: true });
  const kinds = async (label) => select(label).locator("option").evaluateAll((all) => all.map((o) => o.value));
  const choose = async (label, value) => {
    await select(label).selectOption(value);
    await page.waitForFunction(
      () => document.querySelector(".diagram").dataset.settled === "true" || document.querySelector("#status.troubled"));
    const trouble = await page.locator("#status.troubled").allTextContents();
    const faults = trouble.filter((text) => /unknown key|missing|must be one of|must be an? /.test(text));
    assert.deepEqual(faults, [], `${label}: ${value}`);
  };
  for (const value of await kinds("Shape")) await choose("Shape", value);
  await choose("Shape", "sphere");
  for (const value of await kinds("Optics")) await choose("Optics", value);
  await choose("Optics", "mirror");
  for (const value of (await kinds("Kind")).reverse()) await choose("Kind", value);
  await page.getByRole("button", { name: "Add an aperture" }).click();
  for (const value of await kinds("Aperture 1")) await choose("Aperture 1", value);
});

test("surfaces come and go, levels and families are listed", async () => {
  const page = await world.open("/#example=sphere-ceiling");
  await settled(page);
  await settledAfter(page, () => page.getByRole("button", { name: "Add a surface" }).click());
  assert.deepEqual((await request(page)).scene.surfaces.map((s) => s.name), ["ball", "surface 2"]);
  await settledAfter(page, () => page.getByRole("button", { name: "Remove the surface" }).nth(1).click());
  await settledAfter(page, () => field(page, "Chosen").selectOption("2"));
  await settledAfter(page, () => page.getByLabel(/Levels in/).fill("0.001, 0.002 0.004"));
  assert.deepEqual((await request(page)).levels, [0.001, 0.002, 0.004]);
  await page.getByText("Paths of light").click();
  await settledAfter(page, () => field(page, "Found").selectOption("2"));
  assert.deepEqual((await request(page)).families, [["ball"]]);
});
