// Which part of the receiver is seen, and where on the page.
import type { Vec2 } from "../contract";

const MARGIN = { left: 68, right: 14, top: 14, bottom: 44 };
const MOST_ZOOM = 400;
const ROOM = 1.04; // around the receiver, when all of it is seen

export class View {
  width = 100;
  height = 100;
  private center: Vec2 = [0, 0];
  private size: Vec2 = [1, 1];
  /** 1 shows the whole receiver. */
  zoom = 1;

  /** The frame has the receiver's proportions, in the middle of what there is. */
  get left() {
    return MARGIN.left + (this.width - MARGIN.left - MARGIN.right - this.plotWidth) / 2;
  }
  get top() {
    return MARGIN.top + (this.height - MARGIN.top - MARGIN.bottom - this.plotHeight) / 2;
  }
  get plotWidth() {
    return ROOM * this.size[0] * this.fitting;
  }
  get plotHeight() {
    return ROOM * this.size[1] * this.fitting;
  }

  /** Pixels for a unit of length. */
  get scale(): number {
    return this.zoom * this.fitting;
  }

  /** The scale that shows the whole receiver. */
  private get fitting(): number {
    const across = (this.width - MARGIN.left - MARGIN.right) / this.size[0];
    const up = (this.height - MARGIN.top - MARGIN.bottom) / this.size[1];
    return Math.max(1e-6, Math.min(across, up)) / ROOM;
  }

  show(size: Vec2): void {
    if (size[0] === this.size[0] && size[1] === this.size[1]) return;
    this.size = size;
    this.reset();
  }

  reset(): void {
    this.center = [0, 0];
    this.zoom = 1;
  }

  toPixel([u, v]: Vec2): Vec2 {
    const k = this.scale;
    return [
      this.left + this.plotWidth / 2 + (u - this.center[0]) * k,
      this.top + this.plotHeight / 2 - (v - this.center[1]) * k,
    ];
  }

  toPlane([x, y]: Vec2): Vec2 {
    const k = this.scale;
    return [
      this.center[0] + (x - this.left - this.plotWidth / 2) / k,
      this.center[1] - (y - this.top - this.plotHeight / 2) / k,
    ];
  }

  /** As an SVG transform of receiver coordinates. */
  get transform(): string {
    const [x, y] = this.toPixel([0, 0]);
    return `translate(${x} ${y}) scale(${this.scale} ${-this.scale})`;
  }

  /** What is under `pixel` stays there. */
  zoomAt(pixel: Vec2, factor: number): void {
    const fixed = this.toPlane(pixel);
    this.zoom = Math.min(MOST_ZOOM, Math.max(1, this.zoom * factor));
    const now = this.toPlane(pixel);
    this.moveBy([fixed[0] - now[0], fixed[1] - now[1]]);
  }

  panBy(dx: number, dy: number): void {
    this.moveBy([-dx / this.scale, dy / this.scale]);
  }

  get middle(): Vec2 {
    return [this.left + this.plotWidth / 2, this.top + this.plotHeight / 2];
  }

  /** The receiver does not leave the view. */
  private moveBy(by: Vec2): void {
    const room = 1 - 1 / this.zoom;
    this.center = [0, 1].map((i) => {
      const most = (room * this.size[i]!) / 2;
      return Math.min(most, Math.max(-most, this.center[i]! + by[i]!));
    }) as Vec2;
  }

  inside([x, y]: Vec2, margin = 0): boolean {
    return (
      x >= this.left + margin &&
      x <= this.left + this.plotWidth - margin &&
      y >= this.top + margin &&
      y <= this.top + this.plotHeight - margin
    );
  }
}
