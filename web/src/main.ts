// The page put together: state in the middle, everything else looks at it.
import { getExample } from "./api";
import type { ContourRequest } from "./contract";
import { addDetails } from "./details";
import { Diagram } from "./diagram/diagram";
import { byId } from "./dom";
import { addDownloads } from "./downloads";
import { Form } from "./form/form";
import { addGallery } from "./gallery";
import { addJsonPane } from "./json_pane";
import { LevelsBar } from "./levels_bar";
import { addSpace } from "./space_panel";
import { asCurl, asPython, copy, fromAddress, keepInAddress } from "./share";
import { Store } from "./state";
import { addStatus } from "./status";
import "./style.css";
import { addTabs } from "./tabs";
import { addTheme } from "./theme";
import { Tracer } from "./tracer";

const FIRST = "torus";

const store = new Store({
  request: {}, example: null, dragging: false, traced: null, faults: [], trouble: null, work: null,
  stressed: null, reading: null, fan: null,
});

async function load(name: string): Promise<void> {
  try {
    show(await getExample(name), name);
  } catch {
    store.set({ trouble: `There is no example ${name}.`, faults: [] });
  }
}

const show = (request: ContourRequest, example: string | null) => store.set({ request, example, dragging: false, fan: null });

async function loadFromAddress(): Promise<void> {
  try {
    const asked = await fromAddress();
    if (asked && "request" in asked) show(asked.request, null);
    else await load(asked?.example ?? FIRST);
  } catch {
    store.set({ trouble: "The link’s scene cannot be read.", faults: [] });
  }
}

function addCopying(): void {
  const texts: Record<string, () => string> = {
    "copy-link": () => location.href,
    "copy-curl": () => asCurl(store.now.request),
    "copy-python": () => asPython(store.now.request),
  };
  for (const [id, text] of Object.entries(texts)) {
    const button = byId(id);
    const label = button.textContent;
    button.addEventListener("click", () => {
      void copy(text()).then(() => {
        button.textContent = "Copied";
        setTimeout(() => (button.textContent = label), 1200);
      });
    });
  }
}

addTheme(byId("theme"));
addTabs(byId("tabs"));
new Tracer(store);
const diagram = new Diagram(store, byId("diagram"), byId("reading"));
const form = new Form(store, byId("form"));
addJsonPane(store, byId("json"));
addStatus(store, byId("status"), (fault) => {
  byId("tab-form").click();
  return form.focus(fault);
});
new LevelsBar(store, byId("levels"), byId("levels-title"));
addDownloads(store, byId("files"));
addDetails(store, byId("details"));
addCopying();
byId("zoom-in").addEventListener("click", () => diagram.zoom("+"));
byId("zoom-out").addEventListener("click", () => diagram.zoom("-"));
byId("zoom-all").addEventListener("click", () => diagram.zoom("0"));
byId("fill").addEventListener("change", (event) =>
  byId("diagram").classList.toggle("filled", (event.target as HTMLInputElement).checked));

addSpace(store, byId("space"), byId("space-button"), (uv) => diagram.pointAt(uv));

void loadFromAddress().then(() => {
  keepInAddress(store, () => void loadFromAddress());
  return addGallery(store, byId("gallery"), (name) => void load(name));
});
