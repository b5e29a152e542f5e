// Each example can be chosen, is drawn, and its little picture is drawn from the same answer.
import assert from "node:assert/strict";
import { test } from "node:test";
import { drawn, settled, settledAfter, useBrowser } from "./support.mjs";

const world = useBrowser();

test("every example is drawn", async () => {
  const page = await world.open("/", { pictures: true });
  await settled(page);
  const names = await page.$$eval(".example", (buttons) => buttons.map((b) => b.dataset.name));
  const { examples } = await (await fetch(`${world.base}/v1/examples`)).json();
  assert.deepEqual(names, examples.map((e) => e.name));
  for (const name of names) {
    if ((await page.getAttribute(`[data-name="${name}"]`, "aria-pressed")) === "false")
      await settledAfter(page, () => page.click(`[data-name="${name}"]`));
    assert.equal(await page.getAttribute(`[data-name="${name}"]`, "aria-pressed"), "true");
    assert.ok((await drawn(page)).length > 100, name);
    assert.equal(await page.locator("#status.troubled").count(), 0, name);
    assert.equal(await page.locator(".fault:visible").count(), 0, name);
    await page.waitForFunction((n) => location.hash === `#example=${n}`, name);
  }
  await page.waitForFunction(() => [...document.querySelectorAll(".picture")].every((p) => p.querySelector("path")));
});

test("the first view is small", async () => {
  const page = await world.open("/healthz");
  let bytes = 0;
  page.on("response", async (response) => {
    if (/\/(assets\/.*)?$/.test(new URL(response.url()).pathname)) bytes += Number(response.headers()["content-length"]);
  });
  await page.goto(`${world.base}/`);
  await settled(page);
  assert.ok(bytes > 5_000 && bytes < 150_000, `${bytes} bytes`);
});
