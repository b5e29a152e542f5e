// Lines with a width, of many pieces at once.
import { Color } from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import type { Vec3 } from "../contract";

export interface LineStyle {
  colour: string;
  width: number;
  opacity?: number;
  /** Length of dashes, in the scene's unit. */
  dash?: number;
}

export function linesOf(lines: Vec3[][], { colour, width, opacity = 1, dash }: LineStyle): LineSegments2 {
  const positions: number[] = [];
  for (const line of lines)
    for (let i = 1; i < line.length; ++i) positions.push(...line[i - 1]!, ...line[i]!);
  const material = new LineMaterial({ linewidth: width, transparent: opacity < 1, opacity, dashed: dash !== undefined });
  material.color = new Color(colour);
  if (dash !== undefined) [material.dashSize, material.gapSize] = [dash, 0.6 * dash];
  const object = new LineSegments2(new LineSegmentsGeometry().setPositions(positions), material);
  if (dash !== undefined) object.computeLineDistances();
  return object;
}
