// The WebSocket to the program: JSON both ways, pictures and slices with a header.
import { address } from "./protocol.js";

/** Messages come out as events: `detail` is the message, and for pictures and slices {header, bytes}. */
export class Connection extends EventTarget {
  /** @type {WebSocket | null} */
  #socket = null;

  open() {
    const url = new URL(address("socket"), location.href);
    url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(url);
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.#tell("open", null);
    socket.onclose = (event) => this.#tell("close", event.code);
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") {
        const message = JSON.parse(data);
        this.#tell(message.type, message);
      } else {
        const length = new DataView(data).getUint32(0, true);
        const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
        this.#tell(header.type, { header, bytes: new Uint8Array(data, 4 + length) });
      }
    };
  }

  /** @param {Record<string, unknown>} message */
  send(message) {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(message));
  }

  /** @param {string} type @param {(detail: any) => void} listener */
  on(type, listener) {
    this.addEventListener(type, (event) => listener(/** @type {CustomEvent} */ (event).detail));
  }

  /** @param {string} type @param {unknown} detail */
  #tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}
