// The examples with small pictures, drawn from their answers one after another when nothing else is to do.
import { getExample, listExamples, traceUnstored } from "./api";
import { cividis, placeOf } from "./colours";
import type { ContourRequest } from "./contract";
import { pathsOf } from "./diagram/paths";
import { h, s } from "./dom";
import { receiverOf } from "./scene";
import { kept } from "./storage";
import type { Store } from "./state";

/** A picture as this browser keeps it, and what it is of. */
interface Kept {
  of: string;
  size: number;
  levels: { level: number; fill: string; isolux: string }[];
}

const KEPT = "isocaustic-picture-";
const CHORD = 4e-3; // of the side: a picture of 64 pixels

export async function addGallery(store: Store, parent: HTMLElement, load: (name: string) => void): Promise<void> {
  const examples = await listExamples();
  const buttons = examples.map(({ name, title }) =>
    h(
      "button",
      { type: "button", class: "example", "data-name": name, title, "aria-label": title, onclick: () => load(name) },
      h("span", { class: "picture" }),
      h("span", { class: "name" }, name.replaceAll("-", " ")),
    ),
  );
  parent.replaceChildren(h("ul", {}, ...buttons.map((button) => h("li", {}, button))));
  store.watch(["example"], ({ example }) => {
    for (const button of buttons) {
      const current = button.dataset["name"] === example;
      button.setAttribute("aria-pressed", String(current));
      if (current) button.scrollIntoView({ block: "nearest", inline: "nearest" });
    }
  });
  await idle(store);
  for (const button of buttons) {
    const version = store.now.traced?.answer.engine_version ?? "";
    await draw(button.dataset["name"]!, button.querySelector(".picture")!, version).catch(() => undefined);
    await idle(store);
  }
}

/** Pictures wait for what the user waits for. */
async function idle(store: Store): Promise<void> {
  do await new Promise((resolve) => setTimeout(resolve, 30));
  while (store.now.dragging || store.now.work || (!store.now.traced && !store.now.trouble));
}

async function draw(name: string, picture: Element, version: string): Promise<void> {
  const request = await getExample(name);
  const key = KEPT + name;
  const of = JSON.stringify([version, request]);
  const old = JSON.parse(kept.get(key) ?? "null") as Kept | null;
  if (old?.of === of) return show(picture, old.size, old.levels);
  const size = receiverOf(request)!.size;
  const tolerance = { irradiance: 1e-4, chord: CHORD * Math.max(...size) };
  const { curves } = await traceUnstored({ ...request, tolerance } as ContourRequest);
  const { levels } = pathsOf(curves, 100 * Math.max(...size));
  const lean = levels.map(({ level, fill, isolux }) => ({ level, fill, isolux }));
  kept.set(key, JSON.stringify({ of, size: Math.max(...size), levels: lean } satisfies Kept));
  show(picture, Math.max(...size), lean);
}

function show(picture: Element, side: number, levels: Kept["levels"]): void {
  const place = placeOf(levels.map((l) => l.level));
  picture.replaceChildren(
    s(
      "svg",
      { viewBox: `${-side / 2} ${-side / 2} ${side} ${side}`, "aria-hidden": "true" },
      s(
        "g",
        { transform: "scale(1 -1)" },
        ...levels.map((l) => s("path", { d: l.fill, fill: cividis(place(l.level)), "fill-rule": "evenodd" })),
        ...levels.map((l) => s("path", { d: l.isolux, stroke: cividis(place(l.level)), fill: "none", "stroke-width": side / 90 })),
      ),
    ),
  );
}
