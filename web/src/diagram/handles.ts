// Light and surfaces as they stand above the receiver, to be dragged along it; with Shift, away from it.
// By keyboard: arrows, Page Up and Page Down; ten times as far with Shift.
import type { Vec2, Vec3 } from "../contract";
import { s, set } from "../dom";
import { format } from "../numbers";
import { inWorld, lengthUnit, minus, moved, receiverOf, thingsOf, toPlane, type Receiver, type Thing } from "../scene";
import type { Store } from "../state";
import type { View } from "./view";

const KEY_STEP = 0.01; // of the receiver's larger side
const ROUNDING = 1e-4; // of the receiver's larger side
const INSET = 14; // from the frame, for what stands outside of it

const SIGNS: Record<Thing["kind"], string> = {
  light: "M0-11V-7M0 7V11M-11 0H-7M7 0H11M-8-8-5-5M8 8 5 5M-8 8-5 5M8-8 5-5M4 0A4 4 0 1 1-4 0 4 4 0 1 1 4 0",
  beam: "M-9-5H4M-9 0H9M-9 5H4M5-4 9 0 5 4",
  surface: "M-8 0A8 8 0 1 1 8 0 8 8 0 1 1-8 0M-3 0H3M0-3V3",
};

export class Handles {
  readonly group = s("g", { class: "handles" });
  private shown = "";

  constructor(
    private readonly store: Store,
    private readonly view: View,
    private readonly pixelOf: (event: PointerEvent) => Vec2,
  ) {}

  place(): void {
    const { request } = this.store.now;
    const receiver = receiverOf(request);
    const things = receiver ? thingsOf(request).reverse() : []; // the light on top
    const kinds = things.map((t) => `${t.pointer} ${t.name} ${t.kind}`).join("\n");
    if (kinds !== this.shown) {
      this.shown = kinds;
      this.group.replaceChildren(...things.map((thing) => this.make(thing)));
    }
    things.forEach((thing, i) => this.put(this.group.children[i]!, thing, receiver!));
  }

  /** Where nothing else should be written. */
  get spots(): Vec2[] {
    const receiver = receiverOf(this.store.now.request);
    return receiver ? thingsOf(this.store.now.request).map((thing) => this.view.toPixel(spotOf(thing, receiver))) : [];
  }

  private put(handle: Element, thing: Thing, receiver: Receiver): void {
    const { left, top, plotWidth, plotHeight } = this.view;
    const [x, y] = this.view.toPixel(spotOf(thing, receiver));
    const clamp = (a: number, from: number, span: number) => Math.min(from + span - INSET, Math.max(from + INSET, a));
    const at = [clamp(x, left, plotWidth), clamp(y, top, plotHeight)];
    handle.classList.toggle("outside", at[0] !== x || at[1] !== y);
    const unit = thing.kind === "beam" ? "" : ` ${lengthUnit(this.store.now.request)}`;
    const where = thing.at.map((c) => format(c)).join(", ");
    set(handle, {
      transform: `translate(${at[0]} ${at[1]})`,
      "aria-label": `${thing.name || thing.kind} at ${where}${unit}. Arrow keys, Page Up and Page Down move it.`,
    });
    handle.querySelector("title")!.textContent = `${thing.name}: ${where}${unit} — drag; Shift: off the receiver`;
  }

  private make(thing: Thing): SVGGElement {
    const handle = s(
      "g",
      { class: `handle ${thing.kind}`, tabindex: 0, role: "button", "data-pointer": thing.pointer },
      s("title"),
      s("circle", { r: 18, class: "grip" }),
      s("path", { d: SIGNS[thing.kind], class: "halo" }),
      s("path", { d: SIGNS[thing.kind] }),
      s("text", { x: 13, y: thing.kind === "surface" ? 15 : -7 }, thing.name),
    );
    const now = () => thingsOf(this.store.now.request).find((t) => t.pointer === thing.pointer);
    handle.addEventListener("pointerdown", (event) => {
      const start = now();
      if (event.button === 0 && start) this.drag(handle, event, start);
    });
    handle.addEventListener("keydown", (event) => {
      const start = now();
      if (start) this.nudge(event, start);
    });
    handle.addEventListener("keyup", () => this.rest());
    handle.addEventListener("blur", () => this.rest());
    return handle;
  }

  private drag(handle: SVGGElement, down: PointerEvent, thing: Thing): void {
    down.stopPropagation();
    down.preventDefault();
    handle.focus();
    handle.setPointerCapture(down.pointerId);
    const { request } = this.store.now;
    const receiver = receiverOf(request)!;
    const from = this.pixelOf(down);
    const move = (event: PointerEvent) => {
      const to = this.pixelOf(event);
      const [du, dv] = [(to[0] - from[0]) / this.view.scale, (from[1] - to[1]) / this.view.scale];
      const by = event.shiftKey ? ([0, 0, dv] as Vec3) : ([du, dv, 0] as Vec3);
      this.store.edit(moved(request, thing, worldStep(thing, receiver, by), rounding(receiver, thing)), true);
    };
    const end = () => {
      handle.removeEventListener("pointermove", move);
      handle.removeEventListener("pointerup", end);
      handle.removeEventListener("pointercancel", end);
      this.rest();
    };
    handle.addEventListener("pointermove", move);
    handle.addEventListener("pointerup", end);
    handle.addEventListener("pointercancel", end);
  }

  private nudge(event: KeyboardEvent, thing: Thing): void {
    const ways: Record<string, Vec3> = {
      ArrowLeft: [-1, 0, 0],
      ArrowRight: [1, 0, 0],
      ArrowDown: [0, -1, 0],
      ArrowUp: [0, 1, 0],
      PageDown: [0, 0, -1],
      PageUp: [0, 0, 1],
    };
    const way = ways[event.key];
    const { request } = this.store.now;
    const receiver = receiverOf(request);
    if (!way || !receiver) return;
    event.preventDefault();
    event.stopPropagation();
    const step = KEY_STEP * Math.max(...receiver.size) * (event.shiftKey ? 10 : 1);
    const by = worldStep(thing, receiver, way.map((w) => w * step) as Vec3);
    this.store.edit(moved(request, thing, by, rounding(receiver, thing)), true);
  }

  private rest(): void {
    if (this.store.now.dragging) this.store.set({ dragging: false });
  }
}

/** A beam's handle lies where the light seems to come from, seen from the middle. */
function spotOf(thing: Thing, receiver: Receiver): Vec2 {
  if (thing.kind !== "beam") return toPlane(receiver, thing.at);
  const from = toPlane(receiver, minus(receiver.origin, thing.at));
  const half = beamReach(receiver);
  return [from[0] * half, from[1] * half];
}

const beamReach = (receiver: Receiver) => 0.4 * Math.min(...receiver.size);

function worldStep(thing: Thing, receiver: Receiver, by: Vec3): Vec3 {
  if (thing.kind !== "beam") return inWorld(receiver, ...by);
  return inWorld(receiver, ...(by.map((c) => -c / beamReach(receiver)) as Vec3));
}

const rounding = (receiver: Receiver, thing: Thing) =>
  thing.kind === "beam" ? ROUNDING : ROUNDING * Math.max(...receiver.size);
