// The request as text, in step with the form: what can be read is taken, what cannot is said.
import type { ContourRequest } from "./contract";
import { h } from "./dom";
import { prettyJson } from "./json_text";
import { isObject } from "./pointer";
import type { Store } from "./state";

const WIDTH = 40; // letters, about what the pane shows

export function addJsonPane(store: Store, parent: HTMLElement): void {
  const area = h("textarea", { class: "json", spellcheck: "false", "aria-label": "The request as JSON", "aria-describedby": "json-fault" });
  const fault = h("p", { class: "fault", id: "json-fault", role: "status" });
  parent.replaceChildren(area, fault);
  const say = (text: string) => {
    fault.textContent = text;
    area.setAttribute("aria-invalid", String(text !== ""));
  };
  area.addEventListener("input", () => {
    try {
      const value = JSON.parse(area.value) as ContourRequest;
      if (!isObject(value)) throw new Error("must be an object");
      say("");
      store.edit(value);
    } catch (error) {
      say((error as Error).message);
    }
  });
  const write = () => {
    if (document.activeElement === area || parent.hidden) return;
    area.value = prettyJson(store.now.request, WIDTH);
    say("");
  };
  new MutationObserver(write).observe(parent, { attributeFilter: ["hidden"] });
  area.addEventListener("blur", () => {
    if (!fault.textContent) write();
  });
  store.watch(["request", "faults"], ({ faults }) => {
    write();
    if (faults.length) say(faults.map((f) => `${f.pointer || "/"}: ${f.detail}`).join("\n"));
    else if (!fault.textContent?.includes("JSON")) say("");
  });
}
