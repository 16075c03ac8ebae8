// The state of a view: the settings that differ from the program's. The address has them after #.
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

  /** Removes all but these.
   * @param {string[]} names */
  keep(names) {
    for (const name of Object.keys(this.own)) if (!names.includes(name)) delete this.own[name];
    this.#tell("other", false);
  }

  /** The settings that are kept for another input: a look by its name, and others that are not specific to this
   * input. */
  kept() {
    const names = ["transfer-function", "background", "size", "samples", "step", "threshold", "no-shade", "fidelity"];
    return Object.fromEntries(Object.entries(this.own).filter(([name, value]) => names.includes(name) &&
      !value.includes("\n")));
  }

  /** The address of this page with the current view. */
  address() {
    const text = new URLSearchParams(this.own).toString();
    return location.origin + location.pathname + location.search + (text && `#${text}`);
  }

  /** @param {string} what @param {boolean} moving */
  #tell(what, moving) {
    // Browsers limit the rate of changes of the address.
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => history.replaceState(null, "", this.address()), 300);
    this.dispatchEvent(new CustomEvent("change", { detail: { what, moving } }));
  }
}
