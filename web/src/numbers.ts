// Numbers for people.
const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

function superscript(n: number): string {
  const digits = [...String(Math.abs(n))].map((d) => SUPERSCRIPTS[Number(d)]).join("");
  return n < 0 ? `⁻${digits}` : digits;
}

/** `digits` significant ones; powers of ten where zeros would be in the way. */
export function format(x: number, digits = 3): string {
  if (!Number.isFinite(x)) return "∞";
  if (x === 0) return "0";
  const exponent = Math.floor(Math.log10(Math.abs(x)) + 1e-12);
  if (exponent >= -3 && exponent < 5) return minus(trimmed(x.toPrecision(digits)));
  const [mantissa = "", power = "0"] = x.toExponential(digits - 1).split("e");
  const m = trimmed(mantissa);
  const tens = `10${superscript(Number(power))}`;
  return minus(m === "1" ? tens : `${m}·${tens}`);
}

/** Of the digits from `least` on, as few as tell these numbers apart. */
export function digitsFor(values: number[], least: number): number {
  const apart = (digits: number) => new Set(values.map((x) => x.toPrecision(digits))).size === new Set(values).size;
  let digits = least;
  while (digits < 12 && !apart(digits)) ++digits;
  return digits;
}

function trimmed(text: string): string {
  const plain = text.includes("e") ? String(Number(text)) : text;
  return plain.includes(".") ? plain.replace(/\.?0+$/, "") : plain;
}

function minus(text: string): string {
  return text.replace(/^-/, "−");
}

/** What a document keeps of a number that was dragged. */
export function rounded(x: number, step: number): number {
  const digits = Math.min(15, Math.max(0, Math.ceil(-Math.log10(step))));
  return Number(x.toFixed(digits)) || 0;
}

export function significant(x: number, digits: number): number {
  return Number(x.toPrecision(digits));
}

/** About `count` round numbers in [from, to], and the digits that tell them apart. */
export function ticks(from: number, to: number, count: number): { values: number[]; label: (x: number) => string } {
  const raw = (to - from) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5, 10].find((m) => m * power >= raw) ?? 10);
  const values: number[] = [];
  for (let i = Math.ceil(from / step - 1e-9); i * step <= to + 1e-9 * step; ++i) values.push(i * step);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const wide = Math.max(Math.abs(from), Math.abs(to));
  const label = (x: number) =>
    wide >= 1e5 || step < 1e-4 ? format(Math.abs(x) < step / 2 ? 0 : x) : minus(x.toFixed(digits));
  return { values, label };
}
