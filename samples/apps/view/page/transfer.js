// A transfer function as points, its text in the format of gicube-render, and its history.

/** @typedef {{at: number, colour: [number, number, number]}} ColourPoint */
/** @typedef {{at: number, opacity: number}} OpacityPoint */
/** @typedef {{normalised: boolean, colours: ColourPoint[], opacities: OpacityPoint[]}} Transfer */

/** @param {string} text @returns {Transfer} */
export function parse(text) {
  /** @type {Transfer} */
  const made = { normalised: false, colours: [], opacities: [] };
  for (const line of text.split("\n")) {
    const [word, ...rest] = line.replace(/#.*/, "").trim().split(/\s+/);
    const n = rest.map(Number);
    if (word === "values") made.normalised = rest[0] === "normalised";
    else if (word === "colour" || word === "color") made.colours.push({ at: n[0], colour: [n[1], n[2], n[3]] });
    else if (word === "opacity") made.opacities.push({ at: n[0], opacity: n[1] });
  }
  return made;
}

/** @param {Transfer} transfer */
export function format(transfer) {
  const number = (/** @type {number} */ x) => String(Number(x.toPrecision(6)));
  return [
    `values ${transfer.normalised ? "normalised" : "absolute"}`,
    ...transfer.colours.map((p) => `colour ${number(p.at)} ${p.colour.map(number).join(" ")}`),
    ...transfer.opacities.map((p) => `opacity ${number(p.at)} ${number(p.opacity)}`),
    "",
  ].join("\n");
}

/** @param {[number, number, number]} colour */
export const hex = (colour) => `#${colour.map((c) => Math.round(c * 255).toString(16).padStart(2, "0")).join("")}`;
/** @param {string} text @returns {[number, number, number]} */
export const from_hex = (text) => /** @type {any} */ ([1, 3,
  5].map((i) => Number((parseInt(text.slice(i, i + 2), 16) / 255).toFixed(3))));

/** The colour between the points.
 * @param {Transfer} transfer @param {number} at @returns {[number, number, number]} */
export function colour_at(transfer, at) {
  const points = transfer.colours;
  const next = points.findIndex((p) => p.at > at);
  if (next === -1) return points.at(-1)?.colour ?? [1, 1, 1];
  if (next === 0) return points[0].colour;
  const [a, b] = [points[next - 1], points[next]];
  const t = (at - a.at) / (b.at - a.at);
  return /** @type {any} */ (a.colour.map((c, i) => c + t * (b.colour[i] - c)));
}

/** The previous texts, for undo and redo. */
export class History {
  #texts = [""]; // the first is none
  #at = 0;

  get now() { return this.#texts[this.#at]; }
  /** @param {string} text */
  put(text) {
    if (text !== this.now) this.#texts.splice((this.#at += 1), Infinity, text);
  }
  get can() { return { undo: this.#at > 1, redo: this.#at + 1 < this.#texts.length }; }
  undo() {
    if (this.can.undo) this.#at -= 1;
  }
  redo() {
    if (this.can.redo) this.#at += 1;
  }
}
