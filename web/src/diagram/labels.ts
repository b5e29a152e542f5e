// Where levels are written on their curves: where the curve is straight enough, and nothing is in the way.
import type { Vec2 } from "../contract";

export interface Label {
  at: Vec2;
  degrees: number;
}

const APART = 380; // pixels along one curve
const MOST = 3; // on one curve
const LINE_HEIGHT = 14;
const LARGEST_BEND = 0.85; // chord over arc under a label
const SPOT = 30; // pixels of a handle
const TRIES = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.12, 0.88];

export class LabelPlacer {
  private taken: { at: Vec2; width: number }[] = [];

  constructor(
    private readonly free: (at: Vec2, margin: number) => boolean,
    spots: Vec2[],
  ) {
    for (const at of spots) this.taken.push({ at, width: SPOT });
  }

  place(line: Vec2[], width: number): Label[] {
    const arc = arcOf(line);
    const total = arc[arc.length - 1] ?? 0;
    if (total < 1.8 * width) return [];
    const count = Math.min(MOST, Math.max(1, Math.floor(total / APART)));
    const labels: Label[] = [];
    for (let i = 0; i < count; ++i) {
      for (const share of TRIES) {
        const where = (total * (i + share)) / count;
        const label = this.fitting(line, arc, where, width);
        if (!label) continue;
        this.taken.push({ at: label.at, width });
        labels.push(label);
        break;
      }
    }
    return labels;
  }

  private fitting(line: Vec2[], arc: number[], where: number, width: number): Label | null {
    const [at, from, to] = [where, where - width / 2, where + width / 2].map((x) => pointAt(line, arc, x));
    const [dx, dy] = [to![0] - from![0], to![1] - from![1]];
    if (Math.hypot(dx, dy) < LARGEST_BEND * width || !this.free(at!, width / 2 + 4)) return null;
    const near = (other: { at: Vec2; width: number }) =>
      Math.hypot(at![0] - other.at[0], at![1] - other.at[1]) < (width + other.width) / 2 + LINE_HEIGHT;
    if (this.taken.some(near)) return null;
    const degrees = (Math.atan2(dy, dx) * 180) / Math.PI;
    return { at: at!, degrees: degrees > 90 ? degrees - 180 : degrees < -90 ? degrees + 180 : degrees };
  }
}

function arcOf(line: Vec2[]): number[] {
  const arc = [0];
  for (let i = 1; i < line.length; ++i)
    arc.push(arc[i - 1]! + Math.hypot(line[i]![0] - line[i - 1]![0], line[i]![1] - line[i - 1]![1]));
  return arc;
}

function pointAt(line: Vec2[], arc: number[], where: number): Vec2 {
  let low = 0;
  let high = arc.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (arc[middle]! <= where) low = middle;
    else high = middle;
  }
  const step = arc[high]! - arc[low]!;
  const t = step > 0 ? Math.min(1, Math.max(0, (where - arc[low]!) / step)) : 0;
  return [0, 1].map((i) => line[low]![i]! + t * (line[high]![i]! - line[low]![i]!)) as Vec2;
}
