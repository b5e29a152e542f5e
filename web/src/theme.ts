// Light or dark: the system's choice until the user makes one. The root says which, so that whatever is
// drawn with the colours sees a change.
import { kept } from "./storage";

const KEY = "isocaustic-theme";

export function addTheme(button: HTMLElement): void {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const root = document.documentElement;
  let chosen = kept.get(KEY);
  const apply = () => {
    root.dataset["theme"] = chosen ?? (system.matches ? "dark" : "light");
    button.setAttribute("aria-pressed", String(root.dataset["theme"] === "dark"));
  };
  button.addEventListener("click", () => {
    chosen = root.dataset["theme"] === "dark" ? "light" : "dark";
    kept.set(KEY, chosen);
    apply();
  });
  system.addEventListener("change", apply);
  apply();
}
