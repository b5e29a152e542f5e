// vtk.js, which shares nothing with VTK's writer, reads every example's .vtp: all curves, all arrays.
import assert from "node:assert/strict";
import { mkdtempSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import { serve } from "./support.mjs";

const POINT_DATA = ["irradiance", "residual", "gradient", "arc_length", "uv", "reflector_point"];
const CELL_DATA = ["curve_id", "kind", "level", "closed", "family_id", "parity", "length"];
const FIELD_DATA = ["scene_json", "units_json", "engine_version", "request_sha256"];
const KINDS = ["isolux", "caustic", "jump", "receiver_edge", "boundary"];

let program, base, Reader;
before(async () => {
  // Its modules are written for bundlers.
  const outfile = join(mkdtempSync(join(tmpdir(), "isocaustic-vtkjs-")), "reader.cjs");
  const contents = 'export { default } from "vtk.js/Sources/IO/XML/XMLPolyDataReader/index.js";';
  await build({ stdin: { contents, resolveDir: fileURLToPath(new URL(".", import.meta.url)) }, bundle: true, platform: "node",
    target: "node18", format: "cjs", outfile, logLevel: "error" });
  Reader = createRequire(import.meta.url)(outfile).default;
  ({ program, base } = await serve());
});
after(() => (program.removeAllListeners("exit"), program.kill()));

test("every example's .vtp opens with all curves and arrays", async () => {
  const { examples } = await (await fetch(`${base}/v1/examples`)).json();
  assert.ok(examples.length > 10);
  for (const { name } of examples) {
    const body = await (await fetch(`${base}/v1/examples/${name}`)).text();
    const headers = { "Content-Type": "application/json" };
    const answer = await (await fetch(`${base}/v1/contours`, { method: "POST", body, headers })).json();
    const file = await (await fetch(base + answer.files.vtp)).arrayBuffer();
    const reader = Reader.newInstance();
    assert.ok(reader.parseAsArrayBuffer(file), name);
    const data = reader.getOutputData(0);
    const vertices = answer.curves.reduce((sum, curve) => sum + curve.vertices, 0);
    assert.equal(data.getNumberOfLines(), answer.curves.length, name);
    assert.equal(data.getNumberOfPoints(), vertices, name);
    for (const [arrays, names, tuples] of [
      [data.getPointData(), POINT_DATA, vertices], [data.getCellData(), CELL_DATA, answer.curves.length]])
      for (const array of names) {
        const found = arrays.getArrayByName(array);
        assert.equal(found?.getNumberOfTuples(), tuples, `${name}: ${array}`);
        assert.ok(found.getData().every(Number.isFinite), `${name}: ${array}`);
      }
    const kinds = [...data.getCellData().getArrayByName("kind").getData()];
    assert.deepEqual(kinds.map((k) => KINDS[k]), answer.curves.map((c) => c.kind), name);
    const fields = data.getFieldData().getArrays().map((array) => array.getName());
    assert.deepEqual(fields, FIELD_DATA, name);
  }
});
