// Elements of the page.

/** @template {keyof HTMLElementTagNameMap} T @param {T} name @param {Record<string, string>} [attributes] @param
 * {...(Node | string)} inside
 * @returns {HTMLElementTagNameMap[T]} */
export function element(name, attributes = {}, ...inside) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...inside);
  return made;
}

/** @param {string} name @param {Record<string, string | number>} [attributes] @param {...(Node | string)} inside */
export function shape(name, attributes = {}, ...inside) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  made.append(...inside);
  return made;
}

/** The element of an id, which the page has.
 * @param {string} id @returns {any} of the kind that its user knows */
export const by = (id) => document.getElementById(id);

/** Saves a text as a file.
 * @param {string} name @param {string} text */
export function save(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

/** A figure of three places, with a prefix of thousands.
 * @param {number} value */
export function short(value) {
  if (!Number.isFinite(value)) return "–";
  const steps = [[1e12, "T"], [1e9, "G"], [1e6, "M"], [1e3, "k"]];
  const [by, unit] = /** @type {[number, string]} */ (steps.find(([size]) => Math.abs(value) >= Number(size)) ?? [1,
    ""]);
  return `${Number((value / by).toPrecision(3))}${unit ? ` ${unit}` : ""}`;
}
