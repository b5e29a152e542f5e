// Cividis: one order of brightness, the same for all kinds of colour vision.
// Ten anchors of the map of Nuñez, Anderton and Renslow, PLoS ONE 13(7), 2018; linear between.
const ANCHORS: [number, number, number][] = [
  [0, 32, 77], [0, 51, 111], [57, 72, 107], [87, 92, 109], [112, 113, 115],
  [138, 135, 121], [166, 157, 117], [196, 181, 108], [228, 207, 91], [255, 234, 70],
];

export function cividis(t: number): string {
  const at = Math.min(1, Math.max(0, t)) * (ANCHORS.length - 1);
  const i = Math.min(ANCHORS.length - 2, Math.floor(at));
  const [a, b] = [ANCHORS[i]!, ANCHORS[i + 1]!];
  const mixed = a.map((x, c) => Math.round(x + (at - i) * (b[c]! - x)));
  return `rgb(${mixed.join(", ")})`;
}

/** The place of a level among the others, 0 to 1, by its logarithm. */
export function placeOf(levels: number[]): (level: number) => number {
  const low = Math.log(Math.min(...levels));
  const high = Math.log(Math.max(...levels));
  return (level) => (high > low ? (Math.log(level) - low) / (high - low) : 1);
}
