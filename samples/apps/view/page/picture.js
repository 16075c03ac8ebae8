// The picture: input moves the camera, new requests do not wait for old ones, and pictures are shown when they arrive.
/** @typedef {import("./protocol.js").Failure} Failure */
import { by } from "./dom.js";

const kRest = 180; // milliseconds without a move after which the whole picture is requested
const kForgotten = 3000; // milliseconds after which an unanswered request no longer delays the next

export class Picture extends EventTarget {
  #id = 0;
  #flying = 0; // id of the requested moving picture
  #since = 0;
  #wanted = false;
  #rest = 0; // of the timer that asks for the whole picture after a move; 0: none waits

  /** @param {HTMLCanvasElement} canvas @param {import("./socket.js").Connection} connection @param
   * {import("./view.js").ViewState} view */
  constructor(canvas, connection, view) {
    super();
    this.canvas = canvas;
    this.connection = connection;
    this.view = view;
    connection.on("picture", ({ header, bytes }) => this.#show(header, bytes));
    connection.on("error", (/** @type {Failure} */ error) => {
      this.#arrived(error.id ?? 0);
      if (error.id === this.#id) this.#settle();
    });
  }

  /** Requests the picture of the current view.
   * @param {boolean} moving */
  ask(moving) {
    this.canvas.setAttribute("aria-busy", "true");
    this.#stop();
    if (moving) {
      this.#rest = setTimeout(() => this.ask(false), kRest);
      if (this.#flying && performance.now() - this.#since < kForgotten) {
        this.#wanted = true; // one is requested, and the newest follows
        return;
      }
      this.#since = performance.now();
    }
    this.#wanted = false;
    this.#id += 1;
    this.#flying = moving ? this.#id : 0;
    const projection = by("projection").value || undefined;
    this.connection.send({ do: "picture", id: this.#id, moving, projection, settings: this.view.own });
    this.dispatchEvent(new CustomEvent("asked"));
  }

  /** Forgets all requests, because the board was lost. */
  forget() {
    this.#stop();
    this.#flying = 0;
    this.#wanted = false;
    this.#settle();
  }

  #stop() {
    clearTimeout(this.#rest);
    this.#rest = 0;
  }

  /** Called when the newest request is answered: the picture is complete unless another follows a move. */
  #settle() {
    if (!this.#rest) this.canvas.setAttribute("aria-busy", "false");
  }

  /** @param {number} id */
  #arrived(id) {
    if (id !== this.#flying) return;
    this.#flying = 0;
    if (this.#wanted) this.ask(true);
  }

  /** @param {import("./protocol.js").PictureHeader} header @param {Uint8Array} bytes */
  #show(header, bytes) {
    this.#arrived(header.id);
    const { canvas } = this;
    canvas.width = header.width;
    canvas.height = header.height;
    const [width, height] = this.view.get("size").split("x").map(Number);
    const ratio = (width || header.width) / (height || header.height);
    canvas.style.width = `min(100%, ${width || header.width}px, calc(${ratio} * (100vh - 190px)))`;
    canvas.style.aspectRatio = String(ratio);
    const pixels = new ImageData(new Uint8ClampedArray(bytes), header.width, header.height);
    canvas.getContext("2d")?.putImageData(pixels, 0, 0);
    canvas.dataset.id = String(header.id);
    canvas.dataset.final = String(header.final && header.id === this.#id);
    if (canvas.dataset.final === "true") this.#settle();
    this.dispatchEvent(new CustomEvent("shown", { detail: header }));
  }
}

/** Mouse, touch and keys on the picture move the camera.
 * @param {HTMLCanvasElement} canvas @param {import("./camera.js").Camera} camera */
export function steer(canvas, camera) {
  /** @type {Map<number, {x: number, y: number}>} */
  const fingers = new Map();
  const size = () => canvas.getBoundingClientRect().height || 1;
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(a.x - b.x, a.y - b.y) || 1 };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  for (const end of ["pointerup", "pointercancel"])
    canvas.addEventListener(end, (event) => fingers.delete(/** @type {PointerEvent} */ (event).pointerId));
  canvas.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const before = fingers.size === 2 ? spread() : null;
    const [dx, dy] = [(event.clientX - last.x) / size(), (event.clientY - last.y) / size()];
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (before) {
      const now = spread();
      camera.pan((now.x - before.x) / size(), (now.y - before.y) / size());
      camera.zoom(now.apart / before.apart);
    } else if (event.shiftKey || event.buttons & 6) camera.pan(dx, dy);
    else camera.orbit(-dx * 3, dy * 3);
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", () => camera.reset());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.zoom(Math.exp(-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 100) * 0.0015));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (arrow) {
      const [x, y] = arrow;
      if (event.shiftKey) camera.pan(-x * 0.03, -y * 0.03);
      else camera.orbit(x * 0.1, -y * 0.1);
    } else if (event.key === "+" || event.key === "=") camera.zoom(1.1);
    else if (event.key === "-") camera.zoom(1 / 1.1);
    else if (event.key === "Home" || event.key === "0") camera.reset();
    else return;
    event.preventDefault();
  });
}
