// JSON as people write it: what fits on a line stands on one.
import type { Json } from "./contract";
import { isObject } from "./pointer";

const WIDTH = 76;

export function prettyJson(value: Json, width = WIDTH, indent = ""): string {
  const line = oneLine(value);
  if (indent.length + line.length <= width || (!Array.isArray(value) && !isObject(value))) return line;
  const inner = indent + "  ";
  if (Array.isArray(value))
    return `[\n${value.map((v) => inner + prettyJson(v, width, inner)).join(",\n")}\n${indent}]`;
  const members = Object.entries(value).map(
    ([key, v]) => `${inner}${JSON.stringify(key)}: ${prettyJson(v, width, inner)}`,
  );
  return `{\n${members.join(",\n")}\n${indent}}`;
}

function oneLine(value: Json): string {
  if (Array.isArray(value)) return `[${value.map(oneLine).join(", ")}]`;
  if (!isObject(value)) return JSON.stringify(value);
  const members = Object.entries(value).map(([key, v]) => `${JSON.stringify(key)}: ${oneLine(v)}`);
  return members.length ? `{ ${members.join(", ")} }` : "{}";
}
