// The legend: the levels on a logarithmic scale, each with its colour. A level is moved by dragging it or by
// the arrow keys, added by a double click, removed by Delete.
import { cividis, placeOf } from "./colours";
import { s, set } from "./dom";
import { digitsFor, format, significant } from "./numbers";
import { irradianceUnit } from "./scene";
import type { Store, Traced } from "./state";

const HEIGHT = 260;
const ENDS = 14; // pixels beyond the last levels
const BEYOND = 0.1; // how far beyond the levels the scale reaches, as a share of their logarithms' range
const ALONE = 2; // as a factor, for a single one
const LABEL_HEIGHT = 14;
const KEY_STEP = 1.05;
const DIGITS = 4;
const STOPS = 24; // of the gradient

export class LevelsBar {
  private readonly svg: SVGSVGElement;
  private levels: number[] = [];
  private range: [number, number] = [1e-3, 1];
  private moving: number | null = null;

  constructor(
    private readonly store: Store,
    parent: HTMLElement,
    title: HTMLElement,
  ) {
    this.svg = s("svg", { class: "levels", width: "100%", height: HEIGHT, role: "group", "aria-label": "Levels" });
    parent.append(this.svg);
    store.watch(["traced", "request"], ({ traced, request }) => {
      title.textContent = `Irradiance, ${irradianceUnit(request)}`;
      if (this.moving === null && traced) this.take(traced);
    });
    this.svg.addEventListener("dblclick", (event) => this.add(this.levelAt(event)));
  }

  private stress(level: number | null): void {
    this.store.set({ stressed: level });
  }

  private take(traced: Traced): void {
    const asked = traced.request["levels"];
    const found = traced.answer.curves.map((c) => c.level);
    const all = (Array.isArray(asked) ? asked : found).filter((l): l is number => typeof l === "number" && l > 0);
    this.levels = [...new Set(all)].sort((a, b) => a - b);
    if (!this.levels.length) this.range = [1e-3, 1];
    else {
      const [first, last] = [this.levels[0]!, this.levels[this.levels.length - 1]!];
      const beyond = last > first ? (last / first) ** BEYOND : ALONE;
      this.range = [first / beyond, last * beyond];
    }
    this.draw();
  }

  private y(level: number): number {
    const [low, high] = this.range.map(Math.log) as [number, number];
    return HEIGHT - ENDS - ((Math.log(level) - low) / (high - low)) * (HEIGHT - 2 * ENDS);
  }

  private levelAt(event: MouseEvent): number {
    const y = event.clientY - this.svg.getBoundingClientRect().top;
    const [low, high] = this.range.map(Math.log) as [number, number];
    return significant(Math.exp(low + ((HEIGHT - ENDS - y) / (HEIGHT - 2 * ENDS)) * (high - low)), DIGITS);
  }

  private draw(): void {
    const place = placeOf(this.levels);
    const focused = [...this.svg.querySelectorAll(".level")].findIndex((e) => e === document.activeElement);
    let free = Infinity; // below which the next label has room
    const rows = this.levels.map((level, i) => {
      const y = this.y(level);
      const shown = y + LABEL_HEIGHT <= free;
      if (shown) free = y;
      return this.row(level, i, y, cividis(place(level)), shown);
    });
    const stops = Array.from({ length: STOPS + 1 }, (_, i) =>
      s("stop", { offset: i / STOPS, "stop-color": cividis(this.shade(i / STOPS)) }));
    this.svg.replaceChildren(
      s("defs", {}, s("linearGradient", { id: "shades", x1: 0, x2: 0, y1: 1, y2: 0 }, ...stops)),
      s("rect", { x: 0, y: ENDS, width: 14, height: HEIGHT - 2 * ENDS, fill: "url(#shades)" }),
      ...rows,
    );
    if (focused >= 0) (this.svg.querySelectorAll<SVGElement>(".level")[focused] ?? null)?.focus();
  }

  /** The colour along the bar, where that of the levels begins and ends with them. */
  private shade(share: number): number {
    const [low, high] = this.range.map(Math.log) as [number, number];
    if (this.levels.length < 2) return share;
    return placeOf(this.levels)(Math.exp(low + share * (high - low)));
  }

  private row(level: number, index: number, y: number, colour: string, labelled: boolean): SVGGElement {
    const row = s(
      "g",
      {
        class: "level", tabindex: 0, role: "slider", transform: `translate(0 ${y})`,
        "aria-label": `Level ${index + 1}`, "aria-orientation": "vertical", "aria-valuenow": level,
        "aria-valuemin": this.range[0], "aria-valuemax": this.range[1],
        "aria-valuetext": `${format(level)} ${irradianceUnit(this.store.now.request)}`,
      },
      s("rect", { x: -2, y: -7, width: 140, height: 14, class: "grip" }),
      s("path", { d: "M0 0H24", class: "line" }),
      s("circle", { cx: 24, cy: 0, r: 4.5, fill: colour }),
      labelled && s("text", { x: 36, y: 4 }, format(level, digitsFor(this.levels, 3))),
    );
    row.addEventListener("pointerdown", (event) => this.drag(event, index));
    row.addEventListener("pointerenter", () => this.stress(level));
    row.addEventListener("pointerleave", () => this.moving ?? this.stress(null));
    row.addEventListener("focus", () => this.stress(level));
    row.addEventListener("blur", () => this.stress(null));
    row.addEventListener("keydown", (event) => this.key(event, index));
    row.addEventListener("keyup", () => this.store.now.dragging && this.store.set({ dragging: false }));
    return row;
  }

  private drag(down: PointerEvent, index: number): void {
    if (down.button !== 0) return;
    down.preventDefault();
    this.moving = index;
    this.svg.setPointerCapture(down.pointerId);
    const move = (event: PointerEvent) => this.change(index, this.levelAt(event), true);
    const end = () => {
      this.svg.removeEventListener("pointermove", move);
      this.svg.removeEventListener("pointerup", end);
      this.svg.removeEventListener("pointercancel", end);
      this.moving = null;
      this.stress(null);
      if (this.store.now.dragging) this.store.set({ dragging: false });
    };
    this.svg.addEventListener("pointermove", move);
    this.svg.addEventListener("pointerup", end);
    this.svg.addEventListener("pointercancel", end);
  }

  private key(event: KeyboardEvent, index: number): void {
    const factor = { ArrowUp: KEY_STEP, ArrowRight: KEY_STEP, ArrowDown: 1 / KEY_STEP, ArrowLeft: 1 / KEY_STEP }[event.key];
    if (factor) this.change(index, significant(this.levels[index]! * factor, DIGITS), true);
    else if (event.key === "Delete" && this.levels.length > 1)
      this.store.edit({ ...this.store.now.request, levels: this.levels.filter((_, i) => i !== index) });
    else return;
    event.preventDefault();
  }

  private change(index: number, level: number, dragging: boolean): void {
    this.levels[index] = level;
    const row = this.svg.querySelectorAll(".level")[index];
    if (row) {
      set(row, { transform: `translate(0 ${this.y(level)})`, "aria-valuenow": level });
      const text = row.querySelector("text");
      if (text) text.textContent = format(level, DIGITS);
    }
    this.store.edit({ ...this.store.now.request, levels: [...this.levels].sort((a, b) => a - b) }, dragging);
  }

  private add(level: number): void {
    this.store.edit({ ...this.store.now.request, levels: [...this.levels, level].sort((a, b) => a - b) });
  }
}
