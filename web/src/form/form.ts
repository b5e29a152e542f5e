// The request as a form. Its structure is built anew when the request's changes; else only values are.
import type { Fault, Json, JsonObject } from "../contract";
import { h } from "../dom";
import { get, isObject, join, withValue } from "../pointer";
import { isPhotometric, lengthUnit, receiverOf } from "../scene";
import type { State, Store } from "../state";
import { makeControl, parsedControl, type Control } from "./control";
import * as F from "./fields";
import { FAMILIES, LEVELS } from "./notations";

const DEFAULT_FAMILIES = { max_bounces: 1 };

export class Form {
  private controls: Control[] = [];
  private structure = "";
  private readonly folded = new Map<string, boolean>();

  constructor(
    private readonly store: Store,
    private readonly parent: HTMLElement,
  ) {
    store.watch(["request", "faults"], (state) => this.update(state));
  }

  /** Shows the field that this fault is about. False if there is none. */
  focus(fault: Fault): boolean {
    const control = this.controlOf(fault);
    for (let at = control?.element.parentElement; at; at = at.parentElement)
      if (at instanceof HTMLDetailsElement) at.open = true;
    control?.focus();
    return control !== undefined;
  }

  hasFieldFor(fault: Fault): boolean {
    return this.controlOf(fault) !== undefined;
  }

  /** The innermost one: a fault of a member is told at the member. */
  private controlOf({ pointer }: Fault): Control | undefined {
    return this.controls
      .filter((c) => pointer === c.pointer || pointer.startsWith(c.pointer + "/"))
      .sort((a, b) => b.pointer.length - a.pointer.length)[0];
  }

  private update({ request, faults }: State): void {
    const structure = outline(request);
    if (structure !== this.structure) {
      this.structure = structure;
      this.build(request);
    }
    for (const control of this.controls) {
      control.show(get(request, control.pointer));
      control.blame(faults.filter((fault) => this.controlOf(fault) === control));
    }
  }

  private edit = (pointer: string, value: Json | undefined): void => {
    this.store.edit(withValue(this.store.now.request, pointer, value));
  };

  private build(request: JsonObject): void {
    this.controls = [];
    const surfaces = get(request, "/scene/surfaces");
    const count = Array.isArray(surfaces) ? surfaces.length : 0;
    const add = h("button", { type: "button", onclick: () => this.addSurface() }, "Add a surface");
    this.parent.replaceChildren(
      this.section("Light", true, this.typed("/scene/light", F.LIGHTS, "Kind")),
      ...Array.from({ length: count }, (_, i) => this.surface(join("/scene/surfaces", i), count > 1)),
      h("div", { class: "row" }, add),
      this.section("Receiver", false, this.fields("/scene/receiver", F.RECEIVER)),
      this.section("Levels", true, this.levels(request)),
      this.section("Paths of light", false, this.families(request)),
      this.section("Curves", false, [...this.fields("", F.MEASURES), this.included(request)]),
      this.section("Units", false, this.fields("/scene", F.UNITS)),
      this.section("Tolerances and limits", false, [
        ...this.fields("/tolerance", F.TOLERANCES),
        ...this.fields("/limits", F.LIMITS),
      ]),
    );
  }

  // ---- Parts ---------------------------------------------------------------------------------------

  private section(title: string, open: boolean, content: HTMLElement[], key = title): HTMLDetailsElement {
    const details = h("details", { open: this.folded.get(key) ?? open }, h("summary", {}, title), ...content);
    details.addEventListener("toggle", () => this.folded.set(key, details.open));
    return details;
  }

  private fields(pointer: string, fields: F.Field[]): HTMLElement[] {
    return fields.map((field) => {
      const control = makeControl(field, join(pointer, field.key), this.unitOf(field), this.edit);
      return this.own(control);
    });
  }

  private own(control: Control): HTMLElement {
    this.controls.push(control);
    return control.element;
  }

  /** An object whose members depend on its type, which is chosen first. */
  private typed(pointer: string, kinds: F.Kinds, label: string): HTMLElement[] {
    const value = get(this.store.now.request, pointer);
    const object = isObject(value) ? value : {};
    const kind = F.kindOf(kinds, object);
    const field: F.Field = {
      key: "type",
      label,
      kind: "choice",
      choices: Object.entries(kinds).map(([name, { label: text }]) => ({ value: name, label: text })),
    };
    if (!kind) field.choices!.unshift({ value: "", label: "…" });
    const choose = (_: string, chosen: Json | undefined) => {
      if (typeof chosen === "string") this.edit(pointer, F.made(kinds, chosen, object, this.scale()));
    };
    const control = makeControl(field, join(pointer, "type"), "", choose);
    const select = control.element.querySelector("select")!;
    this.own({ ...control, show: () => (select.value = kind ?? "") });
    return [control.element, ...(kind ? this.fields(pointer, kinds[kind]!.fields) : [])];
  }

  private surface(pointer: string, removable: boolean): HTMLElement {
    const { request } = this.store.now;
    const name = String(get(request, join(pointer, "name")) ?? "");
    const nameField: F.Field = { key: "name", label: "Name", kind: "text" };
    const parts = get(request, join(pointer, "aperture"));
    const apertures = Array.isArray(parts) ? parts : [];
    const cut = (i: number) => join(pointer, "aperture", i);
    const button = (text: string, onclick: () => void) => h("button", { type: "button", onclick }, text);
    return this.section(
      `Surface: ${name}`,
      true,
      [
        ...this.fields(pointer, [nameField]),
        ...this.typed(join(pointer, "shape"), F.SHAPES, "Shape"),
        ...this.typed(join(pointer, "optics"), F.OPTICS, "Optics"),
        ...apertures.map((_, i) =>
          h(
            "div",
            { class: "part", role: "group", "aria-label": `Aperture ${i + 1}` },
            ...this.typed(cut(i), F.APERTURES, `Aperture ${i + 1}`),
            button("Remove the aperture", () => this.edit(cut(i), undefined)),
          ),
        ),
        this.section("Pose", false, [
          ...this.fields(join(pointer, "pose"), F.POSE),
          ...this.fields(join(pointer, "pose", "rotate"), F.ROTATION),
        ], `${pointer} pose`),
        h(
          "div",
          { class: "row" },
          button("Add an aperture", () =>
            this.edit(join(pointer, "aperture"), [...apertures, F.made(F.APERTURES, "box", {}, this.scale())]),
          ),
          removable && button("Remove the surface", () => this.edit(pointer, undefined)),
        ),
      ],
      pointer,
    );
  }

  private levels(request: JsonObject): HTMLElement[] {
    const listed = Array.isArray(request["levels"]);
    const choose = (rule: boolean) =>
      this.edit("/levels", rule ? { count: 8, spacing: "log" } : this.levelsShown());
    const own = parsedControl(LEVELS.field(this.unitOf({ unit: "irradiance" })), "/levels", this.edit, 2, LEVELS);
    return [
      this.either("Chosen", "by a rule", "one by one", !listed, choose),
      ...(listed ? [this.own(own)] : this.fields("/levels", F.RULE)),
    ];
  }

  private families(request: JsonObject): HTMLElement[] {
    const listed = Array.isArray(request["families"]);
    const names = get(request, "/scene/surfaces/0/name");
    const choose = (found: boolean) => this.edit("/families", found ? DEFAULT_FAMILIES : [[names ?? ""]]);
    const bounces: F.Field = { key: "max_bounces", label: "Most hops", kind: "number", absent: "1" };
    return [
      this.either("Found", "all that occur", "these alone", !listed, choose),
      ...(listed
        ? [this.own(parsedControl(FAMILIES.field(), "/families", this.edit, 3, FAMILIES))]
        : this.fields("/families", [bounces])),
    ];
  }

  private included(request: JsonObject): HTMLElement {
    const given = Array.isArray(request["include"]) ? request["include"] : ["isolux", "caustic"];
    const names = ["isolux", "caustic", "boundaries"];
    const boxes = names.map((name) => {
      const box = h("input", { type: "checkbox" });
      box.checked = given.includes(name);
      box.addEventListener("change", () =>
        this.edit("/include", box.checked ? [...given, name] : given.filter((other) => other !== name)));
      return h("label", { class: "tick" }, box, name);
    });
    return h("div", { class: "field ticks", role: "group", "aria-label": "Kinds of curves" }, ...boxes);
  }

  private either(label: string, first: string, second: string, isFirst: boolean, choose: (first: boolean) => void): HTMLElement {
    const field: F.Field = {
      key: "", label, kind: "choice",
      choices: [{ value: "1", label: first }, { value: "2", label: second }],
    };
    const control = makeControl(field, "", "", (_, value) => choose(value === "1"));
    control.show(isFirst ? "1" : "2");
    return control.element;
  }

  // ---- What new parts start with -------------------------------------------------------------------

  private levelsShown(): number[] {
    const curves = this.store.now.traced?.answer.curves ?? [];
    const levels = [...new Set(curves.map((c) => c.level).filter((l): l is number => l !== null))];
    return levels.length ? levels.sort((a, b) => a - b).map((l) => Number(l.toPrecision(3))) : [0.001, 0.01, 0.1];
  }

  private addSurface(): void {
    const { request } = this.store.now;
    const surfaces = get(request, "/scene/surfaces");
    const list = Array.isArray(surfaces) ? surfaces : [];
    const names = list.map((surface) => get(surface, "/name"));
    let n = list.length + 1;
    while (names.includes(`surface ${n}`)) ++n;
    const scale = this.scale();
    const shape = { type: "sphere", center: [0, 0, scale], radius: Number((0.5 * scale).toPrecision(2)) };
    const surface = { name: `surface ${n}`, shape, optics: { type: "mirror", reflectance: 0.9 } };
    this.edit("/scene/surfaces", [...list, surface]);
  }

  /** A length of the scene's order of magnitude. */
  private scale(): number {
    const size = receiverOf(this.store.now.request)?.size;
    return size ? Number((Math.max(...size) / 8).toPrecision(2)) : 1;
  }

  private unitOf({ unit }: Pick<F.Field, "unit">): string {
    const { request } = this.store.now;
    const light = isPhotometric(request);
    switch (unit) {
      case "length": return lengthUnit(request);
      case "degrees": return "°";
      case "intensity": return light ? "cd" : "W/sr";
      case "power": return light ? "lm" : "W";
      case "irradiance": return light ? "lx" : "W/m²";
      default: return "";
    }
  }
}

const STRUCTURAL = new Set(["type", "kind", "length_unit", "quantity"]);

/** What decides which fields there are: types, and how many of what. */
function outline(value: Json, key = ""): string {
  if (Array.isArray(value)) {
    if (key === "levels" || key === "families" || key === "values") return "list";
    return `[${value.map((v) => (isObject(v) ? outline(v) : "")).join()}]${key === "include" ? value.join() : ""}`;
  }
  if (isObject(value)) {
    if (["levels", "families", "tolerance", "limits", "pose", "bounds"].includes(key)) return "object";
    const optics = "type" in value && ["n", "k", "power"].some((name) => name in value) ? "alternative" : "";
    return `{${optics}${Object.entries(value).map(([k, v]) => `${k}:${outline(v, k)}`).join()}}`;
  }
  return STRUCTURAL.has(key) ? String(value) : "";
}
