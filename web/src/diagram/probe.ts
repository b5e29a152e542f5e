// What a light meter under the cursor reads: one question at a time, the latest.
import { read } from "../api";
import type { Reading, Vec2 } from "../contract";
import { h, s, set } from "../dom";
import { format } from "../numbers";
import { dot, irradianceUnit, length, lengthUnit, receiverOf } from "../scene";
import type { Store } from "../state";
import type { View } from "./view";

const ARROW = 34; // pixels
const KEY_STEP = 0.02; // of the plot

export class Probe {
  readonly group = s("g", { class: "probe", visibility: "hidden" });
  private readonly cross = s("path", { class: "cross" });
  private readonly arrow = s("path", { class: "arrow" });
  private spot: Vec2 | null = null;
  private asking = false;
  private asked: unknown = null;

  constructor(
    private readonly store: Store,
    private readonly view: View,
    private readonly output: HTMLElement,
  ) {
    this.group.append(this.cross, this.arrow);
    this.say(null);
  }

  lookAt(uv: Vec2 | null): void {
    const receiver = receiverOf(this.store.now.request);
    const on = uv && receiver && Math.abs(uv[0]) <= receiver.size[0] / 2 && Math.abs(uv[1]) <= receiver.size[1] / 2;
    if (!on && !this.spot) return;
    this.spot = on ? uv : null;
    this.place();
    if (this.spot) void this.ask();
    else this.say(null);
  }

  /** By keyboard, from the middle. */
  step(dx: number, dy: number): void {
    const [x, y] = this.spot ? this.view.toPixel(this.spot) : this.view.middle;
    const { left, top, plotWidth, plotHeight } = this.view;
    const clamp = (a: number, from: number, span: number) => Math.min(from + span, Math.max(from, a));
    const to: Vec2 = [
      clamp(x + dx * KEY_STEP * plotWidth, left, plotWidth),
      clamp(y + dy * KEY_STEP * plotHeight, top, plotHeight),
    ];
    this.lookAt(this.view.toPlane(to));
  }

  place(): void {
    this.group.setAttribute("visibility", this.spot ? "visible" : "hidden");
    if (!this.spot) return;
    const [x, y] = this.view.toPixel(this.spot);
    set(this.group, { transform: `translate(${x} ${y})` });
    set(this.cross, { d: "M-9 0H-3M3 0H9M0-9V-3M0 3V9" });
  }

  private async ask(): Promise<void> {
    if (this.asking || this.store.now.dragging) return;
    this.asking = true;
    while (this.spot && this.spot !== this.asked) {
      this.asked = this.spot;
      try {
        this.say((await read(this.store.now.request, [this.spot]))[0]!);
      } catch {
        this.say(null); // the request has faults, which are told elsewhere
      }
    }
    this.asking = false;
  }

  private say(reading: Reading | null): void {
    this.store.set({ reading });
    const receiver = receiverOf(this.store.now.request);
    set(this.arrow, { d: "" });
    if (!reading || !receiver || !this.spot) {
      this.output.replaceChildren(h("span", { class: "faint" }, "Point at the diagram to read E, ∇E and the sheets there."));
      return;
    }
    const unit = irradianceUnit(this.store.now.request);
    const metre = lengthUnit(this.store.now.request);
    const [gu, gv] = [dot(reading.gradient, receiver.u), dot(reading.gradient, receiver.v)];
    const steepness = length(reading.gradient);
    if (steepness > 0 && !reading.on_caustic) {
      const [x, y] = [(gu / steepness) * ARROW, (-gv / steepness) * ARROW];
      const [a, b] = [x * 0.22, y * 0.22];
      set(this.arrow, {
        d: `M${x * 0.35} ${y * 0.35}L${x} ${y}M${x - a - b} ${y - b + a}L${x} ${y}L${x - a + b} ${y - b - a}`,
      });
    }
    const item = (name: string, value: string) => h("span", {}, h("dfn", {}, name), ` ${value}`);
    const light = reading.E === null ? "unbounded (caustic)" : `${format(reading.E, 4)} ${unit}`;
    this.output.replaceChildren(
      item("E", light),
      item("|∇E|", `${format(steepness)} ${unit}/${metre}`),
      item("sheets", String(reading.sheets.length)),
      item("at", `${format(reading.uv[0])}, ${format(reading.uv[1])} ${metre}`),
    );
  }
}
