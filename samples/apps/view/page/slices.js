// Slices along the axes beside the picture, each with a slider.
/** @typedef {import("./socket.js").Connection} Connection */
/** @typedef {import("./protocol.js").SliceHeader} SliceHeader */
/** @typedef {import("./protocol.js").Volume} Volume */
/** @typedef {{axis: "x" | "y" | "z", canvas: HTMLCanvasElement, slider: HTMLInputElement, text: HTMLElement, flying: boolean}} Slice */
import { element } from "./dom.js";

export class Slices {
  #id = 0;
  /** @type {Slice[]} */ #all = [];

  /** @param {HTMLElement} place @param {Connection} connection */
  constructor(place, connection) {
    this.place = place;
    this.connection = connection;
    for (const axis of /** @type {const} */ (["z", "y", "x"])) {
      const canvas = element("canvas", { role: "img", "aria-label": `slice along ${axis}`, width: "1", height: "1" });
      const slider = element("input", { type: "range", min: "0", value: "0", "aria-label": `voxel along ${axis}`, id: `slice-${axis}` });
      const text = element("output", { for: `slice-${axis}` });
      const slice = { axis, canvas, slider, text, flying: false };
      slider.addEventListener("input", () => this.#ask(slice));
      place.append(element("figure", {}, element("div", { class: "plane" }, canvas), element("figcaption", {}, slider, text)));
      this.#all.push(slice);
    }
    connection.on("slice", ({ header, bytes }) => this.#show(header, bytes));
    connection.on("error", () => this.#all.forEach((slice) => (slice.flying = false)));
  }

  /** @param {Volume | null} volume */
  open(volume) {
    this.place.hidden = !volume || volume.world;
    if (!volume || volume.world) return;
    const [x, y, z] = volume.spacing.map((s, i) => s * volume.dims[i]);
    for (const slice of this.#all) {
      const most = volume.dims["xyz".indexOf(slice.axis)] - 1;
      slice.slider.max = String(most);
      slice.slider.value = String(Math.round(most / 2));
      const [width, height] = { x: [y, z], y: [x, z], z: [x, y] }[slice.axis];
      slice.canvas.style.aspectRatio = `${width} / ${height}`;
      slice.canvas.classList.toggle("tall", height > width);
      slice.flying = false;
      this.#ask(slice);
    }
  }

  /** @param {Slice} slice */
  #ask(slice) {
    slice.text.textContent = `${slice.axis} ${slice.slider.value}`;
    if (slice.flying) return;
    slice.flying = true;
    this.connection.send({ do: "slice", id: (this.#id += 1), axis: slice.axis, at: Number(slice.slider.value) });
  }

  /** @param {SliceHeader} header @param {Uint8Array} grey */
  #show(header, grey) {
    const slice = this.#all.find(({ axis }) => axis === header.axis);
    if (!slice) return;
    const { canvas } = slice;
    canvas.width = header.width;
    canvas.height = header.height;
    const pixels = new Uint32Array(grey.length);
    // Rows come from the lowest; along x and y the picture stands with z up.
    for (let row = 0; row < header.height; ++row) {
      const from = (header.axis === "z" ? row : header.height - 1 - row) * header.width;
      for (let i = 0; i < header.width; ++i) pixels[row * header.width + i] = 0xff000000 | (grey[from + i] * 0x010101);
    }
    canvas.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), header.width, header.height), 0, 0);
    slice.flying = false;
    if (header.at !== Number(slice.slider.value)) this.#ask(slice);
  }
}
