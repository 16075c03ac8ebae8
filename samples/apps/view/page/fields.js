// The form of settings: gicube-render's options by their names.
/** @typedef {import("./view.js").ViewState} ViewState */
/** @typedef {import("./protocol.js").Hello} Hello */
import { by, element } from "./dom.js";

/** @typedef {{name: string, label: string, hint?: string, options?: string[], flag?: boolean, range?: [number, number,
 * number], wide?: boolean}} Field */

const on = { flag: true };
/** @type {[string, Field[]][]} */
const kGroups = [
  ["Picture", [
    { name: "size", label: "Size", options: ["256x256", "384x384", "512x512", "768x768", "1024x1024", "640x480",
      "1280x720"] },
    { name: "samples", label: "Samples of a pixel", options: ["1", "2", "4"], hint: "1" },
    { name: "background", label: "Background", hint: "r,g,b or none" },
    { name: "fov", label: "Field of view", hint: "degrees" }, { name: "orthographic", label: "Parallel, height",
      hint: "off" },
    { name: "camera", label: "Camera of the scene", hint: "the first" },
      { name: "time", label: "Time of the scene", hint: "seconds" },
  ]],
  ["Sampling", [
    { name: "step", label: "Step, voxels", range: [0.125, 4, 0.125] },
    { name: "threshold", label: "Opacity threshold", range: [0, 1, 0.01] },
    { name: "jitter", label: "Vary the steps", ...on }, { name: "no-leap", label: "Sample empty blocks too", ...on },
  ]],
  ["Light and material", [
    { name: "no-shade", label: "Without shading", ...on }, { name: "light", label: "Towards the light", hint: "x,y,z" },
    { name: "ambient", label: "Ambient" }, { name: "diffuse", label: "Diffuse" },
      { name: "specular", label: "Specular" }, { name: "shininess", label: "Shininess" },
    { name: "illumination", label: "Global illumination", options: ["none", "low", "high"], hint: "the scene's" },
    { name: "light-rays", label: "Light rays", hint: "1" }, { name: "lifetime", label: "Scatterings, at most",
      hint: "32" },
    { name: "exposure", label: "Exposure", hint: "chosen" }, { name: "colour-passes", label: "Light in three colours",
      ...on },
  ]],
  ["Board", [
    { name: "fidelity", label: "Level", options: ["functional", "cycle"], hint: "the board's" },
    { name: "asic.processors", label: "Processors", options: ["1", "2", "4", "8", "16"], hint: "the board's" },
    { name: "seed", label: "Seed", hint: "the scene's" },
  ]],
];

export class Fields {
  /** @type {Map<string, HTMLInputElement | HTMLSelectElement>} */ #inputs = new Map();

  /** @param {ViewState} view */
  constructor(view) {
    this.view = view;
    kGroups.forEach(([title, fields], number) => {
      const body = element("div", { class: "fields" }, ...fields.map((field) => this.#row(field)));
      const group = element("details", number < 2 ? { open: "" } : {}, element("summary", {}, title), body);
      by("settings").append(group);
    });
    for (const id of ["cut-axis", "cut-at", "cut-side"]) by(id).addEventListener("input", () => this.#cut(true));
    for (const id of ["cut-axis", "cut-at", "cut-side"]) by(id).addEventListener("change", () => this.#cut(false));
    by("input").addEventListener("change", () => {
      view.own = { ...view.kept(), input: by("input").value };
      view.set({ input: by("input").value });
    });
  }

  /** @param {Hello} hello */
  open(hello) {
    by("input").replaceChildren(...hello.inputs.map((name) => new Option(name, name)));
    this.box = hello.box;
    this.load();
  }

  /** Updates the form from the view. */
  load() {
    by("input").value = this.view.get("input");
    for (const [name, input] of this.#inputs) {
      const value = this.view.get(name);
      if (input instanceof HTMLInputElement && input.type === "checkbox") input.checked = value === "on";
      else {
        if (input instanceof HTMLSelectElement && value &&
          ![...input.options].some((o) => o.value === value)) input.add(new Option(value, value));
        input.value = value;
      }
      const range = document.getElementById(`range-${name}`);
      if (range instanceof HTMLInputElement) range.value = value;
    }
    const [x, y, z] = this.view.get("cut").split(",").map(Number);
    if (this.view.get("cut") === "") by("cut-axis").value = "";
    else by("cut-axis").value = x ? "x" : y ? "y" : z ? "z" : "";
    by("cut-at").disabled = by("cut-side").disabled = by("cut-axis").value === "";
  }

  /** Marks the field at fault, or none.
   * @param {string} [name] @param {string} [text] @returns {boolean} whether there is such a field */
  blame(name = "", text = "") {
    for (const input of this.#inputs.values()) {
      input.removeAttribute("aria-invalid");
      input.parentElement?.querySelector(".fault")?.remove();
    }
    const input = this.#inputs.get(name);
    if (!input) return false;
    input.setAttribute("aria-invalid", "true");
    input.closest("details")?.setAttribute("open", "");
    input.parentElement?.append(element("span", { class: "fault" }, text));
    return true;
  }

  /** @param {Field} field */
  #row(field) {
    const id = `set-${field.name}`;
    const label = element("label", { for: id }, field.label);
    /** @type {HTMLInputElement | HTMLSelectElement} */
    let input;
    if (field.options) {
      input = element("select", { id });
      if (field.hint) input.add(new Option(field.hint, ""));
      for (const option of field.options) input.add(new Option(option, option));
    } else input = element("input", field.flag ? { id, type: "checkbox" } : { id, type: "text",
      placeholder: field.hint ?? "", autocomplete: "off" });
    this.#inputs.set(field.name, input);
    input.addEventListener("change", () => {
      const value = input instanceof HTMLInputElement && input.type === "checkbox" ? (input.checked ? "on" : "")
        : input.value.trim();
      this.view.set({ [field.name]: value });
    });
    const row = element("div", { class: field.flag ? "field flag" : "field" }, label, input);
    if (field.range) {
      const [min, max, step] = field.range.map(String);
      const range = element("input", { type: "range", id: `range-${field.name}`, min, max, step,
        "aria-label": field.label });
      range.addEventListener("input", () => this.view.set({ [field.name]: range.value }, true));
      input.classList.add("number");
      row.insertBefore(range, input);
    }
    return row;
  }

  /** A plane across an axis, at a share of the visible box.
   * @param {boolean} moving */
  #cut(moving) {
    const axis = "xyz".indexOf(by("cut-axis").value);
    if (by("cut-axis").value === "" || !this.box) return this.view.set({ cut: "" });
    const share = Number(by("cut-at").value) / 100;
    const at = this.box.low[axis] + share * (this.box.high[axis] - this.box.low[axis]);
    const sign = by("cut-side").checked ? -1 : 1;
    const normal = [0, 1, 2].map((i) => (i === axis ? sign : 0));
    this.view.set({ cut: [...normal, (sign * at).toFixed(2)].join(",") }, moving);
  }
}
