// The isolux curve under the pointer stands out in all views; picked, its light is shown: the rays that arrive
// along it.
import { read } from "../api";
import type { CurveFeature, Vec2 } from "../contract";
import type { Store } from "../state";
import { nearest, spread } from "./nearest";
import type { View } from "./view";

const REACH = 7; // pixels
const RAYS = 40;

export class Picker {
  private under: CurveFeature | null = null;

  constructor(
    private readonly store: Store,
    private readonly view: View,
  ) {}

  hover(uv: Vec2 | null): void {
    const { traced, stressed } = this.store.now;
    const found = uv && traced ? nearest(traced.curves.features, uv, REACH / this.view.scale) : null;
    if (found === this.under) return;
    this.under = found;
    const level = found?.properties.level ?? null;
    if (level !== stressed) this.store.set({ stressed: level });
  }

  /** The rays of this curve; of none where there is none. */
  async pick(): Promise<void> {
    const { request, fan } = this.store.now;
    if (!this.under) {
      if (fan) this.store.set({ fan: null });
      return;
    }
    const readings = await read(request, spread(this.under.geometry.coordinates, RAYS));
    if (this.store.now.request === request) this.store.set({ fan: readings });
  }
}
