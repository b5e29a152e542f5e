// The layers of an answer: regions, jumps, isolux curves, caustics, and the levels written on them.
import { cividis, placeOf } from "../colours";
import type { Vec2 } from "../contract";
import { s, set } from "../dom";
import { digitsFor, format } from "../numbers";
import { LabelPlacer } from "./labels";
import type { LevelPaths, Paths } from "./paths";
import type { View } from "./view";

const DIGITS = 2; // of a label, or as many as tell the levels apart
const LETTER = 6.1; // pixels, on average

export class CurveLayers {
  readonly group = s("g", { class: "curves" });
  readonly labels = s("g", { class: "labels", "aria-hidden": "true" });
  private paths: Paths | null = null;

  show(paths: Paths): void {
    this.paths = paths;
    const place = placeOf(paths.levels.map((l) => l.level));
    const of = (member: "fill" | "isolux" | "jump") =>
      paths.levels.map((l) => {
        const path = s("path", { d: l[member], class: member, "data-level": l.level });
        path.style.setProperty("--level", cividis(place(l.level)));
        return path;
      });
    this.group.replaceChildren(
      ...of("fill"),
      s("path", { d: paths.boundary, class: "boundary" }),
      ...of("jump"),
      ...of("isolux"),
      s("path", { d: paths.caustic, class: "caustic" }),
    );
  }

  place(view: View): void {
    set(this.group, { transform: view.transform });
  }

  /** Brightest first: they are the shortest, and the ones that are asked for. */
  write(view: View, spots: Vec2[]): void {
    const placer = new LabelPlacer((at, margin) => view.inside(at, margin), spots);
    const levels = [...(this.paths?.levels ?? [])].reverse();
    const digits = digitsFor(levels.map((l) => l.level), DIGITS);
    const texts = levels.flatMap((l) => this.labelsOf(l, view, placer, digits));
    this.labels.replaceChildren(...texts);
  }

  private labelsOf({ level, lines }: LevelPaths, view: View, placer: LabelPlacer, digits: number): SVGTextElement[] {
    const text = format(level, digits);
    const seen = lines.flatMap((line) => visible(line.map((p) => view.toPixel(p)), view));
    return seen.flatMap((line) =>
      placer.place(line, LETTER * text.length).map(({ at, degrees }) =>
        s("text", { transform: `translate(${at[0]} ${at[1]}) rotate(${degrees})`, dy: "0.35em" }, text),
      ),
    );
  }

  /** One level stands out; none if null. */
  stress(level: number | null): void {
    this.group.classList.toggle("stressed", level !== null);
    for (const path of this.group.querySelectorAll<SVGPathElement>("[data-level]"))
      path.classList.toggle("on", Number(path.dataset["level"]) === level);
  }
}

/** The stretches of a line that lie in view. */
function visible(line: Vec2[], view: View): Vec2[][] {
  if (view.zoom === 1) return [line];
  const out: Vec2[][] = [];
  let part: Vec2[] = [];
  for (const point of line) {
    if (view.inside(point)) part.push(point);
    else if (part.length) out.push(part), (part = []);
  }
  if (part.length) out.push(part);
  return out.filter((points) => points.length > 1);
}
