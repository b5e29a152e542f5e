// What a scene is made of, as data: the members of each type, their units, and what a new one starts with.
import type { Json } from "../contract";

export type Measure = "length" | "degrees" | "intensity" | "power" | "irradiance" | "none";

export interface Field {
  key: string;
  label: string;
  kind: "number" | "pair" | "triple" | "text" | "flag" | "choice" | "json";
  unit?: Measure;
  choices?: { value: string; label: string }[];
  /** Of a new object; lengths are multiplied by a length that suits the scene. */
  preset?: Json;
  /** It may be missing; then this is shown in its place. */
  absent?: string;
}

type Extra = Partial<Field>;
const number = (key: string, label: string, preset: number, unit: Measure = "none", extra: Extra = {}): Field => ({
  key, label, kind: "number", preset, unit, ...extra,
});
const length = (key: string, label: string, preset: number): Field => number(key, label, preset, "length");
const place = (key: string, label: string): Field => ({ key, label, kind: "triple", unit: "length", preset: [0, 0, 0] });
const axis = (key: string, label: string, preset: Json): Field => ({ key, label, kind: "triple", preset });
const json = (key: string, label: string, preset: Json): Field => ({ key, label, kind: "json", preset });
const text = (key: string, label: string, preset: string): Field => ({ key, label, kind: "text", preset });

export interface Kind {
  label: string;
  fields: Field[];
  /** Members that every object of the kind has. */
  fixed?: { [key: string]: Json };
}
export type Kinds = Record<string, Kind>;

const SAG_FRAME = [place("origin", "Origin"), axis("x_axis", "x axis", [1, 0, 0]), axis("y_axis", "y axis", [0, 1, 0])];
const BOUNDS = { min: [-1, -1, -1], max: [1, 1, 1] };

export const SHAPES: Kinds = {
  plane: { label: "Plane", fields: [place("point", "Point"), axis("normal", "Normal", [0, 0, 1])] },
  sphere: { label: "Sphere", fields: [place("center", "Centre"), length("radius", "Radius", 1)] },
  ellipsoid: {
    label: "Ellipsoid",
    fields: [place("center", "Centre"), { key: "semi_axes", label: "Semi-axes", kind: "triple", unit: "length", preset: [1.5, 1, 0.7] }],
  },
  quadric: { label: "Quadric", fields: [json("coefficients", "Coefficients A … J", [1, 1, 1, 0, 0, 0, 0, 0, 0, -1])] },
  cylinder: {
    label: "Cylinder",
    fields: [place("point", "Point on axis"), axis("axis", "Axis", [0, 0, 1]), length("radius", "Radius", 1)],
  },
  cone: {
    label: "Cone",
    fields: [place("point", "Apex"), axis("axis", "Axis", [0, 0, 1]), number("half_angle_degrees", "Half angle", 30, "degrees")],
  },
  torus: {
    label: "Torus",
    fields: [
      place("center", "Centre"), axis("axis", "Axis", [0, 0, 1]),
      length("major_radius", "Major radius", 1), length("minor_radius", "Minor radius", 0.35),
    ],
  },
  conic: {
    label: "Conic, aspheric",
    fields: [
      place("vertex", "Vertex"), axis("axis", "Axis", [0, 0, 1]), length("radius_of_curvature", "Radius of curvature", 2),
      number("conic_constant", "Conic constant", -1), { ...json("aspheric", "A4, A6, …", []), absent: "[]" },
    ],
  },
  revolution: {
    label: "Surface of revolution",
    fields: [
      place("origin", "Origin"), axis("axis", "Axis", [0, 0, 1]), length("height", "Height", 2),
      json("profile", "Radius: c0, c1, …", [0.47, 3.9, -9.78, 5.8]),
    ],
  },
  "sag:xy_polynomial": {
    label: "Height field: polynomial",
    fixed: { type: "sag", kind: "xy_polynomial" },
    fields: [...SAG_FRAME, json("terms", "Terms", [{ i: 2, j: 0, c: 0.1 }, { i: 0, j: 2, c: 0.1 }])],
  },
  "sag:zernike": {
    label: "Height field: Zernike",
    fixed: { type: "sag", kind: "zernike" },
    fields: [...SAG_FRAME, length("norm_radius", "Norm radius", 1), json("coefficients", "Coefficients", { "4": 0.1 })],
  },
  "sag:heights": {
    label: "Height field: samples",
    fixed: { type: "sag", kind: "heights" },
    fields: [
      ...SAG_FRAME, json("x", "x from, to", [-1, 1]), json("y", "y from, to", [-1, 1]),
      json("values", "Heights", Array.from({ length: 8 }, (_, j) => Array.from({ length: 8 }, (_, i) =>
        Number((0.1 * (((i - 3.5) / 3.5) ** 2 + ((j - 3.5) / 3.5) ** 2)).toFixed(4))))),
    ],
  },
  expression: {
    label: "Expression",
    fields: [text("expression", "g(x, y, z)", "x^2 + y^2 + z^2 - 1"), json("bounds", "Bounds", BOUNDS)],
  },
};

export const OPTICS: Kinds = {
  mirror: { label: "Mirror", fields: [number("reflectance", "Reflectance", 1, "none", { absent: "1" })] },
  "mirror:metal": { label: "Metal mirror", fixed: { type: "mirror" }, fields: [number("n", "n", 0.05), number("k", "k", 4)] },
  refract: {
    label: "Refracting",
    fields: [
      number("index_outside", "Index outside", 1), number("index_inside", "Index inside", 1.5),
      { key: "fresnel", label: "Fresnel’s losses", kind: "flag", preset: true },
    ],
  },
  absorb: { label: "Absorbing", fields: [] },
};

export const LIGHTS: Kinds = {
  "point:intensity": {
    label: "Point, by intensity",
    fixed: { type: "point" },
    fields: [place("position", "Position"), number("intensity", "Intensity", 1, "intensity")],
  },
  "point:power": {
    label: "Point, by power",
    fixed: { type: "point" },
    fields: [place("position", "Position"), number("power", "Power", 12.566, "power")],
  },
  collimated: {
    label: "Collimated beam",
    fields: [axis("direction", "Direction", [0, 0, -1]), number("irradiance", "Irradiance", 1000, "irradiance")],
  },
};

export const APERTURES: Kinds = {
  box: {
    label: "Box",
    fields: [
      { key: "min", label: "From", kind: "triple", unit: "length", preset: [-1, -1, -1] },
      { key: "max", label: "To", kind: "triple", unit: "length", preset: [1, 1, 1] },
    ],
  },
  cylinder: {
    label: "Cylinder",
    fields: [place("point", "Point"), axis("axis", "Axis", [0, 0, 1]), length("radius", "Radius", 1)],
  },
  half_space: { label: "Half space", fields: [place("point", "Point"), axis("normal", "Normal", [0, 0, 1])] },
  expression: { label: "Expression ≤ 0", fields: [text("expression", "Kept where ≤ 0", "x^2 + y^2 - 1")] },
};

export const RECEIVER: Field[] = [
  place("origin", "Centre"), axis("u_axis", "u axis", [1, 0, 0]), axis("v_axis", "v axis", [0, 1, 0]),
  { key: "size", label: "Size", kind: "pair", unit: "length", preset: [8, 8] },
];

const choice = (value: string, label = value) => ({ value, label });

export const UNITS: Field[] = [
  { key: "length_unit", label: "Length unit", kind: "choice", absent: "m", choices: ["m", "cm", "mm", "in", "ft"].map((u) => choice(u)) },
  {
    key: "quantity", label: "Quantity", kind: "choice", absent: "radiometric",
    choices: [choice("radiometric", "radiometric: W/sr, W/m²"), choice("photometric", "photometric: cd, lx")],
  },
];

export const POSE: Field[] = [
  { key: "translate", label: "Shift", kind: "triple", unit: "length", absent: "0" },
];
export const ROTATION: Field[] = [
  { key: "axis", label: "Turned about", kind: "triple", absent: "0 0 1" },
  { key: "degrees", label: "by", kind: "number", unit: "degrees", absent: "0" },
];

export const MEASURES: Field[] = [
  {
    key: "measure", label: "Curves of", kind: "choice", absent: "",
    choices: [choice("", "the total, or else sheets"), choice("total", "the total"), choice("sheet", "each sheet")],
  },
  { key: "direct", label: "Add the direct light", kind: "flag", absent: "false" },
  { key: "certify", label: "Prove that none is missing", kind: "flag", absent: "false" },
];

export const RULE: Field[] = [
  number("count", "Count", 8, "none", { absent: "8" }),
  {
    key: "spacing", label: "Spacing", kind: "choice", absent: "log",
    choices: [choice("log", "logarithmic"), choice("linear"), choice("1-2-5", "1 – 2 – 5")],
  },
  number("min", "From", 0, "irradiance", { absent: "5 %" }),
  number("max", "To", 0, "irradiance", { absent: "95 %" }),
];

export const TOLERANCES: Field[] = [
  number("irradiance", "Irradiance, relative", 1e-9, "none", { absent: "1e-9" }),
  number("chord", "Chord", 0, "length", { absent: "10⁻⁴ of the side" }),
];

export const LIMITS: Field[] = [
  number("time_ms", "Time, ms", 5000, "none", { absent: "5000" }),
  number("vertices", "Vertices", 500000, "none", { absent: "500000" }),
];

/** The kind that an object is, by its members. */
export function kindOf(kinds: Kinds, object: { [key: string]: Json }): string | null {
  const type = String(object["type"] ?? "");
  const names = Object.keys(kinds).filter((name) => name.split(":")[0] === type);
  if (type === "sag") return names.find((name) => name === `sag:${object["kind"]}`) ?? null;
  if (type === "point") return "power" in object ? "point:power" : "point:intensity";
  if (type === "mirror") return "n" in object || "k" in object ? "mirror:metal" : "mirror";
  return names[0] ?? null;
}

/** A new object of this kind; a place that the old one had stays, lengths suit the scene. */
export function made(kinds: Kinds, name: string, old: { [key: string]: Json }, scale: number): { [key: string]: Json } {
  const kind = kinds[name]!;
  const out: { [key: string]: Json } = { type: name, ...kind.fixed };
  const anchor = ["center", "point", "vertex", "origin"].map((key) => old[key]).find((value) => value !== undefined);
  for (const field of kind.fields) {
    if (field.absent !== undefined && field.key === "aspheric") continue;
    const preset = field.preset ?? null;
    const isPlace = field.unit === "length" && field.kind === "triple" && ["center", "point", "vertex", "origin"].includes(field.key);
    if (isPlace && anchor !== undefined) out[field.key] = anchor;
    else if (field.key in old && field.kind !== "json") out[field.key] = old[field.key]!;
    else if (field.unit === "length" && typeof preset === "number") out[field.key] = Number((preset * scale).toPrecision(3));
    else out[field.key] = preset;
  }
  return out;
}
