// Lists as people write them: levels with blanks between, one family a line.
import type { Json } from "../contract";
import type { Field } from "./fields";

export const LEVELS = {
  field: (unit: string): Field => ({ key: "levels", label: `Levels in ${unit}`, kind: "json" }),
  write: (value: Json | undefined) => (Array.isArray(value) ? value.map(String).join("  ") : ""),
  read(text: string): Json {
    const words = text.split(/[\s,;]+/).filter(Boolean);
    const wrong = words.find((word) => !Number.isFinite(Number(word)));
    if (wrong !== undefined) throw new Error(`${wrong} is not a number`);
    return words.map(Number);
  },
};

export const FAMILIES = {
  field: (): Field => ({ key: "families", label: "Surfaces in the order of the light, a family a line", kind: "json" }),
  write: (value: Json | undefined) =>
    Array.isArray(value) ? value.map((family) => (Array.isArray(family) ? family.join(", ") : "")).join("\n") : "",
  read: (text: string): Json =>
    text
      .split("\n")
      .filter((line) => line.trim() !== "")
      .map((line) => line.split(",").map((name) => name.trim())),
};
