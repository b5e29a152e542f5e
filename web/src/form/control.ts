// One member of the request as something to type into: it shows the value, says what is wrong with it,
// and hands on what was typed once that can be read.
import type { Fault, Json } from "../contract";
import { h } from "../dom";
import type { Field } from "./fields";

export interface Control {
  element: HTMLElement;
  pointer: string;
  show(value: Json | undefined): void;
  /** The faults of this member or of what is in it. */
  blame(faults: Fault[]): void;
  focus(): void;
}

export type Edit = (pointer: string, value: Json | undefined) => void;

let count = 0;

/** The frame of all controls: label, inputs, unit, what is wrong. */
function framed(field: Field, unit: string, inputs: HTMLElement[]): { element: HTMLElement; say: (text: string) => void } {
  const id = `f${++count}`;
  const message = h("p", { class: "fault", id: `${id}-fault`, hidden: true });
  const single = inputs.length === 1;
  inputs.forEach((input, i) => {
    input.setAttribute("aria-describedby", `${id}-fault`);
    if (single) input.id = id;
    else input.setAttribute("aria-label", `${field.label}, ${"xyz"[i]}`);
  });
  const label = single ? h("label", { for: id }, field.label) : h("span", { class: "label" }, field.label);
  const element = h(
    "div",
    { class: `field ${field.kind}`, role: single ? null : "group", "aria-label": single ? null : field.label },
    label,
    h("span", { class: "inputs" }, ...inputs),
    unit ? h("span", { class: "unit", "aria-hidden": "true" }, unit) : null,
    message,
  );
  const say = (text: string) => {
    message.textContent = text;
    message.hidden = text === "";
    element.classList.toggle("wrong", text !== "");
  };
  return { element, say };
}

const mark = (input: Element, wrong: boolean) =>
  wrong ? input.setAttribute("aria-invalid", "true") : input.removeAttribute("aria-invalid");

/** Undefined where the text is not a number. */
function numberIn(text: string): number | undefined {
  const plain = text.trim().replace("−", "-");
  const value = Number(plain);
  return plain !== "" && Number.isFinite(value) ? value : undefined;
}

/** Arrow keys turn the second digit of a number. */
function stepped(value: number, up: boolean): number {
  const step = value === 0 ? 0.1 : 10 ** (Math.floor(Math.log10(Math.abs(value))) - 1);
  return Number((value + (up ? step : -step)).toPrecision(12));
}

function numberInput(onInput: () => void, placeholder = ""): HTMLInputElement {
  const input = h("input", { type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", placeholder });
  input.addEventListener("input", onInput);
  input.addEventListener("keydown", (event) => {
    const value = numberIn(input.value);
    if (value === undefined || (event.key !== "ArrowUp" && event.key !== "ArrowDown")) return;
    event.preventDefault();
    input.value = String(stepped(value, event.key === "ArrowUp"));
    onInput();
  });
  return input;
}

function numbersControl(field: Field, pointer: string, unit: string, edit: Edit, size: number): Control {
  let wrong = "";
  const inputs = Array.from({ length: size }, () => numberInput(() => read(), field.absent));
  const frame = framed(field, unit, inputs);
  const read = () => {
    const texts = inputs.map((input) => input.value.trim());
    const values = texts.map(numberIn);
    const empty = field.absent !== undefined && texts.every((text) => text === "");
    inputs.forEach((input, i) => mark(input, !empty && values[i] === undefined));
    wrong = empty || values.every((value) => value !== undefined) ? "" : "must be a number";
    frame.say(wrong);
    if (wrong) return;
    edit(pointer, empty ? undefined : size === 1 ? values[0] : (values as number[]));
  };
  return {
    element: frame.element,
    pointer,
    focus: () => (inputs.find((input) => input.hasAttribute("aria-invalid")) ?? inputs[0]!).focus(),
    show(value) {
      const shown = size === 1 ? [value] : Array.isArray(value) ? value : [];
      inputs.forEach((input, i) => {
        const text = shown[i] === undefined || shown[i] === null ? "" : String(shown[i]);
        // What is being typed stays as it is typed: "1." is 1.
        if (document.activeElement === input && (wrong || numberIn(input.value) === shown[i])) return;
        if (input.value !== text) input.value = text;
      });
    },
    blame(faults) {
      if (wrong) return;
      inputs.forEach((input, i) =>
        mark(input, faults.some((fault) => fault.pointer === pointer || fault.pointer === `${pointer}/${i}`)));
      frame.say(faults.map((fault) => fault.detail).join("; "));
    },
  };
}

function textControl(field: Field, pointer: string, edit: Edit): Control {
  const input = h("input", { type: "text", autocomplete: "off", spellcheck: "false" });
  input.addEventListener("input", () => edit(pointer, input.value));
  const frame = framed(field, "", [input]);
  return plain(frame, input, pointer, (value) => {
    const text = value === undefined ? "" : String(value);
    if (input.value !== text) input.value = text;
  });
}

function choiceControl(field: Field, pointer: string, edit: Edit): Control {
  const options = field.choices!.map(({ value, label }) => h("option", { value }, label));
  const select = h("select", {}, ...options);
  select.addEventListener("change", () => edit(pointer, select.value === "" ? undefined : select.value));
  return plain(framed(field, "", [select]), select, pointer, (value) => {
    select.value = value === undefined ? (field.absent ?? "") : String(value);
  });
}

function flagControl(field: Field, pointer: string, edit: Edit): Control {
  const box = h("input", { type: "checkbox" });
  box.addEventListener("change", () => edit(pointer, box.checked));
  return plain(framed(field, "", [box]), box, pointer, (value) => {
    box.checked = value === true;
  });
}

/** What is too rich for fields is written as JSON, as it stands in the request. */
function jsonControl(field: Field, pointer: string, edit: Edit): Control {
  return parsedControl(field, pointer, edit, 2, {
    write: (value) => (value === undefined ? "" : JSON.stringify(value).replaceAll(",", ", ")),
    read: (text) => (text.trim() === "" && field.absent !== undefined ? undefined : (JSON.parse(text) as Json)),
  });
}

/** A value by a notation of its own; `read` throws what is wrong with a text. */
export function parsedControl(
  field: Field, pointer: string, edit: Edit, rows: number,
  notation: { write: (value: Json | undefined) => string; read: (text: string) => Json | undefined },
): Control {
  let wrong = "";
  const area = h("textarea", { rows, spellcheck: "false", placeholder: field.absent });
  const frame = framed(field, "", [area]);
  area.addEventListener("input", () => {
    try {
      wrong = "";
      edit(pointer, notation.read(area.value));
    } catch (error) {
      wrong = error instanceof SyntaxError ? "is not JSON yet" : (error as Error).message;
    }
    mark(area, wrong !== "");
    frame.say(wrong);
  });
  const control = plain(frame, area, pointer, (value) => {
    if (document.activeElement === area) return;
    wrong = "";
    area.value = notation.write(value);
  });
  return { ...control, blame: (faults) => (wrong ? undefined : control.blame(faults)) };
}

function plain(
  frame: { element: HTMLElement; say: (text: string) => void }, input: HTMLElement, pointer: string,
  show: (value: Json | undefined) => void,
): Control {
  return {
    element: frame.element,
    pointer,
    show,
    focus: () => input.focus(),
    blame(faults) {
      mark(input, faults.length > 0);
      const where = (fault: Fault) => (fault.pointer === pointer ? "" : `${fault.pointer.slice(pointer.length + 1)}: `);
      frame.say(faults.map((fault) => where(fault) + fault.detail).join("; "));
    },
  };
}

export function makeControl(field: Field, pointer: string, unit: string, edit: Edit): Control {
  switch (field.kind) {
    case "number": return numbersControl(field, pointer, unit, edit, 1);
    case "pair": return numbersControl(field, pointer, unit, edit, 2);
    case "triple": return numbersControl(field, pointer, unit, edit, 3);
    case "text": return textControl(field, pointer, edit);
    case "choice": return choiceControl(field, pointer, edit);
    case "flag": return flagControl(field, pointer, edit);
    case "json": return jsonControl(field, pointer, edit);
  }
}
