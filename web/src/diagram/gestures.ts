// Zoom and pan: wheel, two fingers, dragging the ground, + − 0.
import type { Vec2 } from "../contract";
import type { View } from "./view";

const WHEEL = 0.0015;
const KEY_ZOOM = 1.5;

export function addGestures(
  target: SVGSVGElement,
  view: View,
  pixelOf: (event: MouseEvent) => Vec2,
  changed: () => void,
): void {
  const fingers = new Map<number, Vec2>();

  target.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      view.zoomAt(pixelOf(event), Math.exp(-event.deltaY * WHEEL));
      changed();
    },
    { passive: false },
  );
  target.addEventListener("dblclick", () => (view.reset(), changed()));
  target.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    fingers.set(event.pointerId, pixelOf(event));
    target.setPointerCapture(event.pointerId);
  });
  target.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = pixelOf(event);
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    fingers.set(event.pointerId, now);
    if (other) {
      const apart = (a: Vec2) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
      view.zoomAt([(now[0] + other[0]) / 2, (now[1] + other[1]) / 2], apart(now) / apart(before));
    } else if (view.zoom > 1) view.panBy(now[0] - before[0], now[1] - before[1]);
    else return;
    changed();
  });
  for (const end of ["pointerup", "pointercancel"] as const)
    target.addEventListener(end, (event) => fingers.delete(event.pointerId));
}

/** True if the key was one of these. */
export function zoomByKey(key: string, view: View): boolean {
  if (key === "+" || key === "=") view.zoomAt(view.middle, KEY_ZOOM);
  else if (key === "-") view.zoomAt(view.middle, 1 / KEY_ZOOM);
  else if (key === "0") view.reset();
  else return false;
  return true;
}
