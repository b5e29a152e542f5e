// Files can be saved and read again; the request can be taken along as a link, for a shell and for Python.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { drawn, field, settled, settledAfter, useBrowser } from "./support.mjs";

const world = useBrowser();

test("files are what the diagram shows", async () => {
  const page = await world.open("/#example=torus");
  await settled(page);
  const vertices = Number(await page.getAttribute(".diagram", "data-vertices"));
  const formats = await page.$$eval("#files a", (links) => links.map((a) => a.dataset.format));
  assert.deepEqual(formats, ["vtp", "vtk", "svg", "geojson", "csv"]);
  for (const format of formats) {
    const [download] = await Promise.all([
      page.waitForEvent("download"), page.click(`#files a[data-format=${format}]`)]);
    assert.equal(await download.failure(), null);
    if (format !== "vtp") continue;
    const file = join(mkdtempSync(join(tmpdir(), "isocaustic-file-")), "curves.vtp");
    await download.saveAs(file);
    const read = JSON.parse(execFileSync("python3", [process.env.READ_VTK, file], { encoding: "utf8", maxBuffer: 1 << 26 }));
    const { answer } = await page.evaluate(async () => ({ answer: await (await fetch(document.querySelector("#files a").href.slice(0, -4))).json() }));
    assert.equal(read.lines.length, answer.curves.length);
    const repeated = read.cell_data.closed.reduce((sum, closed) => sum + closed, 0); // first points
    assert.equal(read.lines.reduce((sum, line) => sum + line.length, 0) - repeated, vertices);
    assert.deepEqual(read.cell_data.level.map((l) => (l < 0 ? null : l)), answer.curves.map((c) => c.level));
  }
});

test("a link is the scene", async () => {
  const page = await world.open("/#example=sphere-wall");
  await settled(page);
  await settledAfter(page, () => field(page, "Radius").fill("0.75"));
  await page.waitForFunction(() => location.hash.startsWith("#scene="));
  await page.click("#copy-link");
  const link = await page.evaluate(() => navigator.clipboard.readText());
  const other = await world.open(link.slice(world.base.length), { pictures: true });
  await settled(other);
  assert.equal(await field(other, "Radius").inputValue(), "0.75");
  assert.equal(await drawn(other), await drawn(page));
  await other.evaluate(() => (location.hash = "#scene=no"));
  await other.waitForSelector("#status.troubled");
  await settledAfter(other, () => other.evaluate(() => (location.hash = "#example=vase")));
});

test("what is copied for a shell and for Python runs", async () => {
  const page = await world.open("/#example=sphere-wall");
  await settled(page);
  await page.click("#copy-curl");
  const curl = await page.evaluate(() => navigator.clipboard.readText());
  const shown = Number(await page.getAttribute(".diagram", "data-vertices"));
  const answer = JSON.parse(execFileSync("sh", ["-c", curl], { encoding: "utf8" }));
  assert.equal(answer.curves.reduce((sum, c) => sum + c.vertices, 0), shown);
  await page.click("#copy-python");
  const python = await page.evaluate(() => navigator.clipboard.readText());
  const said = execFileSync("python3", ["-c", python.replace('"curves.vtp"', '"/dev/null"')], { encoding: "utf8" });
  assert.equal(said.trim().split("\n").length, answer.curves.length);
});
