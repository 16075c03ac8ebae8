// Slices along the axes beside the picture, linked by one point, and a projection along the picture's rays, with one
// window of values.
/** @typedef {import("./socket.js").Connection} Connection */
/** @typedef {import("./protocol.js").SliceHeader} SliceHeader */
/** @typedef {import("./protocol.js").Volume} Volume */
/** @typedef {"x" | "y" | "z"} Axis */
/** @typedef {{canvas: HTMLCanvasElement, words: Uint16Array, width: number, height: number, upwards: boolean}} Shown */
/** @typedef {Shown & {axis: Axis, figure: HTMLElement, cross: SVGElement, slider: HTMLInputElement, text: HTMLElement,
 *   flying: boolean, at: number}} Slice */
import { by, element, shape } from "./dom.js";

const kMost = 4095; // of a slice's words
/** Axes across and upwards. Along x and y the picture stands with z up; along z rows go down, as a radiologist sees a
 * patient from below. */
const kPlanes = /** @type {const} */ ({ x: [1, 2], y: [0, 2], z: [0, 1] });

export class Slices extends EventTarget {
  #id = 0;
  /** @type {Slice[]} */ #all = [];
  /** @type {Volume | null} */ #volume = null;
  /** @type {[number, number, number]} */ point = [0, 0, 0];
  #low = 0;
  #high = 1;
  /** @type {Shown} */ #projection = { canvas: by("projected"), words: new Uint16Array(), width: 1, height: 1,
    upwards: false };

  /** @param {HTMLElement} place @param {Connection} connection */
  constructor(place, connection) {
    super();
    this.place = place;
    this.connection = connection;
    for (const axis of /** @type {const} */ (["z", "y", "x"])) {
      const canvas = element("canvas", { role: "img", tabindex: "0", width: "1", height: "1",
        "aria-label": `slice along ${axis}`,
        "aria-description": "Arrow keys move the point, Page Up and Page Down change the slice." });
      const cross = shape("svg", { class: "cross", "aria-hidden": "true", viewBox: "0 0 100 100",
        preserveAspectRatio: "none" });
      const slider = element("input", { type: "range", min: "0", value: "0", "aria-label": `voxel along ${axis}`,
        id: `slice-${axis}` });
      const text = element("output", { for: `slice-${axis}` });
      const larger = element("button", { type: "button", "aria-pressed": "false", class: "larger" }, "Larger");
      const figure = element("figure", {}, element("div", { class: "plane" },
        element("div", { class: "page" }, canvas, cross)),
        element("figcaption", {}, slider, element("div", { class: "row nowrap" }, text, larger)));
      const slice = { axis, figure, canvas, cross, slider, text, flying: false, at: -1, words: new Uint16Array(),
        width: 1, height: 1, upwards: axis !== "z" };
      slider.addEventListener("input", () => this.#move(slice.axis, Number(slider.value)));
      larger.addEventListener("click", () => {
        const is = figure.classList.toggle("large");
        larger.setAttribute("aria-pressed", String(is));
        document.body.classList.toggle("reading", this.place.querySelector(".large") !== null);
      });
      this.#hear(slice);
      by("planes").append(figure);
      this.#all.push(slice);
    }
    by("projection").addEventListener("change", () => (by("projected").hidden = true));
    by("projected").addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
      const { canvas, width, height, words } = this.#projection, box = canvas.getBoundingClientRect();
      const x = Math.floor(((event.clientX - box.left) / box.width) * width);
      const y = Math.floor(((event.clientY - box.top) / box.height) * height);
      by("value").textContent = `${by("projection").value}: ${this.#read(words[y * width + x])} ${this.#volume?.unit}`;
    });
    connection.on("projection", ({ header: { width, height }, bytes }) => {
      if (!by("projection").value) return;
      Object.assign(this.#projection, { width, height, words: new Uint16Array(bytes.slice().buffer) });
      by("projected").hidden = false;
      this.#draw(this.#projection);
    });
    for (const name of ["level", "window"]) {
      by(name).addEventListener("change", () => {
        const [level, width] = [Number(by("level").value), Number(by("window").value)];
        if (Number.isFinite(level) && width > 0) this.#show_values(level - width / 2, level + width / 2);
        else this.#show_values(this.#low, this.#high);
      });
    }
    connection.on("slice", ({ header, bytes }) => this.#take(header, bytes));
    connection.on("error", () => this.#all.forEach((slice) => (slice.flying = false)));
  }

  /** @param {Volume | null} volume */
  open(volume) {
    this.place.hidden = !volume || volume.world;
    this.#volume = volume && !volume.world ? volume : null;
    if (!this.#volume) return;
    const { dims, spacing, window } = this.#volume;
    [this.#low, this.#high] = window;
    by("unit").textContent = this.#volume.unit;
    by("projected").hidden = true;
    by("projection").disabled = this.#volume.labels !== undefined;
    this.point = /** @type {any} */ (dims.map((n) => Math.round((n - 1) / 2)));
    const edges = spacing.map((s, i) => s * dims[i]);
    for (const slice of this.#all) {
      slice.slider.max = String(dims["xyz".indexOf(slice.axis)] - 1);
      const [width, height] = kPlanes[slice.axis].map((i) => edges[i]);
      slice.canvas.style.aspectRatio = `${width} / ${height}`;
      slice.figure.style.setProperty("--ratio", String(width / height));
      slice.words = new Uint16Array();
      slice.at = -1;
      slice.flying = false;
    }
    this.#show_values(this.#low, this.#high);
    this.#go(this.point);
  }

  /** @param {Axis} axis @param {number} at */
  #move(axis, at) {
    const point = /** @type {[number, number, number]} */ ([...this.point]);
    point["xyz".indexOf(axis)] = at;
    this.#go(point);
  }

  /** @param {[number, number, number]} point */
  #go(point) {
    const { dims } = /** @type {Volume} */ (this.#volume);
    this.point = /** @type {any} */ (point.map((at, i) => Math.max(0, Math.min(dims[i] - 1, Math.round(at)))));
    for (const slice of this.#all) {
      const at = this.point["xyz".indexOf(slice.axis)];
      slice.slider.value = String(at);
      if (slice.at !== at) {
        slice.at = at;
        this.#ask(slice);
      }
      this.#cross(slice);
    }
    this.#tell(this.#all[0]);
    this.dispatchEvent(new CustomEvent("point"));
  }

  /** @param {Slice} slice */
  #ask(slice) {
    slice.text.textContent = `${slice.axis} ${slice.slider.value}`;
    if (slice.flying || !this.#volume) return;
    slice.flying = true;
    this.connection.send({ do: "slice", id: (this.#id += 1), axis: slice.axis, at: Number(slice.slider.value) });
  }

  /** @param {SliceHeader} header @param {Uint8Array} bytes */
  #take(header, bytes) {
    const slice = this.#all.find(({ axis }) => axis === header.axis);
    if (!slice) return;
    slice.width = header.width;
    slice.height = header.height;
    slice.words = new Uint16Array(bytes.slice().buffer);
    slice.flying = false;
    this.#draw(slice);
    this.#tell(slice);
    if (header.at !== slice.at) this.#ask(slice);
  }

  /** @param {Shown} shown */
  #draw({ canvas, words, width, height, upwards }) {
    if (words.length === 0 || !this.#volume) return;
    canvas.width = width;
    canvas.height = height;
    const [low, high] = this.#volume.range, labels = this.#volume.labels;
    const scale = (high - low) / kMost, gain = 255 / (this.#high - this.#low || 1);
    const pixels = new Uint32Array(words.length);
    const grey = (/** @type {number} */ word) => {
      const level = Math.max(0, Math.min(255, Math.round((low + word * scale - this.#low) * gain)));
      return 0xff000000 | (level * 0x010101);
    };
    const colours = labels?.map(({ colour }) => 0xff000000 | (colour[2] << 16) | (colour[1] << 8) | colour[0]);
    for (let row = 0; row < height; ++row) {
      const from = (upwards ? height - 1 - row : row) * width;
      for (let i = 0; i < width; ++i) pixels[row * width + i] = colours ? (colours[words[from + i]] ?? 0xff000000)
        : grey(words[from + i]);
    }
    canvas.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), width, height), 0, 0);
  }

  /** @param {number} low @param {number} high */
  #show_values(low, high) {
    [this.#low, this.#high] = [low, high];
    by("level").value = String(Number(((low + high) / 2).toPrecision(4)));
    by("window").value = String(Number((high - low).toPrecision(4)));
    for (const shown of [...this.#all, this.#projection]) this.#draw(shown);
  }

  /** The point, and what lies at the edges.
   * @param {Slice} slice */
  #cross(slice) {
    if (!this.#volume) return;
    const { dims, marks } = this.#volume;
    const [across, up] = kPlanes[slice.axis];
    const x = (100 * (this.point[across] + 0.5)) / dims[across];
    const y = (slice.axis === "z" ? 0 : 100) + ((slice.axis === "z" ? 100 : -100) * (this.point[up] + 0.5)) / dims[up];
    slice.cross.replaceChildren(shape("path", { d: `M${x},0V100M0,${y}H100` }));
    const [below, above] = slice.axis === "z" ? [2 * up + 1, 2 * up] : [2 * up, 2 * up + 1];
    const edges = { left: marks[2 * across], right: marks[2 * across + 1], bottom: marks[below], top: marks[above] };
    slice.canvas.parentElement?.querySelectorAll(".mark").forEach((mark) => mark.remove());
    for (const [edge, text] of Object.entries(edges)) slice.canvas.parentElement?.append(element("span",
      { class: `mark ${edge}` }, text));
  }

  /** The voxel under the pointer.
   * @param {Slice} slice @param {PointerEvent} event @returns {[number, number, number]} */
  #voxel(slice, event) {
    const { dims } = /** @type {Volume} */ (this.#volume);
    const box = slice.canvas.getBoundingClientRect();
    const [across, up] = kPlanes[slice.axis];
    const x = (event.clientX - box.left) / box.width, y = (event.clientY - box.top) / box.height;
    const voxel = /** @type {[number, number, number]} */ ([...this.point]);
    voxel[across] = Math.floor(x * dims[across]);
    voxel[up] = Math.floor((slice.axis === "z" ? y : 1 - y) * dims[up]);
    return /** @type {any} */ (voxel.map((at, i) => Math.max(0, Math.min(dims[i] - 1, at))));
  }

  /** @param {number} word */
  #read(word) {
    const [low, high] = /** @type {Volume} */ (this.#volume).range;
    return Number((low + (word * (high - low)) / kMost).toPrecision(5));
  }

  /** The value there, in the file's unit.
   * @param {Slice} slice @param {[number, number, number]} [voxel] */
  #tell(slice, voxel = this.point) {
    if (!this.#volume || slice.words.length === 0) return;
    const { unit, labels, whole } = this.#volume;
    const [across, up] = kPlanes[slice.axis];
    const word = slice.words[voxel[up] * slice.width + voxel[across]];
    const value = labels ? labels[word]?.value : whole ? Math.round(this.#read(word)) : this.#read(word);
    const place = voxel.map((at, i) => `${"xyz"[i]} ${at}`).join(", ");
    by("value").textContent = `${place}: ${labels ? "label " : ""}${value ?? ""} ${unit}`;
  }

  /** @param {Slice} slice */
  #hear(slice) {
    const { canvas, axis } = slice;
    /** @type {{x: number, y: number, values: boolean} | null} */
    let held = null;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      held = { x: event.clientX, y: event.clientY, values: event.shiftKey || event.button !== 0 };
      if (!held.values) this.#go(this.#voxel(slice, event));
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (held = null));
    canvas.addEventListener("pointermove", (event) => {
      if (!this.#volume) return;
      if (held?.values) {
        // Across: the window's width; up: its level. The picture's width is the range of the values.
        const size = canvas.getBoundingClientRect().width || 1, span = this.#volume.window[1] - this.#volume.window[0];
        const width = Math.max(span / 1000, this.#high - this.#low + ((event.clientX - held.x) / size) * span);
        const level = (this.#low + this.#high) / 2 + ((held.y - event.clientY) / size) * span;
        held = { ...held, x: event.clientX, y: event.clientY };
        this.#show_values(level - width / 2, level + width / 2);
      } else if (held) this.#go(this.#voxel(slice, event));
      this.#tell(slice, this.#voxel(slice, event));
    });
    canvas.addEventListener("pointerleave", () => this.#tell(slice));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("dblclick", () => this.#volume && this.#show_values(...this.#volume.window));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.#move(axis, this.point["xyz".indexOf(axis)] - Math.sign(event.deltaY));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const [across, up] = kPlanes[axis], down = axis === "z" ? 1 : -1;
      /** @type {Record<string, [number, number]>} */
      const steps = { ArrowLeft: [across, -1], ArrowRight: [across, 1], ArrowUp: [up, -down], ArrowDown: [up, down],
        PageUp: ["xyz".indexOf(axis), 1], PageDown: ["xyz".indexOf(axis), -1] };
      const step = steps[event.key];
      if (!step) return;
      event.preventDefault();
      this.#move(/** @type {Axis} */ ("xyz"[step[0]]), this.point[step[0]] + step[1] * (event.shiftKey ? 10 : 1));
    });
  }
}
