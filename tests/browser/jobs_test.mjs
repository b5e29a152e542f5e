// Long work shows how far it is and can be cancelled, whether events come or not; a token is asked for.
import assert from "node:assert/strict";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { settled, settledAfter, useBrowser } from "./support.mjs";

const secret = join(mkdtempSync(join(tmpdir(), "isocaustic-token-")), "token");
writeFileSync(secret, "sesame");
const world = useBrowser(["--token-file", secret]);

async function opened(path) {
  const page = await world.open(path, { pictures: true });
  await page.getByRole("textbox", { name: "Token" }).fill("sesame");
  await page.getByRole("button", { name: "Continue" }).click();
  await settled(page);
  return page;
}

/** A minute of work: a chord that takes very many vertices. */
async function makeLong(page) {
  await page.click("#tab-json");
  const area = page.locator("textarea.json");
  const request = JSON.parse(await area.inputValue());
  request.tolerance = { chord: 1e-7, irradiance: 1e-12 };
  request.limits = { time_ms: 60000, vertices: 2000000 };
  request.levels = { count: 900 };
  await area.fill(JSON.stringify(request));
}

test("a long job moves its bar and is cancelled", async () => {
  const page = await opened("/#example=cuboid");
  await makeLong(page);
  await page.waitForSelector(".work:visible");
  const [request] = await Promise.all([
    page.waitForRequest((r) => r.method() === "DELETE"), page.getByRole("button", { name: "Cancel" }).click()]);
  await page.waitForSelector("#status.troubled");
  assert.match(await page.textContent("#status"), /Cancelled/);
  assert.equal(await page.locator(".work:visible").count(), 0);
  const answer = await fetch(request.url(), { headers: { Authorization: "Bearer sesame" } });
  assert.equal((await answer.json()).status, "dismissed");
});

test("where events are refused the job is asked for", async () => {
  const page = await opened("/#example=sphere-wall");
  await page.route("**/events", (route) => route.fulfill({ status: 503, body: "" }));
  await settledAfter(page, () => page.click('[data-name="vase"]'));
});

test("files are saved with the token", async () => {
  const page = await opened("/#example=torus");
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#files a[data-format=csv]")]);
  assert.equal(await download.failure(), null);
  assert.equal(download.suggestedFilename(), "isocaustic.csv");
});

test("a job that somebody else cancels is begun again", async () => {
  const page = await opened("/#example=cuboid");
  await makeLong(page);
  const events = await page.waitForRequest((r) => r.url().endsWith("/events"));
  const job = events.url().slice(0, -"/events".length);
  const [again] = await Promise.all([
    page.waitForRequest((r) => r.url().endsWith("/v1/contours") && r.postDataJSON().store),
    fetch(job, { method: "DELETE", headers: { Authorization: "Bearer sesame" } })]);
  assert.equal(again.postDataJSON().levels.count, 900);
  await page.waitForSelector(".work:visible");
  await page.getByRole("button", { name: "Cancel" }).click();
  await page.waitForSelector("#status.troubled");
});

test("/docs asks for the token too", async () => {
  const page = await world.open("/docs");
  await page.getByRole("textbox", { name: "Token" }).fill("sesame");
  await page.getByRole("button", { name: "Continue" }).click();
  await page.waitForSelector(".opblock");
});

test("a service with too much to do is asked again", async () => {
  const page = await opened("/#example=sphere-wall");
  let refused = 0;
  await page.route("**/v1/contours", (route) =>
    ++refused > 3 ? route.continue() : route.fulfill({ status: refused % 2 ? 429 : 503, body: "" }));
  await settledAfter(page, () => page.click('[data-name="nephroid"]'));
  assert.ok(refused > 3);
});
