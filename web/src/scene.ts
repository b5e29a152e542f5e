// Geometry of a request: the receiver's frame, where light and surfaces are, what moving them changes.
import type { ContourRequest, Json, Vec2, Vec3 } from "./contract";
import { get, isObject, join, withValue } from "./pointer";
import { rounded } from "./numbers";

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const scaled = (a: Vec3, f: number): Vec3 => [a[0] * f, a[1] * f, a[2] * f];
export const minus = (a: Vec3, b: Vec3): Vec3 => add(a, scaled(b, -1));
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a: Vec3): number => Math.hypot(...a);
export const unit = (a: Vec3): Vec3 => scaled(a, 1 / (length(a) || 1));
export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

const isNumbers = (value: Json | undefined, n: number): boolean =>
  Array.isArray(value) && value.length === n && value.every((x) => typeof x === "number");

export function vec3(value: Json | undefined): Vec3 | null {
  return isNumbers(value, 3) ? (value as Vec3) : null;
}

export interface Receiver {
  origin: Vec3;
  u: Vec3;
  v: Vec3;
  normal: Vec3;
  size: Vec2;
}

/** As the service understands it: u normalised, v made perpendicular. */
export function receiverOf(request: ContourRequest): Receiver | null {
  const at = (key: string) => get(request, `/scene/receiver/${key}`);
  const [origin, a, b] = [vec3(at("origin")), vec3(at("u_axis")), vec3(at("v_axis"))];
  if (!origin || !a || !b || !isNumbers(at("size"), 2)) return null;
  const size = at("size") as Vec2;
  const u = unit(a);
  const v = unit(minus(b, scaled(u, dot(b, u))));
  if (!(size[0] > 0 && size[1] > 0) || !length(a) || !length(cross(u, b))) return null;
  return { origin, u, v, normal: cross(u, v), size };
}

export const toPlane = (r: Receiver, x: Vec3): Vec2 => {
  const d = minus(x, r.origin);
  return [dot(d, r.u), dot(d, r.v)];
};

export const inWorld = (r: Receiver, u: number, v: number, w: number): Vec3 =>
  add(add(scaled(r.u, u), scaled(r.v, v)), scaled(r.normal, w));

// ---- Things that can be moved -------------------------------------------------------------------

export interface Thing {
  pointer: string;
  name: string;
  kind: "light" | "beam" | "surface";
  /** Where it is; for a beam, the direction that it has. */
  at: Vec3;
}

const ANCHORS = ["center", "point", "vertex", "origin"];

export function thingsOf(request: ContourRequest): Thing[] {
  const things: Thing[] = [];
  const position = vec3(get(request, "/scene/light/position"));
  const direction = vec3(get(request, "/scene/light/direction"));
  if (position) things.push({ pointer: "/scene/light", name: "light", kind: "light", at: position });
  else if (direction) things.push({ pointer: "/scene/light", name: "beam", kind: "beam", at: direction });
  const surfaces = get(request, "/scene/surfaces");
  if (!Array.isArray(surfaces)) return things;
  surfaces.forEach((surface, i) => {
    if (!isObject(surface)) return;
    const pointer = join("/scene/surfaces", i);
    things.push({ pointer, name: String(surface["name"] ?? ""), kind: "surface", at: placeOf(surface) });
  });
  return things;
}

const turn = (surface: Json) => Number(get(surface, "/pose/rotate/degrees") ?? 0);

function anchorOf(surface: Json): string | null {
  const key = ANCHORS.find((name) => vec3(get(surface, `/shape/${name}`)));
  return key ? `/shape/${key}` : null;
}

/** The point that stands for the surface, posed (x_world = R x + t). */
function placeOf(surface: Json): Vec3 {
  const anchor = anchorOf(surface);
  const low = vec3(get(surface, "/shape/bounds/min"));
  const high = vec3(get(surface, "/shape/bounds/max"));
  let x: Vec3 = [0, 0, 0];
  if (anchor) x = vec3(get(surface, anchor))!;
  else if (low && high) x = scaled(add(low, high), 0.5);
  const t = vec3(get(surface, "/pose/translate")) ?? [0, 0, 0];
  return add(rotated(x, unit(vec3(get(surface, "/pose/rotate/axis")) ?? [0, 0, 1]), turn(surface)), t);
}

function rotated(x: Vec3, axis: Vec3, degrees: number): Vec3 {
  const angle = (degrees * Math.PI) / 180;
  const along = scaled(axis, dot(axis, x) * (1 - Math.cos(angle)));
  return add(add(scaled(x, Math.cos(angle)), scaled(cross(axis, x), Math.sin(angle))), along);
}

/** The request with this thing moved; coordinates are rounded to `step`. */
export function moved(request: ContourRequest, thing: Thing, by: Vec3, step: number): ContourRequest {
  const shift = (at: string, vector: Vec3) => withValue(request, at, shifted(vector, by, step));
  if (thing.kind === "light") return shift("/scene/light/position", thing.at);
  if (thing.kind === "beam") return shift("/scene/light/direction", thing.at);
  const surface = get(request, thing.pointer)!;
  return withValue(request, thing.pointer, movedSurface(surface, by, step));
}

/** What is not moved keeps all of its digits. */
const shifted = (x: Vec3, by: Vec3, step: number): number[] =>
  x.map((c, i) => (by[i] ? rounded(c + by[i]!, step) : c));

/** What is cut out of a surface goes with it. */
function movedSurface(surface: Json, by: Vec3, step: number): Json {
  let out = surface;
  const shift = (pointer: string, fallback?: Vec3) => {
    const vector = vec3(get(out, pointer)) ?? fallback;
    if (vector) out = withValue(out, pointer, shifted(vector, by, step));
  };
  const anchor = anchorOf(surface);
  if (anchor && turn(surface) === 0) shift(anchor);
  else shift("/pose/translate", [0, 0, 0]);
  const parts = get(surface, "/aperture");
  if (Array.isArray(parts))
    parts.forEach((_, i) => ["min", "max", "point"].forEach((key) => shift(join("/aperture", i, key))));
  return out;
}

// ---- Units ----------------------------------------------------------------------------------------

export const lengthUnit = (request: ContourRequest): string =>
  String(get(request, "/scene/length_unit") ?? "m");

export const isPhotometric = (request: ContourRequest): boolean =>
  get(request, "/scene/quantity") === "photometric";

export const irradianceUnit = (request: ContourRequest): string => (isPhotometric(request) ? "lx" : "W/m²");
