// The view in space, fetched when it is first wanted.
import type { Vec2 } from "./contract";
import { h } from "./dom";
import type { Store } from "./state";

export function addSpace(store: Store, panel: HTMLElement, button: HTMLElement, point: (uv: Vec2 | null) => void): void {
  let begun = false;
  button.addEventListener("click", () => {
    panel.hidden = !panel.hidden;
    button.setAttribute("aria-pressed", String(!panel.hidden));
    if (begun) return;
    begun = true;
    void import("./space/space")
      .then(({ Space }) => new Space(store, panel, point))
      .catch((error: Error) => panel.replaceChildren(h("p", { class: "faint" }, `No view in space here: ${error.message}`)));
  });
}
