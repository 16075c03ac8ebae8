// The editor of a transfer function: points over the histogram, colours on the strip below.
/** @typedef {import("./protocol.js").Histogram} Histogram */
/** @typedef {import("./protocol.js").Hello} Hello */
/** @typedef {import("./transfer.js").Transfer} Transfer */
/** @typedef {import("./transfer.js").ColourPoint} ColourPoint */
/** @typedef {import("./transfer.js").OpacityPoint} OpacityPoint */
/** @typedef {import("./view.js").ViewState} ViewState */
import { by, save, shape } from "./dom.js";
import { History, colour_at, format, from_hex, hex, parse } from "./transfer.js";

const kWidth = 320, kHeight = 150, kStrip = 172, kTotal = 184, kEdge = 8;
const kOwn = "own"; // for edited points

export class Editor {
  #history = new History();
  /** @type {Transfer} */ #transfer = parse("");
  /** @type {[number, number]} */ #range = [0, 1];
  /** @type {Hello["presets"]} */ #presets = [];
  /** @type {{list: "colours" | "opacities", index: number}} */ #selected = { list: "opacities", index: 0 };
  #look = ""; // of the program's choice
  #why = "";
  #svg = shape("svg", { viewBox: `0 0 ${kWidth} ${kTotal}`, role: "group",
    "aria-label": "transfer function: opacity over value" });
  #bars = shape("path", { class: "histogram" });
  #curve = shape("path", { class: "curve" });
  #gradient = shape("linearGradient", { id: "strip" });
  #points = shape("g");

  /** @param {ViewState} view */
  constructor(view) {
    this.view = view;
    this.#svg.append(
      shape("defs", {}, this.#gradient),
      this.#bars,
      shape("rect", { x: kEdge, y: kStrip - 8, width: kWidth - 2 * kEdge, height: 16, fill: "url(#strip)",
        class: "strip" }),
      this.#curve,
      this.#points,
    );
    by("editor").append(this.#svg);
    this.#svg.addEventListener("pointerdown", (event) => this.#press(/** @type {PointerEvent} */ (event)));
    this.#svg.addEventListener("keydown", (event) => this.#key(/** @type {KeyboardEvent} */ (event)));
    this.#svg.addEventListener("dblclick", (event) => {
      if (this.#hit(event)) this.#remove();
    });
    by("undo").addEventListener("click", () => this.#travel("undo"));
    by("redo").addEventListener("click", () => this.#travel("redo"));
    by("remove").addEventListener("click", () => this.#remove());
    by("save-tf").addEventListener("click", () => save("view.tf", format(this.#transfer)));
    by("preset").addEventListener("change", () => this.#choose(by("preset").value));
    by("point-at").addEventListener("change", () => this.#change({ at: Number(by("point-at").value) }));
    by("point-opacity").addEventListener("change", () => this.#change({ opacity: Number(by("point-opacity").value) }));
    by("point-colour").addEventListener("input", () => this.#change({ colour: from_hex(by("point-colour").value) },
      true));
    by("point-colour").addEventListener("change", () => this.#change({}));
  }

  /** @param {Hello} hello */
  open(hello) {
    this.#presets = hello.presets;
    this.#range = hello.volume?.range ?? [0, 1];
    const first = hello.volume?.own_look ? "the input's own" : "auto: by the values";
    const own = [new Option(first, "")];
    this.#look = hello.volume?.look ?? "";
    this.#why = hello.volume?.look_why ?? "";
    const names = [...hello.presets.map((p) => p.name), ...hello.transfer_functions];
    by("preset").replaceChildren(...own, new Option("own points", kOwn),
      ...names.map((name) => new Option(name, name)));
    this.load();
  }

  /** Updates the editor from the view. */
  load() {
    const value = this.view.get("transfer-function");
    const text = value === "" ? this.#look : value.includes("\n") ? value
      : (this.#presets.find((p) => p.name === value)?.text ?? "");
    by("look-why").textContent = value === "" ? this.#why : "";
    by("preset").value = value.includes("\n") ? kOwn : value;
    by("editor").hidden = by("points").hidden = !text; // a file whose points the page does not have
    if (!text || format(parse(text)) === this.#history.now) return this.#draw();
    this.#transfer = parse(text);
    this.#history.put(format(this.#transfer));
    this.#selected = { list: "opacities", index: Math.min(1, this.#transfer.opacities.length - 1) };
    this.#draw();
  }

  /** @param {Histogram} histogram */
  histogram({ counts }) {
    const most = Math.log1p(Math.max(...counts, 1));
    const step = (kWidth - 2 * kEdge) / counts.length;
    const y = (/** @type {number} */ n) => (kHeight - (0.9 * (kHeight - kEdge) * Math.log1p(n)) / most).toFixed(1);
    const line = counts.map((n, i) => `V${y(n)}H${(kEdge + (i + 1) * step).toFixed(2)}`).join("");
    this.#bars.setAttribute("d", `M${kEdge},${kHeight}${line}V${kHeight}Z`);
  }

  /** @param {string} name */
  #choose(name) {
    if (name === kOwn) this.#commit();
    else this.view.set({ "transfer-function": name });
    this.load();
  }

  /** @param {"undo" | "redo"} way */
  #travel(way) {
    this.#history[way]();
    this.#transfer = parse(this.#history.now);
    this.#selected.index = Math.min(this.#selected.index, this.#transfer[this.#selected.list].length - 1);
    this.view.set({ "transfer-function": this.#history.now });
    by("preset").value = kOwn;
    this.#draw();
  }

  #commit(moving = false) {
    const text = format(this.#transfer);
    if (!moving) this.#history.put(text);
    this.view.set({ "transfer-function": text }, moving);
    by("preset").value = kOwn;
    this.#draw();
  }

  #ends() { return this.#transfer.normalised ? [0, 1] : this.#range; }
  /** @param {number} at */
  #x(at) {
    const [low, high] = this.#ends();
    return kEdge + ((at - low) / (high - low || 1)) * (kWidth - 2 * kEdge);
  }
  /** @param {number} opacity */
  #y(opacity) { return kHeight - opacity * (kHeight - kEdge); }
  /** @param {MouseEvent} event */
  #place(event) {
    const box = this.#svg.getBoundingClientRect();
    const [low, high] = this.#ends();
    const x = ((event.clientX - box.left) / box.width) * kWidth, y = ((event.clientY - box.top) / box.height) * kTotal;
    return {
      at: low + Math.max(0, Math.min(1, (x - kEdge) / (kWidth - 2 * kEdge))) * (high - low),
      opacity: Math.max(0, Math.min(1, (kHeight - y) / (kHeight - kEdge))),
      strip: y > kHeight + 6,
    };
  }
  /** @param {Event} event */
  #hit(event) {
    return /** @type {Element} */ (event.target).closest("[data-list]");
  }

  /** @param {PointerEvent} event */
  #press(event) {
    const point = /** @type {SVGElement | null} */ (this.#hit(event));
    const place = this.#place(event);
    if (point) this.#select(/** @type {any} */ (point.dataset.list), Number(point.dataset.index));
    else {
      const list = place.strip ? "colours" : "opacities";
      const made = { at: place.at, ...(place.strip ? { colour: colour_at(this.#transfer, place.at) }
        : { opacity: place.opacity }) };
      const points = /** @type {any[]} */ (this.#transfer[list]);
      const before = points.findIndex((p) => p.at > place.at);
      const index = before === -1 ? points.length : before;
      points.splice(index, 0, made);
      this.#selected = { list, index };
      this.#commit(true);
    }
    event.preventDefault();
    this.#focus();
    let moved = !point;
    const move = (/** @type {PointerEvent} */ e) => {
      moved = true;
      const { at, opacity } = this.#place(e);
      this.#change(this.#selected.list === "opacities" ? { at, opacity } : { at }, true);
    };
    const end = () => {
      removeEventListener("pointermove", move);
      if (moved) this.#commit();
      this.#focus();
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", end, { once: true });
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const point = /** @type {SVGElement | null} */ (this.#hit(event));
    const is_undo = event.key.toLowerCase() === "z" && (event.ctrlKey || event.metaKey);
    if (!point || (!is_undo && !/^(Arrow.*|Delete|Backspace)$/.test(event.key))) return;
    this.#select(/** @type {any} */ (point.dataset.list), Number(point.dataset.index));
    const { list, index } = this.#selected;
    const now = /** @type {any} */ (this.#transfer[list][index]);
    const [low, high] = this.#ends(), step = (event.shiftKey ? 10 : 1) * 0.005;
    if (event.key === "ArrowLeft") this.#change({ at: now.at - step * (high - low) });
    else if (event.key === "ArrowRight") this.#change({ at: now.at + step * (high - low) });
    else if (event.key === "ArrowUp" && list === "opacities") this.#change(
      { opacity: Math.min(1, now.opacity + step) });
    else if (event.key === "ArrowDown" && list === "opacities") this.#change(
      { opacity: Math.max(0, now.opacity - step) });
    else if (event.key === "Delete" || event.key === "Backspace") this.#remove();
    else if (is_undo) this.#travel(event.shiftKey ? "redo" : "undo");
    else return;
    event.preventDefault();
    this.#focus();
  }

  /** Points stay in order.
   * @param {Partial<ColourPoint & OpacityPoint>} values @param {boolean} [moving] */
  #change(values, moving = false) {
    const { list, index } = this.#selected;
    const points = this.#transfer[list];
    if (!points[index]) return;
    if (values.at !== undefined)
      values.at = Math.max(points[index - 1]?.at ?? -Infinity, Math.min(points[index + 1]?.at ?? Infinity, values.at));
    Object.assign(points[index], values);
    this.#commit(moving);
  }

  #remove() {
    const { list, index } = this.#selected;
    if (this.#transfer[list].length < 2) return;
    this.#transfer[list].splice(index, 1);
    this.#selected.index = Math.max(0, index - 1);
    this.#commit();
  }

  /** @param {"colours" | "opacities"} list @param {number} index */
  #select(list, index) {
    this.#selected = { list, index };
    this.#draw();
  }
  #focus() {
    const { list, index } = this.#selected;
    /** @type {SVGElement | null} */ (
      this.#points.querySelector(`[data-list=${list}][data-index="${index}"]`))?.focus();
  }

  #draw() {
    const { colours, opacities } = this.#transfer;
    const [first, last] = [opacities[0], opacities.at(-1)];
    const line = opacities.map((p) => `L${this.#x(p.at)},${this.#y(p.opacity)}`).join("");
    if (first && last) this.#curve.setAttribute("d",
      `M${kEdge},${this.#y(first.opacity)}${line}L${kWidth - kEdge},${this.#y(last.opacity)}`);
    const [low, high] = this.#ends();
    this.#gradient.replaceChildren(...colours.map((p) => shape("stop",
      { offset: (p.at - low) / (high - low || 1), "stop-color": hex(p.colour) })));
    const dot = (/** @type {"colours" | "opacities"} */ list) => (/** @type {any} */ p, /** @type {number} */ index) =>
      shape("circle", {
        cx: this.#x(p.at), cy: list === "opacities" ? this.#y(p.opacity) : kStrip, r: 6,
        fill: list === "opacities" ? hex(colour_at(this.#transfer, p.at)) : hex(p.colour),
        class: this.#selected.list === list && this.#selected.index === index ? "point selected" : "point",
        tabindex: 0, role: "button", "data-list": list, "data-index": index,
        "aria-label": list === "opacities" ? `opacity ${p.opacity.toFixed(3)} at ${p.at.toPrecision(4)}`
          : `colour ${hex(p.colour)} at ${p.at.toPrecision(4)}`,
      });
    this.#points.replaceChildren(...opacities.map(dot("opacities")), ...colours.map(dot("colours")));
    const point = /** @type {any} */ (this.#transfer[this.#selected.list][this.#selected.index]);
    const is_colour = this.#selected.list === "colours";
    by("point-at").value = point ? String(Number(point.at.toPrecision(5))) : "";
    by("point-opacity").value = point && !is_colour ? String(Number(point.opacity.toFixed(4))) : "";
    by("point-opacity").disabled = is_colour;
    by("point-colour").disabled = !is_colour;
    if (is_colour && point) by("point-colour").value = hex(point.colour);
    by("undo").disabled = !this.#history.can.undo;
    by("redo").disabled = !this.#history.can.redo;
  }
}
