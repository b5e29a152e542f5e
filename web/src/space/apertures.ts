// Apertures as planes that cut: boxes and half spaces are that, cylinders nearly. Expressions cut triangles.
import { Plane, Vector3 } from "three";
import type { Json, JsonObject, Vec3 } from "../contract";
import { get, isObject } from "../pointer";
import { cross, unit, vec3 } from "../scene";
import { parseExpression, type Expression } from "./expression";

const SIDES = 32; // of a cylinder

const plane = (kept: Vec3, point: Vec3): Plane =>
  new Plane().setFromNormalAndCoplanarPoint(new Vector3(...kept), new Vector3(...point));

function partsOf(surface: Json): JsonObject[] {
  const parts = get(surface, "/aperture");
  return Array.isArray(parts) ? parts.filter(isObject) : [];
}

/** The part of space that is kept lies on the positive side of all of them. */
export const clippingPlanes = (surface: Json): Plane[] => partsOf(surface).flatMap(planesOf);

/** The part of space that is kept is where none of them is positive. */
export const clippingExpressions = (surface: Json): Expression[] =>
  partsOf(surface).flatMap((part) => {
    const expression = part["type"] === "expression" ? parseExpression(String(part["expression"])) : null;
    return expression ? [expression] : [];
  });

function planesOf(part: JsonObject): Plane[] {
  const [min, max, point] = [vec3(part["min"]), vec3(part["max"]), vec3(part["point"])];
  if (part["type"] === "box" && min && max)
    return [0, 1, 2].flatMap((i) => {
      const e = [0, 1, 2].map((j) => Number(i === j)) as Vec3;
      return [plane(e, min), plane(e.map((c) => -c) as Vec3, max)];
    });
  const normal = vec3(part["normal"]);
  if (part["type"] === "half_space" && point && normal) return [plane(unit(normal).map((c) => -c) as Vec3, point)];
  const axis = vec3(part["axis"]);
  if (part["type"] !== "cylinder" || !point || !axis) return [];
  const w = unit(axis);
  const a = unit(cross(Math.abs(w[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], w));
  const b = cross(w, a);
  return Array.from({ length: SIDES }, (_, i) => {
    const [c, s] = [Math.cos((2 * Math.PI * i) / SIDES), Math.sin((2 * Math.PI * i) / SIDES)];
    const out = a.map((x, j) => c * x + s * b[j]!) as Vec3;
    return plane(out.map((x) => -x) as Vec3, point.map((x, j) => x + Number(part["radius"]) * out[j]!) as Vec3);
  });
}
