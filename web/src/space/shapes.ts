// Surfaces as triangles, before their pose and their apertures. What has no end of its own reaches as far as
// the scene does.
import type { Json, JsonObject, Vec3 } from "../contract";
import { get } from "../pointer";
import { add, cross, dot, minus, scaled, unit, vec3 } from "../scene";
import { parseExpression } from "./expression";
import { heightsOf } from "./heights";
import { gridMesh, zeroMesh, type Mesh } from "./mesh";

/** Two directions that make a right-handed frame with `axis`. */
function across(axis: Vec3): [Vec3, Vec3] {
  const other: Vec3 = Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const a = unit(cross(other, axis));
  return [a, cross(axis, a)];
}

/** Null if a member is missing or not of its kind: the service will say so. */
export function meshOf(shape: JsonObject, reach: number): Mesh | null {
  const v = (key: string) => vec3(shape[key]);
  const n = (key: string) => Number(shape[key]);
  const round = (origin: Vec3, axis: Vec3, point: (t: number) => [radius: number, height: number] | null): Mesh => {
    const [a, b] = across(axis);
    return gridMesh((s, t) => {
      const at = point(t);
      if (!at) return null;
      const [c, d] = [Math.cos(2 * Math.PI * s) * at[0], Math.sin(2 * Math.PI * s) * at[0]];
      return add(add(origin, scaled(axis, at[1])), add(scaled(a, c), scaled(b, d)));
    });
  };
  const axis = unit(v("axis") ?? v("normal") ?? [0, 0, 1]);
  switch (shape["type"]) {
    case "plane": return v("point") && round(v("point")!, axis, (t) => [t * reach, 0]);
    case "sphere": return ellipsoid(v("center"), [n("radius"), n("radius"), n("radius")]);
    case "ellipsoid": return ellipsoid(v("center"), v("semi_axes"));
    case "cylinder": return v("point") && round(v("point")!, axis, (t) => [n("radius"), (2 * t - 1) * reach]);
    case "cone": {
      const slope = Math.tan((n("half_angle_degrees") * Math.PI) / 180);
      return v("point") && round(v("point")!, axis, (t) => [Math.abs(2 * t - 1) * reach * slope, (2 * t - 1) * reach]);
    }
    case "torus": {
      const [R, r] = [n("major_radius"), n("minor_radius")];
      return v("center") && round(v("center")!, axis, (t) => [R + r * Math.cos(2 * Math.PI * t), r * Math.sin(2 * Math.PI * t)]);
    }
    case "conic": return v("vertex") && conic(shape, reach, (point) => round(v("vertex")!, axis, point));
    case "revolution": {
      const profile = numbers(shape["profile"]);
      const radius = (z: number) => profile.reduceRight((sum, c) => sum * z + c, 0);
      return v("origin") && round(v("origin")!, axis, (t) => [radius(t), t * n("height")]);
    }
    case "sag": return sag(shape, reach);
    case "quadric": return quadric(numbers(shape["coefficients"]), reach);
    case "expression": {
      const g = parseExpression(String(shape["expression"] ?? ""));
      const [low, high] = [vec3(get(shape, "/bounds/min")), vec3(get(shape, "/bounds/max"))];
      return g && low && high ? zeroMesh(g, low, high) : null;
    }
    default: return null;
  }
}

const numbers = (value: Json | undefined): number[] => (Array.isArray(value) ? value.map(Number) : []);

function ellipsoid(center: Vec3 | null, axes: Vec3 | null): Mesh | null {
  if (!center || !axes) return null;
  return gridMesh((s, t) => {
    const [phi, theta] = [2 * Math.PI * s, Math.PI * t];
    const x: Vec3 = [Math.sin(theta) * Math.cos(phi), Math.sin(theta) * Math.sin(phi), Math.cos(theta)];
    return x.map((c, i) => center[i]! + c * axes[i]!) as Vec3;
  });
}

function conic(shape: JsonObject, reach: number, round: (point: (t: number) => [number, number] | null) => Mesh): Mesh {
  const [R, k] = [Number(shape["radius_of_curvature"]), Number(shape["conic_constant"])];
  const terms = numbers(shape["aspheric"]);
  const limit = k > -1 ? Math.abs(R) / Math.sqrt(1 + k) : Infinity;
  return round((t) => {
    const r = t * Math.min(reach, limit);
    const root = Math.sqrt(Math.max(0, 1 - ((1 + k) * r * r) / (R * R)));
    return [r, (r * r) / (R * (1 + root)) + terms.reduce((sum, a, i) => sum + a * r ** (4 + 2 * i), 0)];
  });
}

function sag(shape: JsonObject, reach: number): Mesh | null {
  const [origin, x, y] = [vec3(shape["origin"]), vec3(shape["x_axis"]), vec3(shape["y_axis"])];
  const heights = heightsOf(shape, reach);
  if (!origin || !x || !y || !heights) return null;
  const e1 = unit(x);
  const e2 = unit(minus(y, scaled(e1, dot(y, e1))));
  const e3 = cross(e1, e2);
  const between = ([a, b]: [number, number], t: number) => a + (b - a) * t;
  return gridMesh((s, t) => {
    const [px, py] = [between(heights.x, s), between(heights.y, t)];
    const z = heights.f(px, py);
    return z === null ? null : add(add(origin, scaled(e3, z)), add(scaled(e1, px), scaled(e2, py)));
  });
}

function quadric(c: number[], reach: number): Mesh | null {
  if (c.length !== 10) return null;
  const [A, B, C, D, E, F, G, H, I, J] = c as [number, number, number, number, number, number, number, number, number, number];
  const g = (x: number, y: number, z: number) =>
    A * x * x + B * y * y + C * z * z + 2 * (D * x * y + E * x * z + F * y * z + G * x + H * y + I * z) + J;
  return zeroMesh(g, [-reach, -reach, -reach], [reach, reach, reach], 72);
}
