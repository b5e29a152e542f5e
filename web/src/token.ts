// A service that was started with a token asks for it; it is kept as long as the tab.
import { h } from "./dom";
import { keptForTab } from "./storage";

const KEY = "isocaustic-token";

let shown = keptForTab.get(KEY) ?? "";

export function token(): string {
  return shown;
}

let asking: Promise<void> | null = null;

/** Once for all requests that wait for it. */
export function askForToken(): Promise<void> {
  asking ??= new Promise<void>((resolve) => {
    const input = h("input", { type: "password", autocomplete: "off", "aria-label": "Token" });
    const dialog = h(
      "dialog",
      { class: "token", "aria-labelledby": "token-title" },
      h(
        "form",
        { method: "dialog" },
        h("h2", { id: "token-title" }, "This service asks for a token"),
        input,
        h("button", { class: "strong" }, "Continue"),
      ),
    );
    dialog.addEventListener("close", () => {
      shown = input.value;
      keptForTab.set(KEY, shown);
      dialog.remove();
      asking = null;
      resolve();
    });
    document.body.append(dialog);
    dialog.showModal();
  });
  return asking;
}
