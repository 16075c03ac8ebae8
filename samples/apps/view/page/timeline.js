// Time line of the last frame: a column for each interval between two updates, as wide as its core cycles.
/** @typedef {import("./protocol.js").Counters} Counters */
import { element, shape, short } from "./dom.js";
import { between, cycles_of, kGroups, parts_of } from "./figures.js";

const kWidth = 400, kHeight = 90, kMost = 600; // columns; chosen: more than the chart has pixels

export class TimeLine {
  /** @type {Counters[]} */ #looks = [];
  /** @type {[number, number]} */ #shown = [0, 1];
  #svg = shape("svg", { viewBox: `0 0 ${kWidth} ${kHeight + 14}`, class: "chart", role: "img",
    "aria-label": "time line of the last frame" });
  #part = element("select", { "aria-label": "part" });
  place = element("div", { id: "timeline" }, element("h2", {}, "Time line of the last frame"));

  constructor() {
    const row = element("div", { class: "row" }, this.#part);
    for (const [label, factor] of /** @type {[string, number][]} */ ([["Nearer", 0.5], ["Wider", 2],
      ["All", Infinity]])) {
      const button = element("button", { type: "button" }, label);
      button.addEventListener("click", () => this.#zoom(factor, 0.5));
      row.append(button);
    }
    const note = element("p", { class: "quiet" },
      "Ten updates per second; gicube-board --trace writes every cycle for ui.perfetto.dev.");
    this.place.append(row, this.#svg, note);
    this.#part.addEventListener("change", () => this.#draw());
    this.#svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      const box = this.#svg.getBoundingClientRect();
      this.#zoom(Math.exp(Math.sign(event.deltaY) * 0.3), (event.clientX - box.left) / box.width);
    });
    this.#svg.addEventListener("pointermove", (event) => {
      if (!(event.buttons & 1)) return;
      const step = (-event.movementX / this.#svg.getBoundingClientRect().width) * (this.#shown[1] - this.#shown[0]);
      const move = Math.max(-this.#shown[0], Math.min(1 - this.#shown[1], step));
      this.#shown = [this.#shown[0] + move, this.#shown[1] + move];
      this.#draw();
    });
  }

  /** A new frame begins.
   * @param {Counters} counters */
  clear(counters) {
    this.#looks = [counters];
    this.#shown = [0, 1];
  }

  /** @param {Counters} counters */
  add(counters) {
    if (counters["asic.cycles"] === this.#looks.at(-1)?.["asic.cycles"]) return;
    this.#looks.push(counters);
    if (this.#looks.length > kMost) this.#looks = this.#looks.filter((_, i) => i % 2 === 0 ||
      i === this.#looks.length - 1);
    const parts = ["processor", ...parts_of(counters, "processor", "cycles.busy")];
    if (parts.length !== this.#part.length)
      this.#part.replaceChildren(...parts.map((part) => new Option(part === "processor" ? "all processors" : part,
        part)));
    this.#draw();
  }

  /** Zooms around the position `at`, a share of the chart.
   * @param {number} factor @param {number} at */
  #zoom(factor, at) {
    const [low, high] = this.#shown;
    const width = Math.min(1, (high - low) * factor);
    const begin = Math.max(0, Math.min(1 - width, low + at * (high - low) - at * width));
    this.#shown = [begin, begin + width];
    this.#draw();
  }

  #draw() {
    const cycle = (/** @type {number} */ i) => this.#looks[i]["asic.cycles"] ?? 0;
    this.#svg.replaceChildren();
    if (this.#looks.length < 2) return;
    const first = cycle(0), all = cycle(this.#looks.length - 1) - first;
    const [low, high] = this.#shown;
    const x = (/** @type {number} */ at) => (((at - first) / (all || 1) - low) / (high - low)) * kWidth;
    for (let i = 1; i < this.#looks.length; ++i) {
      const [left, right] = [Math.max(0, x(cycle(i - 1))), Math.min(kWidth, x(cycle(i)))];
      if (right <= left) continue;
      const cycles = cycles_of(between(this.#looks[i], this.#looks[i - 1]), this.#part.value || "processor");
      const sum = cycles.reduce((a, b) => a + b, 0) || 1;
      let y = kHeight;
      cycles.forEach((value, group) => {
        const height = (value / sum) * kHeight;
        y -= height;
        const cycles = `${short(cycle(i - 1) - first)} to ${short(cycle(i) - first)}`;
        const text = `${kGroups[group].name} ${((100 * value) / sum).toFixed(1)}%, core cycles ${cycles} of the frame`;
        if (height > 0) this.#svg.append(shape("rect",
          { x: left, y, width: right - left, height, fill: kGroups[group].colour }, shape("title", {}, text)));
      });
    }
    this.#svg.append(shape("text", { x: 0, y: kHeight + 11 }, `cycle ${short(low * all)}`));
    this.#svg.append(shape("text", { x: kWidth, y: kHeight + 11, "text-anchor": "end" }, short(high * all)));
  }
}
