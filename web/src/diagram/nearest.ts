// The curve next to a point of the receiver.
import type { CurveFeature, Vec2 } from "../contract";

function distance([x, y]: Vec2, [ax, ay]: Vec2, [bx, by]: Vec2): number {
  const [dx, dy] = [bx - ax, by - ay];
  const t = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(x - ax - t * dx, y - ay - t * dy);
}

/** Null if none is within `reach`. */
export function nearest(features: CurveFeature[], point: Vec2, reach: number): CurveFeature | null {
  let best: CurveFeature | null = null;
  let least = reach;
  for (const feature of features) {
    if (feature.properties.kind !== "isolux") continue;
    const line = feature.geometry.coordinates;
    for (let i = 1; i < line.length; ++i) {
      const d = distance(point, line[i - 1]!, line[i]!);
      if (d < least) [least, best] = [d, feature];
    }
  }
  return best;
}

/** About `count` points along a line, by its length. */
export function spread(line: Vec2[], count: number): Vec2[] {
  const arc = [0];
  for (let i = 1; i < line.length; ++i)
    arc.push(arc[i - 1]! + Math.hypot(line[i]![0] - line[i - 1]![0], line[i]![1] - line[i - 1]![1]));
  const out: Vec2[] = [];
  for (let i = 0, k = 0; k < count; ++k) {
    while (i < line.length - 1 && arc[i]! < (arc[arc.length - 1]! * k) / count) ++i;
    out.push(line[i]!);
  }
  return out;
}
