// How the tracing goes: a bar that moves with it and can cancel it, or what is wrong and where.
import type { Fault } from "./contract";
import { h } from "./dom";
import { get } from "./pointer";
import type { State, Store } from "./state";

const PATIENCE_MS = 250; // shorter work needs no bar
const LONGEST_MS = 60_000;

export function addStatus(store: Store, parent: HTMLElement, goTo: (fault: Fault) => boolean): void {
  const bar = h("progress", { max: 1, "aria-label": "Tracing" });
  const share = h("span", { class: "share" });
  const cancel = h("button", { type: "button", class: "cancel" }, "Cancel");
  const work = h("div", { class: "work", hidden: true }, bar, share, cancel);
  const message = h("div", { class: "message", role: "status" });
  parent.replaceChildren(work, message);
  let timer = 0;
  cancel.addEventListener("click", () => store.now.work?.cancel());
  store.watch(["work"], (state) => {
    if (!state.work) {
      clearTimeout(timer);
      timer = 0;
      work.hidden = true;
      return;
    }
    timer ||= window.setTimeout(() => (work.hidden = false), PATIENCE_MS);
    bar.value = state.work.progress;
    share.textContent = `${Math.round(100 * state.work.progress)} %`;
  });
  store.watch(["trouble", "faults", "traced", "request"], (state) => {
    message.replaceChildren(...messages(state, store, goTo));
    parent.classList.toggle("troubled", state.trouble !== null);
  });
}

function messages(state: State, store: Store, goTo: (fault: Fault) => boolean): HTMLElement[] {
  if (state.trouble !== null) {
    const faults = state.faults.map((fault) => {
      const text = `${fault.pointer || "/"}: ${fault.detail}`;
      return h("li", {}, h("button", { type: "button", class: "link", onclick: () => void goTo(fault) }, text));
    });
    const again = () => store.set({ request: { ...store.now.request }, trouble: null });
    const retry = !faults.length && h("button", { type: "button", class: "link", onclick: again }, "Try again");
    return [h("p", {}, `${state.trouble} `, retry), ...(faults.length ? [h("ul", { class: "plain" }, ...faults)] : [])];
  }
  if (state.traced && !state.traced.coarse && !state.traced.answer.complete) {
    const longer = () => {
      const limits = get(state.request, "/limits");
      const other = typeof limits === "object" && limits !== null && !Array.isArray(limits) ? limits : {};
      store.edit({ ...state.request, limits: { ...other, time_ms: LONGEST_MS } });
    };
    return [h("p", {}, "Cut short by a limit. ", h("button", { type: "button", class: "link", onclick: longer }, "Take a minute for it"))];
  }
  return [];
}
