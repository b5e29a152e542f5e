// Curves as SVG path data in receiver coordinates, gathered by what is drawn alike.
import type { CurveCollection, CurveFeature, Vec2 } from "../contract";

export interface LevelPaths {
  level: number;
  /** The region that is at least as bright, where the answer has rings. */
  fill: string;
  isolux: string;
  jump: string;
  lines: Vec2[][];
}

export interface Paths {
  levels: LevelPaths[];
  caustic: string;
  boundary: string;
}

export function pathsOf(curves: CurveCollection, side: number): Paths {
  const digits = Math.max(0, Math.ceil(6 - Math.log10(side)));
  const line = (points: Vec2[]) => "M" + points.map(([u, v]) => `${u.toFixed(digits)} ${v.toFixed(digits)}`).join("L");
  const all = (kind: string, of: CurveFeature[]) =>
    of
      .filter((f) => f.properties.kind === kind)
      .map((f) => line(f.geometry.coordinates))
      .join("");
  const byLevel = new Map<number, CurveFeature[]>();
  for (const feature of curves.features) {
    const { level, kind } = feature.properties;
    if (level === null || level <= 0 || kind === "boundary") continue;
    byLevel.set(level, [...(byLevel.get(level) ?? []), feature]);
  }
  const levels = [...byLevel].sort(([a], [b]) => a - b);
  return {
    levels: levels.map(([level, features]) => ({
      level,
      fill: ringsOf(features).map((ring) => line(ring) + "Z").join(""),
      isolux: all("isolux", features),
      jump: all("jump", features),
      lines: features.filter((f) => f.properties.kind === "isolux").map((f) => f.geometry.coordinates),
    })),
    caustic: all("caustic", curves.features),
    boundary: all("boundary", curves.features),
  };
}

/** Closed lines, their curves put together head to tail. */
function ringsOf(features: CurveFeature[]): Vec2[][] {
  const rings = new Map<number, CurveFeature[]>();
  for (const feature of features) {
    const id = feature.properties.ring_id;
    if (id !== undefined && id >= 0) rings.set(id, [...(rings.get(id) ?? []), feature]);
  }
  return [...rings.values()].map((parts) =>
    parts
      .sort((a, b) => (a.properties.ring_order ?? 0) - (b.properties.ring_order ?? 0))
      .flatMap((f) => f.geometry.coordinates),
  );
}
