// Compares a frame on boards of two configurations.
/** @typedef {import("./protocol.js").ComparedFrame} ComparedFrame */
import { by, element } from "./dom.js";
import { cycles_of, figures, legend, stacked } from "./figures.js";

/** Suggested fields, with two values each.
 * @type {Record<string, [string, string]>} */
const kFields = {
  "asic.processors": ["4", "8"], "asic.queue_rays": ["256", "64"], "asic.block_voxels": ["32", "16"],
  "asic.partition": ["simple_slab", "skewed_block"], "asic.core_khz": ["100000", "200000"],
  "sorter.policy": ["most_rays", "longest_wait"], "cache.ways": ["1", "4"], "link.bits": ["32", "128"],
  "memory": ["rdram", "ddr"], "bus.model": ["pci33", "agp2x"], "dsp.clock_khz": ["200000", "400000"],
};

export const kFirstId = 2 ** 40; // those of pictures are smaller

export class Compare {
  #id = kFirstId;
  #field = element("input", { type: "text", list: "fields", value: "asic.processors", id: "compare-field",
    autocomplete: "off" });
  #values = ["4", "8"].map((value, i) => element("input", { type: "text", class: "number", value, id: `compare-${i}`,
    "aria-label": `value ${i + 1}` }));
  #size = element("select", { id: "compare-size" },
    ...["64x64", "128x128", "256x256", "512x512"].map((size) => new Option(size, size, size === "128x128",
    size === "128x128")));
  #run = element("button", { type: "button", id: "compare-run" }, "Compare");
  #result = element("div", { id: "compared", role: "status" });

  /** @param {import("./socket.js").Connection} connection @param {import("./view.js").ViewState} view */
  constructor(connection, view) {
    this.connection = connection;
    this.view = view;
    const list = element("datalist", { id: "fields" }, ...Object.keys(kFields).map((name) => new Option(name)));
    const form = element("div", { class: "row" }, list, element("label", { for: "compare-field" }, "Field"),
      this.#field, ...this.#values, this.#size, this.#run);
    by("compare").append(form, this.#result);
    this.#field.addEventListener("change", () => kFields[this.#field.value]?.forEach((value, i) =>
      (this.#values[i].value = value)));
    this.#run.addEventListener("click", () => this.#ask());
    connection.on("compared", (message) => message.id === this.#id && this.#show(message));
    connection.on("error", ({ id, text }) => id === this.#id && this.#end(text));
    connection.on("close", () => this.#end(""));
    connection.on("board", () => this.#end(""));
  }

  /** @param {import("./protocol.js").Hello} hello */
  open(hello) {
    this.#run.disabled = !hello.volume;
  }

  #ask() {
    this.#id += 1;
    const [settings, other] = this.#values.map(({ value }) => ({
      ...this.view.own, fidelity: "cycle", size: this.#size.value, [this.#field.value.trim()]: value.trim(),
    }));
    this.#run.disabled = true;
    this.#result.textContent =
      "Both boards are rendering, which is slow at the cycle level. Another picture stops it.";
    this.connection.send({ do: "compare", id: this.#id, settings, other });
  }

  /** @param {string} text */
  #end(text) {
    if (!this.#run.disabled || !this.view.chosen.input) return;
    this.#run.disabled = false;
    this.#result.textContent = text;
  }

  /** @param {{frames: [ComparedFrame, ComparedFrame], same: boolean}} message */
  #show({ frames, same }) {
    this.#end("");
    const field = this.#field.value.trim();
    const names = frames.map(({ settings }) => settings[field]);
    const [a, b] = frames.map((frame) => /** @type {[string, number, string][]} */ (
      [["frame, simulated ms", frame.frame_ms ?? NaN, frame.frame_ms?.toFixed(3) ?? "–"], ...figures(frame.counters)]));
    const rows = a.map(([label, value, text]) => {
      const other = b.find(([name]) => name === label);
      const ratio = other ? other[1] / value : NaN;
      const cells = [text, other?.[2] ?? "–", Number.isFinite(ratio) ? `× ${ratio.toPrecision(3)}` : "–"];
      return element("tr", {}, element("td", {}, label),
        ...cells.map((cell, i) => element("td", i === 2 && cell !== "× 1.00" ? { class: "differs" } : {}, cell)));
    });
    const cycles = frames.map(({ counters }) => cycles_of(counters));
    this.#result.replaceChildren(
      element("p", {}, same ? "The pictures are the same, bit for bit." : "The pictures differ."),
      stacked(names.map((name, i) => [String(name), cycles[i]]), `cycles by cause of both, ${field}`),
      legend(cycles[0].map((value, i) => value + cycles[1][i])),
      element("table", {}, element("tr", {}, ...[field, ...names, "second to first"].map((text) => element("th", {},
        String(text)))), ...rows),
    );
  }
}
