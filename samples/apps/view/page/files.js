// Files that are dropped on the page or chosen: posted one by one, then opened together.
import { by } from "./dom.js";
import { address } from "./protocol.js";

export class Files {
  #most = 0; // bytes
  #opened = ""; // a transfer function that this page has posted

  /** @param {import("./socket.js").Connection} connection @param {(key: string, text: string) => void} notice */
  constructor(connection, notice) {
    this.connection = connection;
    this.notice = notice;
    by("choose").addEventListener("click", () => by("files").click());
    by("files").addEventListener("change", () => {
      this.post([...(by("files").files ?? [])]);
      by("files").value = "";
    });
    let depth = 0; // of elements that were entered
    const show = (/** @type {number} */ change) => {
      depth = Math.max(0, depth + change);
      by("drop").hidden = depth === 0;
    };
    addEventListener("dragenter", () => show(1));
    addEventListener("dragleave", () => show(-1));
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      show(-depth);
      this.post([...(event.dataTransfer?.files ?? [])]);
    });
  }

  /** @param {import("./protocol.js").Hello} hello @param {import("./view.js").ViewState} view */
  open(hello, view) {
    this.#most = hello.limits.file_bytes;
    if (!hello.transfer_functions.includes(this.#opened)) return;
    view.own["transfer-function"] = this.#opened;
    this.#opened = "";
  }

  /** @param {File[]} files */
  async post(files) {
    if (files.length === 0) return;
    this.notice("file", "");
    const sum = files.reduce((bytes, file) => bytes + file.size, 0);
    try {
      if (sum > this.#most) throw new Error(`expected at most ${this.#most} bytes, got ${sum}`);
      for (const [number, file] of files.entries()) {
        by("status").textContent = `sending ${file.name}, ${number + 1} of ${files.length}`;
        const answer = await fetch(address("file", { name: file.name }), { method: "POST", body: file });
        if (!answer.ok) throw new Error((await answer.text()).trim());
      }
      if (files.length === 1 && files[0].name.endsWith(".tf")) this.#opened = files[0].name;
      this.connection.send({ do: "open", names: files.map((file) => file.name) });
      by("status").textContent = `opening ${files[0].name}`;
    } catch (error) {
      this.notice("file", `${files[0].name} was not taken: ${error instanceof Error ? error.message : error}`);
    }
  }
}
