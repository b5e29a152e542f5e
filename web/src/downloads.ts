// The files of the stored answer.
import { ask } from "./api";
import { h } from "./dom";
import type { Store } from "./state";
import { token } from "./token";

export function addDownloads(store: Store, parent: HTMLElement): void {
  store.watch(["traced", "request"], ({ traced, request }) => {
    if (!traced || traced.coarse) return;
    const current = traced.request === request;
    const links = Object.entries(traced.answer.files).map(([name, path]) => {
      const link = h("a", { href: path, download: `isocaustic.${name}`, "data-format": name }, `.${name}`);
      link.addEventListener("click", (event) => {
        if (!token()) return; // the browser saves it by itself
        event.preventDefault();
        void saveWithToken(path, link.download);
      });
      return h("li", {}, link);
    });
    parent.replaceChildren(...links);
    parent.classList.toggle("stale", !current);
  });
}

/** A link cannot show the token. */
async function saveWithToken(path: string, name: string): Promise<void> {
  const url = URL.createObjectURL(await (await ask(path)).blob());
  h("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}
