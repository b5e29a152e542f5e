// z = f(x, y) of the height fields, as far as the eye needs it.
import type { Json, JsonObject } from "../contract";
import { get, isObject } from "../pointer";

export interface Heights {
  f: (x: number, y: number) => number | null;
  x: [number, number];
  y: [number, number];
}

export function heightsOf(shape: JsonObject, reach: number): Heights | null {
  const square: [number, number] = [-reach, reach];
  switch (shape["kind"]) {
    case "xy_polynomial": {
      const terms = Array.isArray(shape["terms"]) ? shape["terms"].filter(isObject) : [];
      const f = (x: number, y: number) =>
        terms.reduce((sum, t) => sum + Number(t["c"]) * x ** Number(t["i"]) * y ** Number(t["j"]), 0);
      return { f, x: square, y: square };
    }
    case "zernike": {
      const radius = Number(shape["norm_radius"]);
      const given = isObject(shape["coefficients"]) ? Object.entries(shape["coefficients"]) : [];
      const f = (x: number, y: number) => {
        const rho = Math.hypot(x, y) / radius;
        if (rho > 1.0001) return null;
        return given.reduce((sum, [j, c]) => sum + Number(c) * zernike(Number(j), rho, Math.atan2(y, x)), 0);
      };
      return { f, x: [-radius, radius], y: [-radius, radius] };
    }
    case "heights":
      return samples(shape);
    default:
      return null;
  }
}

/** OSA/ANSI index j, RMS-normalised. */
function zernike(j: number, rho: number, theta: number): number {
  const n = Math.ceil((-3 + Math.sqrt(9 + 8 * j)) / 2);
  const m = 2 * j - n * (n + 2);
  const a = Math.abs(m);
  let radial = 0;
  for (let k = 0, term = 1; k <= (n - a) / 2; ++k) {
    term = (k % 2 ? -1 : 1) * factorial(n - k) / (factorial(k) * factorial((n + a) / 2 - k) * factorial((n - a) / 2 - k));
    radial += term * rho ** (n - 2 * k);
  }
  const norm = Math.sqrt((m === 0 ? 1 : 2) * (n + 1));
  return norm * radial * (m < 0 ? Math.sin(a * theta) : Math.cos(a * theta));
}

const factorial = (n: number): number => (n < 2 ? 1 : n * factorial(n - 1));

function samples(shape: JsonObject): Heights | null {
  const [x, y, rows] = [shape["x"], shape["y"], shape["values"]] as [Json, Json, Json];
  if (!Array.isArray(x) || !Array.isArray(y) || !Array.isArray(rows)) return null;
  const [x0, x1, y0, y1] = [x[0], x[1], y[0], y[1]].map(Number) as [number, number, number, number];
  const value = (i: number, j: number) => Number(get(rows, `/${j}/${i}`));
  const columns = Array.isArray(rows[0]) ? rows[0].length : 0;
  const f = (px: number, py: number) => {
    const s = ((px - x0) / (x1 - x0)) * (columns - 1);
    const t = ((py - y0) / (y1 - y0)) * (rows.length - 1);
    const [i, j] = [Math.min(columns - 2, Math.max(0, Math.floor(s))), Math.min(rows.length - 2, Math.max(0, Math.floor(t)))];
    const [a, b] = [s - i, t - j];
    return (1 - b) * ((1 - a) * value(i, j) + a * value(i + 1, j)) + b * ((1 - a) * value(i, j + 1) + a * value(i + 1, j + 1));
  };
  return { f, x: [x0, x1], y: [y0, y1] };
}
