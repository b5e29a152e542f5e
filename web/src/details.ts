// What was computed, what was not and why: families, work, skipped stages, warnings, completeness.
import type { ContourAnswer } from "./contract";
import { h } from "./dom";
import { format } from "./numbers";
import type { Store } from "./state";

export function addDetails(store: Store, parent: HTMLElement): void {
  store.watch(["traced"], ({ traced }) => {
    if (!traced || traced.coarse) return;
    const { answer } = traced;
    const warnings = answer.warnings.map((w) => h("li", { class: "warning" }, w.detail));
    parent.replaceChildren(
      h("p", { class: "summary" }, summaryOf(answer)),
      ...(warnings.length ? [h("ul", { class: "plain" }, ...warnings)] : []),
      fold("Skipped", answer.skipped.length, list(answer.skipped.map((s) => [s.stage, s.reason]))),
      fold("Families", answer.families.length, list(answer.families.map((f) => [
        f.surfaces.join(" → ") || "direct", `flux ${format(f.flux, 4)}`,
      ]))),
      fold("Completeness", (answer.completeness.unproven ?? []).length, completeness(answer)),
    );
  });
}

function summaryOf(answer: ContourAnswer): string {
  const vertices = answer.curves.reduce((sum, c) => sum + c.vertices, 0);
  const worst = Math.max(0, ...answer.curves.map((c) => c.max_residual));
  const spent = `${answer.work.evaluations.toLocaleString("en")} evaluations in ${format(1e3 * answer.work.seconds)} ms`;
  return `${answer.curves.length} curves, ${vertices.toLocaleString("en")} vertices, largest residual ${format(worst, 2)}; ${spent}.`;
}

function completeness({ completeness: { certified, undecided_cells, unproven } }: ContourAnswer): HTMLElement {
  const undecided = undecided_cells ? ` ${undecided_cells} cells are undecided.` : "";
  const first = certified ? "Proven: no component is missing." : `Not proven.${undecided}`;
  return h("div", {}, h("p", {}, first), h("ul", { class: "plain" }, ...(unproven ?? []).map((text) => h("li", {}, text))));
}

const list = (rows: [string, string][]): HTMLElement =>
  h("dl", {}, ...rows.flatMap(([term, text]) => [h("dt", {}, term.replaceAll("_", " ")), h("dd", {}, text)]));

const open = new Set<string>();

/** Stays as it was left when the next answer comes. */
function fold(title: string, count: number, content: HTMLElement): HTMLElement {
  const details = h("details", { open: open.has(title) }, h("summary", {}, `${title} `, h("small", {}, String(count))), content);
  details.addEventListener("toggle", () => (details.open ? open.add(title) : open.delete(title)));
  return details;
}
