// Charts of the machine's counters: causes as stacked bars, shares and rates. Colours: Okabe and Ito.
/** @typedef {import("./protocol.js").Counters} Counters */
import { element, shape, short } from "./dom.js";

/** @typedef {{name: string, causes: string[], colour: string, why: string}[]} Groups */

/** @type {Groups} */
export const kGroups = [
  { name: "samples", causes: ["busy"], colour: "#009e73", why: "a sample entered the pipeline" },
  { name: "leaps", causes: ["leap"], colour: "#56b4e9", why: "a ray skipped an empty block" },
  { name: "cache", causes: ["cache_fill", "cache_miss"], colour: "#e69f00", why: "waits for the volume cache" },
  { name: "memory", causes: ["memory_bank", "refresh"], colour: "#d55e00", why: "waits for the memory's banks" },
  { name: "latency", causes: ["latency"], colour: "#f0e442",
    why: "all its rays are on their way through the pipeline" },
  { name: "sorter", causes: ["sorter"], colour: "#0072b2", why: "rays wait in queues for the sorter" },
  { name: "no rays", causes: ["queue_empty", "dsp_compute", "sdram"], colour: "#cc79a7",
    why: "others have the rays, or the DSP has not made them yet" },
  { name: "ray bus, links", causes: ["ray_bus", "link"], colour: "#5b5b5b",
    why: "a ray waits for the ray bus or a link" },
  { name: "deposits", causes: ["splat"], colour: "#999999", why: "the cache is busy with deposits" },
];

/** Parts of the card whose energy is counted.
 * @type {Groups} */
export const kEnergy = [
  { name: "memory", causes: ["memory", "memory_interface"], colour: "#0072b2", why: "of the volume, with its wires" },
  { name: "SDRAM", causes: ["sdram"], colour: "#56b4e9", why: "of the DSP" },
  { name: "DSP", causes: ["dsp"], colour: "#e69f00", why: "at work and at rest" },
  { name: "clock", causes: ["clock"], colour: "#999999", why: "registers and clock tree of the ASIC" },
  { name: "on-chip memories", causes: ["queues", "cache", "tables", "leakage"], colour: "#cc79a7",
    why: "ray queues, caches, tables, and their leakage" },
  { name: "logic", causes: ["sorters", "pipelines"], colour: "#009e73", why: "sorters and pipelines" },
  { name: "buses, links", causes: ["links", "ray_bus", "host_bus"], colour: "#5b5b5b",
    why: "links, ray bus, host bus" },
];

/** Picojoules of each group.
 * @param {Counters} counters @returns {number[]} */
export const energy_of = (counters) =>
  kEnergy.map(({ causes }) => causes.reduce((sum, part) => sum + (counters[`energy.${part}`] ?? 0), 0));

/** Cycles of each group; part: as "processor3", or the sum of all.
 * @param {Counters} counters @param {string} [part] @returns {number[]} */
export const cycles_of = (counters, part = "processor") =>
  kGroups.map(({ causes }) => causes.reduce((sum, cause) => sum + (counters[`${part}.cycles.${cause}`] ?? 0), 0));

/** The differences of the counters of two states.
 * @param {Counters} end @param {Counters} begin @returns {Counters} */
export const between = (end, begin) => Object.fromEntries(Object.entries(end).map(([name, value]) => [name,
  value - (begin[name] ?? 0)]));

/** The names of the board's parts of a kind, found by a counter that each has.
 * @param {Counters} counters @param {string} kind @param {string} counter */
export function parts_of(counters, kind, counter) {
  const parts = [];
  while (`${kind}${parts.length}.${counter}` in counters) parts.push(`${kind}${parts.length}`);
  return parts;
}

const kLabel = 74, kBar = 320, kRow = 16;

/** Bars of shares, one a row: label, cycles or joules of each group.
 * @param {[string, number[]][]} rows @param {string} title @param {Groups} [groups] */
export function stacked(rows, title, groups = kGroups) {
  const svg = shape("svg", { viewBox: `0 0 ${kLabel + kBar} ${rows.length * kRow + 2}`, class: "chart", role: "img",
    "aria-label": title });
  rows.forEach(([label, cycles], row) => {
    svg.append(shape("text", { x: 0, y: row * kRow + 11 }, label));
    const sum = cycles.reduce((a, b) => a + b, 0);
    let x = kLabel;
    cycles.forEach((value, group) => {
      const width = sum > 0 ? (value / sum) * kBar : 0;
      const percent = ((100 * value) / (sum || 1)).toFixed(1);
      const text = `${label}: ${groups[group].name} ${percent}%, ${groups[group].why}`;
      if (width > 0) svg.append(shape("rect", { x, y: row * kRow + 1, width, height: kRow - 3,
        fill: groups[group].colour }, shape("title", {}, text)));
      x += width;
    });
  });
  return svg;
}

/** Bars of one share each: label, 0..1, text.
 * @param {[string, number, string][]} rows @param {string} title */
export const bars = (rows, title) => element("table", { class: "bars", "aria-label": title },
  ...rows.map(([label, share, text]) =>
  element("tr", {}, element("td", {}, label), element("td", {},
    element("progress", { value: String(share || 0), "aria-label": label })), element("td", {}, text))));

/** The groups with non-zero values, with their shares.
 * @param {number[]} cycles @param {Groups} [groups] */
export function legend(cycles, groups = kGroups) {
  const sum = cycles.reduce((a, b) => a + b, 0);
  return element("ul", { class: "legend" }, ...groups.flatMap(({ name, colour, why }, group) => {
    if (!cycles[group]) return [];
    const mark = shape("svg", { viewBox: "0 0 10 10", "aria-hidden": "true" },
      shape("rect", { width: 10, height: 10, fill: colour }));
    return [element("li", { title: why }, mark, `${name} ${((100 * cycles[group]) / sum).toFixed(1)}%`)];
  }));
}

/** @param {number} share */
const percent = (share) => (Number.isFinite(share) ? `${(100 * share).toFixed(1)}%` : "–");

/** Figures computed from counters: label, value, text. Those that the level does not model are omitted.
 * @param {Counters} d @returns {[string, number, string][]} */
export function figures(d) {
  const memory = "rdram.cycles" in d ? "rdram" : "ddr";
  const of = (/** @type {string} */ name) => d[name] ?? NaN;
  const cycles = cycles_of(d).reduce((a, b) => a + b, 0);
  const rows = of(`${memory}.row_hits`) + of(`${memory}.row_misses`) + of(`${memory}.row_conflicts`);
  /** @type {[string, number, (value: number) => string][]} */
  const all = [
    ["rays ended", of("pipeline.rays"), short],
    ["samples", of("pipeline.samples"), short],
    ["samples a cycle of a processor", of("processor.samples") / cycles, (x) => x.toFixed(3)],
    ["leaps", of("pipeline.leaps"), short],
    ["cache hit ratio", 1 - of("processor.cache.missed_voxels") / (8 * of("processor.cache.checks")), percent],
    ["rays issued from queues", of("processor.sorter.issued"), short],
    ["rays that found a queue full", of("processor.sorter.overflows"), short],
    ["rays that changed processor", of("link.rays_sent"), short],
    ["links busy, of link cycles", of("link.busy"), short],
    [`${memory}: bandwidth used`, of(`${memory}.data_busy`) / of(`${memory}.cycles`), percent],
    [`${memory}: packets in an open row`, of(`${memory}.row_hits`) / rows, percent],
    ["DSP busy, simulated ms", of("dsp.busy_ps") / 1e9, (x) => x.toFixed(3)],
    ["bus down, bytes", of("bus.down.bytes"), short],
    ["bus up, bytes", of("bus.up.bytes"), short],
    ["bus busy, simulated ms", (of("bus.down.busy_ps") + of("bus.up.busy_ps")) / 1e9, (x) => x.toFixed(3)],
  ];
  return all.filter(([, value]) => Number.isFinite(value)).map(([label, value, text]) => [label, value, text(value)]);
}
