// The board's counters, updated ten times per second while this panel is open.
/** @typedef {import("./protocol.js").Machine} Message */
import { by, element, short } from "./dom.js";
import { bars, between, cycles_of, energy_of, figures, kEnergy, legend, parts_of, stacked } from "./figures.js";
import { banks_map, blocks_map, packets_between } from "./maps.js";
import { TimeLine } from "./timeline.js";

const kWindow = 10; // updates in the window of the figures, a second

export class Machine {
  /** @type {Message[]} */ #looks = []; // of the last second
  /** @type {Message | null} */ #begin = null; // at the beginning of the current or last frame
  #most = 1; // rays of a block's queue in it
  /** @type {Record<string, string>} */ #units = {};
  #was_running = false;
  #head = element("p", { class: "quiet", id: "machine-state" }, "No counters yet.");
  #charts = element("div");
  #table = element("table");
  #all = element("table");
  #line = new TimeLine();
  #raw = element("details", {}, element("summary", {}, "All counters, since the board's start"), this.#all);

  /** @param {import("./socket.js").Connection} connection */
  constructor(connection) {
    this.connection = connection;
    by("machine").append(this.#head, this.#charts, this.#table, this.#line.place, this.#raw);
    by("machine-panel").addEventListener("toggle", () => this.listen());
    document.addEventListener("visibilitychange", () => this.listen());
    connection.on("machine", (message) => this.#look(message));
  }

  /** Requests counters while the panel is visible. */
  listen() {
    this.#looks = [];
    this.#was_running = false;
    this.connection.send({ do: "machine", on: by("machine-panel").open && !document.hidden });
  }

  /** @param {Message} message */
  #look(message) {
    const { counters, running } = message;
    if (message.units) this.#units = message.units;
    const last = this.#looks.at(-1);
    if (last && (message.simulated_ms < last.simulated_ms ||
      (counters["pipeline.rays"] ?? 0) < (last.counters["pipeline.rays"] ?? 0))) {
      this.#looks = []; // a new board, whose counters start from 0
      this.#begin = { ...message, counters: {}, look: undefined };
      this.#most = 1;
      this.#line.clear({});
    } else if (!this.#begin || (running && !this.#was_running)) {
      this.#begin = this.#looks.at(-1) ?? message;
      this.#most = 1;
      this.#line.clear(this.#begin.counters);
    }
    this.#was_running = running;
    this.#looks.push(message);
    if (this.#looks.length > kWindow) this.#looks.shift();
    this.#line.add(counters);
    this.#show(message);
  }

  /** @param {Message} message */
  #show({ counters, running, simulated_ms, look }) {
    const since = running ? this.#looks[0] : this.#begin;
    const window = between(counters, since?.counters ?? {});
    const cycles = window["asic.cycles"] ?? 0;
    const what = running ? "a frame runs; figures of the last second"
      : "idle; figures of the last frame, and of what had to be loaded for it";
    const since_start = `${simulated_ms.toFixed(3)} ms simulated since the board's start`;
    this.#head.textContent = `${what} · ${since_start} · ${short(cycles)} core cycles`;
    const processors = parts_of(counters, "processor", "cycles.busy");
    if (processors.length === 0) {
      this.#charts.replaceChildren(element("p", { class: "quiet" },
        "The functional level keeps no cycles: choose the level cycle, below Board."));
    } else {
      const sums = cycles_of(window);
      const memory = "rdram.cycles" in counters ? "rdram" : "ddr";
      this.#charts.replaceChildren(
        element("h2", {}, "Cycles by cause: what each processor does, or waits for"),
        stacked([["all", sums], ...processors.map((part, i) => /** @type {[string, number[]]} */ ([`processor ${i}`,
          cycles_of(window, part)]))], "cycles by cause"),
        legend(sums),
        ...this.#queues(counters, look),
        element("h2", {}, `Bandwidth used of each ${memory} channel`),
        bars(parts_of(counters, memory, "cycles").map((part) => {
          const share = window[`${part}.data_busy`] / (window[`${part}.cycles`] || 1);
          return [part, share, `${(100 * share).toFixed(1)}%`];
        }), "bandwidth used"),
        ...this.#energy(window),
        ...(look?.memories.length ? [element("h2", {}, "Packets of each bank"),
          ...banks_map(packets_between(look, since?.look), look.banks, memory)] : []),
      );
    }
    this.#table.replaceChildren(...figures(window).map(([label, , text]) => element("tr", {}, element("td", {}, label),
      element("td", {}, text))));
    if (!this.#raw.open) return;
    this.#all.replaceChildren(...Object.entries(counters).map(([name, value]) =>
      element("tr", {}, element("td", {}, name), element("td", {}, String(value)),
        element("td", {}, String(this.#units[name] ?? "")))));
  }

  /** @param {Message["counters"]} window */
  #energy(window) {
    const parts = energy_of(window);
    if (!window["energy.total"]) return [];
    const [total, low, high] = ["", ".low", ".high"].map((end) => short(window[`energy.total${end}`] / 1e9));
    return [
      element("h2", {}, `Energy: ${total} mJ (${low} to ${high}), by part`),
      stacked([["the card", parts]], "energy by part", kEnergy),
      legend(parts, kEnergy),
    ];
  }

  /** The number of rays in flight, and where they wait.
   * @param {Message["counters"]} counters @param {Message["look"]} look */
  #queues(counters, look) {
    if (!look) return [];
    this.#most = Math.max(this.#most, ...look.waiting);
    const frame = between(counters, this.#begin?.counters ?? {});
    const waiting = look.processors.reduce((sum, rays) => sum + rays, 0);
    const under_way = Math.max(waiting, frame["dsp.rays_sent"] - frame["dsp.rays_taken"] - frame["dsp.overflows"]);
    const most = Math.max(1, ...look.processors);
    return [
      element("h2", {}, `Rays: ${short(under_way)} under way, ${short(waiting)} of them in queues`),
      bars(look.processors.map((rays, i) => [`processor ${i}`, rays / most, short(rays)]), "rays in queues"),
      ...blocks_map(look, this.#most),
    ];
  }
}
