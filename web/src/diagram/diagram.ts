// The receiver plane as an isolux diagram.
import type { Vec2 } from "../contract";
import { s, set } from "../dom";
import { lengthUnit, receiverOf } from "../scene";
import type { Store, Traced } from "../state";
import { drawAxes } from "./axes";
import { CurveLayers } from "./curves";
import { addGestures, zoomByKey } from "./gestures";
import { Handles } from "./handles";
import { pathsOf } from "./paths";
import { Picker } from "./picker";
import { Probe } from "./probe";
import { View } from "./view";

export class Diagram {
  readonly view = new View();
  private readonly probe: Probe;
  private readonly svg = s("svg", { class: "diagram", tabindex: 0, role: "application" });
  private readonly clip = s("rect");
  private readonly ground = s("rect", { class: "ground" });
  private readonly receiver = s("rect", { class: "receiver" });
  private readonly axes = s("g", { class: "axes", "aria-hidden": "true" });
  private readonly layers = new CurveLayers();
  private readonly handles: Handles;
  private readonly picker: Picker;
  private drawn: Traced | null = null;
  private updates = 0;
  private frame = 0;
  private framed = "";

  constructor(
    private readonly store: Store,
    private readonly parent: HTMLElement,
    reading: HTMLElement,
  ) {
    this.handles = new Handles(store, this.view, (event) => this.pixelOf(event));
    this.probe = new Probe(store, this.view, reading);
    this.picker = new Picker(store, this.view);
    this.svg.append(
      s("defs", {}, s("clipPath", { id: "plot" }, this.clip)),
      this.ground,
      s("g", { "clip-path": "url(#plot)" }, this.receiver, this.layers.group, this.layers.labels, this.probe.group),
      this.axes,
      this.handles.group,
    );
    set(this.svg, { "aria-label": "Isolux diagram of the receiver. Arrow keys move the meter, + and − zoom, 0 shows all." });
    parent.append(this.svg);
    new ResizeObserver(() => this.draw()).observe(parent);
    addGestures(this.svg, this.view, (event) => this.pixelOf(event), () => this.draw());
    this.listen();
  }

  /** Draws once before the next frame, however often it is asked to. */
  draw(): void {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.drawNow();
    });
  }

  /** From another view of the receiver. */
  pointAt(uv: Vec2 | null): void {
    this.probe.lookAt(uv);
    this.picker.hover(uv);
  }

  zoom(key: "+" | "-" | "0"): void {
    zoomByKey(key, this.view);
    this.draw();
  }

  private listen(): void {
    this.store.watch(["request", "traced"], () => this.draw());
    this.store.watch(["stressed"], ({ stressed }) => this.layers.stress(stressed));
    this.svg.addEventListener("pointermove", (event) => {
      if (!this.store.now.dragging) this.pointAt(this.view.toPlane(this.pixelOf(event)));
    });
    this.svg.addEventListener("pointerleave", () => this.pointAt(null));
    this.svg.addEventListener("click", () => void this.picker.pick());
    this.svg.addEventListener("keydown", (event) => {
      if (event.target !== this.svg || event.ctrlKey || event.metaKey) return;
      const ways: Record<string, Vec2> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      const way = ways[event.key];
      if (way) this.probe.step(...way);
      else if (zoomByKey(event.key, this.view)) this.draw();
      else return;
      event.preventDefault();
    });
  }

  private pixelOf(event: MouseEvent): Vec2 {
    const box = this.svg.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  private drawNow(): void {
    const { request, traced } = this.store.now;
    const { view } = this;
    view.width = this.parent.clientWidth;
    view.height = this.parent.clientHeight;
    const size = receiverOf(request)?.size;
    if (size) view.show(size);
    set(this.svg, { width: view.width, height: view.height });
    this.svg.classList.toggle("zoomed", view.zoom > 1);
    const plot = { x: view.left, y: view.top, width: view.plotWidth, height: view.plotHeight };
    set(this.clip, plot);
    set(this.ground, plot);
    const [w, h] = size ?? [0, 0];
    const [x, y] = view.toPixel([-w / 2, h / 2]);
    set(this.receiver, { x, y, width: w * view.scale, height: h * view.scale });
    this.drawFrame(lengthUnit(request));
    if (traced && traced !== this.drawn) this.take(traced);
    this.layers.place(view);
    this.layers.write(view, this.handles.spots);
    this.handles.place();
    this.probe.place();
    // For tests, and for who waits for the exact curves of what is asked now.
    set(this.svg, { "data-settled": String(traced?.request === request && !traced.coarse) });
  }

  /** While curves follow a drag it stays as it is. */
  private drawFrame(unit: string): void {
    const { view } = this;
    const key = `${view.width} ${view.height} ${view.transform} ${unit}`;
    if (key !== this.framed) drawAxes(this.axes, view, unit);
    this.framed = key;
  }

  private take(traced: Traced): void {
    this.drawn = traced;
    this.layers.show(pathsOf(traced.curves, Math.max(...(receiverOf(traced.request)?.size ?? [1, 1]))));
    this.updates += 1;
    set(this.svg, {
      "data-updates": this.updates,
      "data-vertices": traced.answer.curves.reduce((sum, curve) => sum + curve.vertices, 0),
      "data-coarse": String(traced.coarse),
    });
  }
}
