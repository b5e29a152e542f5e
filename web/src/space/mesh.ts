// Triangles: of maps from a rectangle, and of zeros of functions.
import type { Vec3 } from "../contract";
import type { Expression } from "./expression";

export interface Mesh {
  positions: number[];
  indices: number[];
}

/** The image of [0, 1]² under `map`; cells with a corner where it is null are left out. */
export function gridMesh(map: (s: number, t: number) => Vec3 | null, columns = 96, rows = 64): Mesh {
  const mesh: Mesh = { positions: [], indices: [] };
  const numbers: (number | null)[] = [];
  for (let j = 0; j <= rows; ++j)
    for (let i = 0; i <= columns; ++i) {
      const point = map(i / columns, j / rows);
      numbers.push(point?.every(Number.isFinite) ? mesh.positions.push(...point) / 3 - 1 : null);
    }
  for (let j = 0; j < rows; ++j)
    for (let i = 0; i < columns; ++i) {
      const at = j * (columns + 1) + i;
      const [a, b, c, d] = [at, at + 1, at + columns + 2, at + columns + 1].map((k) => numbers[k] ?? null);
      if (a != null && b != null && c != null && d != null) mesh.indices.push(a, b, c, a, c, d);
    }
  return mesh;
}

/** The zeros of g in a box, by surface nets: a vertex in each cell that g changes sign in, amid its crossings. */
export function zeroMesh(g: Expression, low: Vec3, high: Vec3, cells = 48): Mesh {
  const n = cells + 1;
  const step = low.map((a, i) => (high[i]! - a) / cells) as Vec3;
  const at = (i: number, j: number, k: number) => (k * n + j) * n + i;
  const values = new Float64Array(n ** 3);
  for (let k = 0; k < n; ++k)
    for (let j = 0; j < n; ++j)
      for (let i = 0; i < n; ++i)
        values[at(i, j, k)] = g(low[0] + i * step[0], low[1] + j * step[1], low[2] + k * step[2]);

  const mesh: Mesh = { positions: [], indices: [] };
  const vertices = new Map<number, number>();
  for (let k = 0; k < cells; ++k)
    for (let j = 0; j < cells; ++j)
      for (let i = 0; i < cells; ++i) {
        const middle = crossing(values, at, i, j, k);
        if (!middle) continue;
        const point = middle.map((m, c) => low[c]! + ([i, j, k][c]! + m) * step[c]!);
        vertices.set(at(i, j, k), mesh.positions.push(...point) / 3 - 1);
      }
  // Each edge of the grid that crosses is a quad of the four cells around it.
  for (let k = 1; k < cells; ++k)
    for (let j = 1; j < cells; ++j)
      for (let i = 1; i < cells; ++i) {
        const here = values[at(i, j, k)]! < 0;
        const quad = (next: boolean, around: [number, number, number][]) => {
          if (here === next) return;
          const [a, b, c, d] = around.map(([x, y, z]) => vertices.get(at(x, y, z)));
          if (a !== undefined && b !== undefined && c !== undefined && d !== undefined) mesh.indices.push(a, b, c, a, c, d);
        };
        quad(values[at(i + 1, j, k)]! < 0, [[i, j, k], [i, j - 1, k], [i, j - 1, k - 1], [i, j, k - 1]]);
        quad(values[at(i, j + 1, k)]! < 0, [[i, j, k], [i, j, k - 1], [i - 1, j, k - 1], [i - 1, j, k]]);
        quad(values[at(i, j, k + 1)]! < 0, [[i, j, k], [i - 1, j, k], [i - 1, j - 1, k], [i, j - 1, k]]);
      }
  return mesh;
}

/** The part of a mesh where f ≤ 0; triangles on which f changes sign are cut between their corners. */
export function cutMesh({ positions, indices }: Mesh, f: Expression): Mesh {
  const mesh: Mesh = { positions: [...positions], indices: [] };
  const corner = (i: number) => positions.slice(3 * i, 3 * i + 3) as Vec3;
  const values = Array.from({ length: positions.length / 3 }, (_, i) => f(...corner(i)));
  const between = (i: number, j: number): number => {
    const t = values[i]! / (values[i]! - values[j]!);
    const [a, b] = [corner(i), corner(j)];
    return mesh.positions.push(...a.map((x, c) => x + t * (b[c]! - x))) / 3 - 1;
  };
  for (let k = 0; k < indices.length; k += 3) {
    const kept: number[] = []; // the corners of what is left, in their order
    for (let side = 0; side < 3; ++side) {
      const [i, j] = [indices[k + side]!, indices[k + ((side + 1) % 3)]!];
      if (values[i]! <= 0) kept.push(i);
      if (values[i]! <= 0 !== values[j]! <= 0 && Number.isFinite(values[i]! - values[j]!)) kept.push(between(i, j));
    }
    for (let c = 2; c < kept.length; ++c) mesh.indices.push(kept[0]!, kept[c - 1]!, kept[c]!);
  }
  return mesh;
}

/** The mean of the crossings on a cell's edges, in the cell; null if there are none. */
function crossing(values: Float64Array, at: (i: number, j: number, k: number) => number, i: number, j: number, k: number): Vec3 | null {
  const sum: Vec3 = [0, 0, 0];
  let count = 0;
  for (let axis = 0; axis < 3; ++axis)
    for (let corner = 0; corner < 4; ++corner) {
      const from: Vec3 = [0, 0, 0];
      from[(axis + 1) % 3] = corner & 1;
      from[(axis + 2) % 3] = corner >> 1;
      const to: Vec3 = [...from];
      to[axis] = 1;
      const a = values[at(i + from[0], j + from[1], k + from[2])]!;
      const b = values[at(i + to[0], j + to[1], k + to[2])]!;
      if (!Number.isFinite(a + b) || a < 0 === b < 0) continue;
      from[axis] = a / (a - b);
      from.forEach((x, c) => (sum[c] = sum[c]! + x));
      ++count;
    }
  return count ? (sum.map((x) => x / count) as Vec3) : null;
}
