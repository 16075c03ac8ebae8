// Maps of waiting rays by block of the volume, and of packets by memory bank, with a square for each number.
/** @typedef {import("./protocol.js").Look} Look */
import { element, short } from "./dom.js";

// Colours from few to many: cividis, which suits colour-blind users. Zero is grey.
const kRamp = [[0, 32, 77], [65, 77, 107], [124, 123, 120], [185, 172, 112], [255, 234, 70]];
const kNothing = [128, 128, 128, 70];

/** @param {number} share of the most, 0..1 */
function colour(share) {
  const at = Math.min(1, share) * (kRamp.length - 1), low = Math.min(Math.floor(at), kRamp.length - 2);
  return [...kRamp[low].map((value, i) => Math.round(value + (at - low) * (kRamp[low + 1][i] - value))), 255];
}

/** Grids of width x height numbers, `across` of them side by side; a square is a pixel, which the page's style
 * enlarges.
 * @param {number[]} values @param {number} most @param {[number, number, number]} shape width, height, across @param
 * {string} title */
function squares(values, most, [width, height, across], title) {
  const grids = Math.ceil(values.length / (width * height)), columns = Math.min(across, grids);
  const canvas = element("canvas", { class: "map", role: "img", "aria-label": title });
  canvas.width = columns * (width + 1) - 1;
  canvas.height = Math.ceil(grids / columns) * (height + 1) - 1;
  canvas.style.width = `min(100%, ${canvas.width * 12}px)`;
  const pixels = new ImageData(canvas.width, canvas.height);
  values.forEach((value, i) => {
    const grid = Math.floor(i / (width * height)), x = i % width, y = Math.floor(i / width) % height;
    const column = (grid % columns) * (width + 1) + x, row = Math.floor(grid / columns) * (height + 1) + y;
    pixels.data.set(value > 0 ? colour(value / most) : kNothing, 4 * (row * canvas.width + column));
  });
  canvas.getContext("2d")?.putImageData(pixels, 0, 0);
  return canvas;
}

/** A map with its scale and a line of text.
 * @param {HTMLElement} map @param {number} most @param {string} unit @param {string} text */
function explained(map, most, unit, text) {
  const ramp = squares(Array.from({ length: 24 }, (_, i) => i + 1), 24, [24, 1, 1], "colours from few to many");
  return [map, element("p", { class: "scale" }, "grey: none · 1 ", ramp, ` ${short(most)} ${unit}`),
    element("p", { class: "quiet" }, text)];
}

/** @param {number[]} values */
const fullest = (values) => values.reduce((best, value, i) => (value > values[best] ? i : best), 0);

/** @param {Look} look @param {number} most rays of a cell in this frame so far */
export function blocks_map({ blocks_a_side, cells: [x, y, z], waiting }, most) {
  if (waiting.length === 0) return [element("p", { class: "quiet" }, "One queue has the rays of all blocks.")];
  const cell = blocks_a_side === 1 ? "block" : `cube of ${blocks_a_side}³ blocks`;
  const at = fullest(waiting), used = waiting.filter((rays) => rays > 0).length;
  const place = `${at % x} ${Math.floor(at / x) % y} ${Math.floor(at / (x * y))}`;
  const where = used ? `most in ${cell} ${place}: ${waiting[at]}` : "in none";
  const map = squares(waiting, most, [x, y, Math.ceil(Math.sqrt((4 * z * y) / x))], `rays waiting by ${cell}`);
  return explained(map, most, `rays waiting for a ${cell}`,
    `${z} layers from z = 0 on, x across, y down. Rays wait in ${used} of ${waiting.length}, ${where}.`);
}

/** Packets of each bank between two states; the total if the first is of another board or missing.
 * @param {Look} end @param {Look | undefined} begin @returns {number[][]} */
export function packets_between(end, begin) {
  const window = end.memories.map((all, i) => all.map((packets, bank) => packets - (begin?.memories[i]?.[bank] ?? 0)));
  return window.flat().some((packets) => packets < 0) ? end.memories : window;
}

/** @param {number[][]} packets @param {number} banks of a device @param {string} memory */
export function banks_map(packets, banks, memory) {
  const all = packets.flat(), at = fullest(all), most = Math.max(all[at], 1), channel = packets[0].length;
  const device = channel > banks ? `device ${Math.floor((at % channel) / banks)}, ` : "";
  const mean = all.reduce((sum, value) => sum + value, 0) / all.length;
  const text = `A row for each device of ${memory}0 to ${memory}${packets.length - 1}, ` +
    `banks 0 to ${banks - 1} across. ` +
    `Most: ${memory}${Math.floor(at / channel)}, ${device}bank ${at % banks}; the mean is ${short(mean)}.`;
  return explained(squares(all, most, [banks, channel / banks, 1], "packets by bank"), most, "packets of a bank", text);
}
