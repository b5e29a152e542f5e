// Light or dark: the system's choice until the user makes one.
import { kept } from "./storage";

const KEY = "isocaustic-theme";

export function addTheme(button: HTMLElement): void {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const stored = kept.get(KEY);
  if (stored) document.documentElement.dataset["theme"] = stored;
  const isDark = () => (document.documentElement.dataset["theme"] ?? (dark.matches ? "dark" : "light")) === "dark";
  const say = () => button.setAttribute("aria-pressed", String(isDark()));
  button.addEventListener("click", () => {
    const theme = isDark() ? "light" : "dark";
    document.documentElement.dataset["theme"] = theme;
    kept.set(KEY, theme);
    say();
  });
  dark.addEventListener("change", say);
  say();
}
