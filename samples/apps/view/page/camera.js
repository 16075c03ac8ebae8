// A camera that moves around its target. Positions are voxels of the file, or a scene's world units; rotations are in
// physical lengths.
/** @typedef {import("./protocol.js").Vector} Vector */

/** @param {string} text @returns {Vector} */
export const vector = (text) => /** @type {Vector} */ (text.split(",").map(Number));
/** @param {(i: number) => number} f @returns {Vector} */
const each = (f) => [f(0), f(1), f(2)];
/** @param {Vector} a @param {Vector} b @param {number} [t] @returns {Vector} */
const plus = (a, b, t = 1) => each((i) => a[i] + t * b[i]);
/** @param {Vector} a @param {Vector} b */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {Vector} a @param {Vector} b @returns {Vector} */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {Vector} a @returns {Vector} */
const unit = (a) => each((i) => a[i] / (Math.hypot(...a) || 1));
/** Rotates around the unit vector `axis`.
 * @param {Vector} v @param {Vector} axis @param {number} angle */
const turned = (v, axis, angle) =>
  plus(plus(each((i) => v[i] * Math.cos(angle)), cross(axis, v), Math.sin(angle)), axis,
    dot(axis, v) * (1 - Math.cos(angle)));
/** @param {Vector} v */
const text = (v) => v.map((x) => Number(x.toFixed(4))).join(",");

export class Camera {
  /** @type {Vector} */ spacing = [1, 1, 1];

  /** @param {import("./view.js").ViewState} view */
  constructor(view) {
    this.view = view;
  }

  #pose() {
    const physical = (/** @type {string} */ name) => {
      const v = vector(this.view.get(name));
      return each((i) => v[i] * this.spacing[i]);
    };
    const target = physical("look-at");
    const offset = plus(physical("eye"), target, -1);
    const up = unit(vector(this.view.get("up")));
    const right = unit(cross(unit(offset), up).map((x) => -x).some(Math.abs) ? cross(up, offset) : [1, 0, 0]);
    return { target, offset, up, right };
  }

  /** @param {Vector} target @param {Vector} offset @param {import("./protocol.js").Settings} [more] */
  #put(target, offset, more = {}) {
    const back = (/** @type {Vector} */ p) => text(each((i) => p[i] / this.spacing[i]));
    this.view.set({ eye: back(plus(target, offset)), "look-at": back(target), ...more }, true);
  }

  /** Rotates by angles in radians; the camera does not reach the poles.
   * @param {number} across @param {number} over */
  orbit(across, over) {
    const { target, offset, up, right } = this.#pose();
    const height = Math.asin(Math.max(-1, Math.min(1, dot(unit(offset), up))));
    const limit = 1.55, tilt = Math.max(-limit, Math.min(limit, height + over)) - height;
    this.#put(target, turned(turned(offset, right, -tilt), up, across));
  }

  /** Moves by shares of the picture's height.
   * @param {number} across @param {number} over */
  pan(across, over) {
    const { target, offset, right } = this.#pose();
    const height = this.view.get("orthographic")
      ? Number(this.view.get("orthographic")) * this.spacing[2]
      : 2 * Math.hypot(...offset) * Math.tan((Number(this.view.get("fov") || 30) * Math.PI) / 360);
    const upward = unit(cross(offset, right));
    this.#put(plus(plus(target, right, -across * height), upward, over * height), offset);
  }

  /** The axes' directions in the picture: to the right, upwards, and towards the viewer. Physical unit vectors. */
  axes() {
    const { offset, right } = this.#pose();
    const towards = unit(offset), upward = unit(cross(offset, right)), across = unit(right);
    return [0, 1, 2].map((i) => ({ x: across[i], y: upward[i], near: towards[i] }));
  }

  /** A voxel's position in the picture, as shares of width and height from the upper left; null behind the eye.
   * @param {Vector} point @param {number} ratio width over height */
  project(point, ratio) {
    const { target, offset, right } = this.#pose();
    const towards = unit(offset), upward = unit(cross(offset, right)), across = unit(right);
    const away = plus(each((i) => point[i] * this.spacing[i]), target, -1);
    const depth = Math.hypot(...offset) - dot(away, towards);
    const parallel = Number(this.view.get("orthographic"));
    const height = parallel ? parallel * Math.min(...this.spacing)
      : 2 * depth * Math.tan((Number(this.view.get("fov") || 30) * Math.PI) / 360);
    if (height <= 0) return null;
    return { x: 0.5 + dot(away, across) / (height * ratio), y: 0.5 - dot(away, upward) / height };
  }

  /** A factor above 1 moves nearer.
   * @param {number} factor */
  zoom(factor) {
    const { target, offset } = this.#pose();
    const height = Number(this.view.get("orthographic"));
    if (height) this.#put(target, offset, { orthographic: String(height / factor) });
    else this.#put(target, each((i) => offset[i] / factor));
  }

  reset() {
    this.view.set({ eye: "", "look-at": "", up: "", fov: "", orthographic: "" });
  }
}
