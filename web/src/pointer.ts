// JSON pointers (RFC 6901), and documents changed by copying what lies on the way.
import type { Json, JsonObject } from "./contract";

export function steps(pointer: string): string[] {
  return pointer
    .split("/")
    .slice(1)
    .map((step) => step.replaceAll("~1", "/").replaceAll("~0", "~"));
}

export function join(pointer: string, ...more: (string | number)[]): string {
  return more.reduce<string>(
    (at, step) => `${at}/${String(step).replaceAll("~", "~0").replaceAll("/", "~1")}`,
    pointer,
  );
}

export function isObject(value: Json | undefined): value is JsonObject {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

export function get(document: Json | undefined, pointer: string): Json | undefined {
  let at: Json | undefined = document;
  for (const step of steps(pointer)) {
    if (Array.isArray(at)) at = at[Number(step)];
    else if (isObject(at)) at = at[step];
    else return undefined;
  }
  return at;
}

/** A copy with `value` at `pointer`; without that member if it is undefined. */
export function withValue<T extends Json>(document: T, pointer: string, value: Json | undefined): T {
  return change(document, steps(pointer), value) as T;
}

function change(at: Json | undefined, path: string[], value: Json | undefined): Json | undefined {
  const [step, ...rest] = path;
  if (step === undefined) return value;
  if (Array.isArray(at)) {
    const copy = [...at];
    const inner = change(copy[Number(step)], rest, value);
    if (inner === undefined) copy.splice(Number(step), 1);
    else copy[Number(step)] = inner;
    return copy;
  }
  const copy: JsonObject = isObject(at) ? { ...at } : {};
  const inner = change(copy[step], rest, value);
  if (inner === undefined) delete copy[step];
  else copy[step] = inner;
  return copy;
}
