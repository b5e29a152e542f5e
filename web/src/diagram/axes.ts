// The frame of the plot: ticks, their numbers, the unit.
import { s, set } from "../dom";
import { ticks } from "../numbers";
import type { View } from "./view";

const TICK = 5;
const PIXELS_A_TICK = 80;
const FEWEST_TICKS = 4;

export function drawAxes(group: SVGGElement, view: View, unit: string): void {
  const { left, top, plotWidth: w, plotHeight: h } = view;
  const [right, bottom] = [left + w, top + h];
  const parts: SVGElement[] = [];
  const text = (x: number, y: number, label: string, anchor: string, name = "tick") =>
    parts.push(s("text", { x, y, class: name, "text-anchor": anchor }, label));
  const line = (x1: number, y1: number, x2: number, y2: number) =>
    parts.push(s("path", { d: `M${x1} ${y1}L${x2} ${y2}` }));
  const low = view.toPlane([left, bottom]);
  const high = view.toPlane([right, top]);
  const across = ticks(low[0], high[0], Math.max(FEWEST_TICKS, w / PIXELS_A_TICK));
  for (const u of across.values) {
    const [x] = view.toPixel([u, 0]);
    line(x, bottom, x, bottom + TICK);
    text(x, bottom + 18, across.label(u), "middle");
  }
  const up = ticks(low[1], high[1], Math.max(FEWEST_TICKS, h / PIXELS_A_TICK));
  for (const v of up.values) {
    const [, y] = view.toPixel([0, v]);
    line(left - TICK, y, left, y);
    text(left - 9, y + 4, up.label(v), "end");
  }
  const frame = s("rect", { x: left, y: top, width: w, height: h, class: "frame" });
  text(left + w / 2, bottom + 37, `u / ${unit}`, "middle", "axis");
  const v = s("text", { class: "axis", "text-anchor": "middle" }, `v / ${unit}`);
  set(v, { transform: `translate(${left - 54} ${top + h / 2}) rotate(-90)` });
  group.replaceChildren(frame, ...parts, v);
}
