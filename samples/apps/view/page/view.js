// The state of a view: settings that differ from those the program chose. The address after # has the same.
/** @typedef {import("./protocol.js").Settings} Settings */

export class ViewState extends EventTarget {
  /** @type {Settings} */ chosen = {};
  /** @type {Settings} */ own = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
  #timer = 0;

  constructor() {
    super();
    addEventListener("hashchange", () => {
      this.own = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
      this.#tell("other", false);
    });
  }

  /** @param {string} name */
  get(name) {
    return this.own[name] ?? this.chosen[name] ?? "";
  }

  /** An empty value leaves the setting to the program.
   * @param {Settings} values @param {boolean} [moving] */
  set(values, moving = false) {
    for (const [name, value] of Object.entries(values)) {
      if (value === "" || value === this.chosen[name]) delete this.own[name];
      else this.own[name] = value;
    }
    this.#tell(Object.keys(values).join(), moving);
  }

  /** Only these are kept.
   * @param {string[]} names */
  keep(names) {
    for (const name of Object.keys(this.own)) if (!names.includes(name)) delete this.own[name];
    this.#tell("other", false);
  }

  /** What another input keeps: a look by its name, whose values are found anew, and what is no place or size of this
   * input. */
  kept() {
    const names = ["transfer-function", "background", "size", "samples", "step", "threshold", "no-shade", "fidelity"];
    return Object.fromEntries(Object.entries(this.own).filter(([name, value]) => names.includes(name) &&
      !value.includes("\n")));
  }

  /** Of this page, with the view as it is. */
  address() {
    const text = new URLSearchParams(this.own).toString();
    return location.origin + location.pathname + location.search + (text && `#${text}`);
  }

  /** @param {string} what @param {boolean} moving */
  #tell(what, moving) {
    // Browsers take few changes of an address a second.
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => history.replaceState(null, "", this.address()), 300);
    this.dispatchEvent(new CustomEvent("change", { detail: { what, moving } }));
  }
}
