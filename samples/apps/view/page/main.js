// Connects the parts of the page.
/** @typedef {import("./protocol.js").Hello} Hello */
/** @typedef {import("./protocol.js").Failure} Failure */
/** @typedef {import("./protocol.js").PictureHeader} PictureHeader */
import { Camera } from "./camera.js";
import { Compare, kFirstId } from "./compare.js";
import { by, element } from "./dom.js";
import { Editor } from "./editor.js";
import { Fields } from "./fields.js";
import { Files } from "./files.js";
import { Machine } from "./machine.js";
import { draw_marks } from "./marks.js";
import { Picture, steer } from "./picture.js";
import { address } from "./protocol.js";
import { Slices } from "./slices.js";
import { Connection } from "./socket.js";
import { ViewState } from "./view.js";

const connection = new Connection();
const view = new ViewState();
const camera = new Camera(view);
const picture = new Picture(by("picture"), connection, view);
const fields = new Fields(view);
const editor = new Editor(view);
const slices = new Slices(by("slices"), connection);
const machine = new Machine(connection);
const compare = new Compare(connection, view);
const files = new Files(connection, notice);
steer(by("picture"), camera);

/** A line above the page, with buttons. A key has one line at a time; an empty text removes it.
 * @param {string} key @param {string} text @param {...[string, () => void]} ways */
function notice(key, text, ...ways) {
  const before = document.querySelector(`[data-notice="${key}"]`);
  if (text && before?.firstChild?.textContent === text) return; // the user may be about to press its buttons
  before?.remove();
  if (!text) return;
  const line = element("p", { "data-notice": key }, element("span", {}, text));
  for (const [label, go] of [...ways, /** @type {[string, () => void]} */ (["Dismiss", () => {}])]) {
    const button = element("button", { type: "button" }, label);
    button.addEventListener("click", () => {
      line.remove();
      go();
    });
    line.append(button);
  }
  by("notices").append(line);
}

/** @type {import("./protocol.js").Volume | null} */
let volume = null;
const mark = () => draw_marks(camera, volume, volume && !volume.world ? slices.point : null);
slices.addEventListener("point", mark);
by("projection").addEventListener("change", () => by("projection").value && is_open() && picture.ask(false));
new ResizeObserver(mark).observe(by("frame"));

const is_open = () => view.chosen.input !== undefined;

view.addEventListener("change", (event) => {
  const { what, moving } = /** @type {CustomEvent} */ (event).detail;
  if (!moving) fields.load();
  if (what === "other") editor.load();
  mark();
  if (is_open()) picture.ask(moving);
});

let is_first = true;
connection.on("hello", (/** @type {Hello} */ hello) => {
  const { input } = hello.settings;
  // Another page, or a dropped file, has opened another input: this page follows.
  if (is_first ? view.own.input && !hello.inputs.includes(view.own.input) : input !== view.chosen.input &&
    input !== view.own.input)
    view.own = view.kept();
  is_first = false;
  view.chosen = hello.volume ? hello.settings : {};
  camera.spacing = hello.volume && !hello.volume.world ? hello.volume.spacing : [1, 1, 1];
  by("empty").hidden = hello.volume !== null;
  by("board").textContent = hello.board?.uri ?? "no board";
  files.open(hello, view);
  fields.open(hello);
  editor.open(hello);
  compare.open(hello);
  volume = hello.volume;
  if (!hello.volume) return;
  slices.open(hello.volume);
  connection.send({ do: "histogram" });
  picture.ask(false);
});
connection.on("histogram", (histogram) => editor.histogram(histogram));
connection.on("open", () => {
  notice("connection", "");
  is_first = true;
  machine.listen();
});
connection.on("close", (/** @type {number} */ code) => {
  picture.forget();
  by("progress").hidden = true;
  const why = code === 1008 ? "gicube-view refused a message of this page."
    : "The connection to gicube-view has ended.";
  notice("connection", `${why} Is the program still running? It prints a new address at each start.`,
    ["Connect again", () => connection.open()]);
});
connection.on("board", ({ state, text }) => {
  if (state === "ready") return notice("board", "");
  picture.forget();
  by("progress").hidden = true;
  notice("board", `The board was lost: ${text}`, ["Start a new board", () => connection.send({ do: "board" })]);
});
connection.on("error", (/** @type {Failure} */ { id, field, text }) => {
  by("progress").hidden = true;
  if ((id ?? 0) > kFirstId || fields.blame(field, text)) return;
  const own = Object.keys(view.own).some((name) => name !== "input");
  if (id && own) notice("error", text, ["Leave out my settings", () => view.keep(["input"])]);
  else notice(id ? "error" : "file", text);
});
connection.on("progress", ({ text, done, all }) => {
  by("progress").hidden = false;
  /** @type {HTMLProgressElement} */ (document.getElementById("progress")).value = done / (all || 1);
  by("status").textContent = `${text}: ${done} of ${all}`;
});

let told = ""; // of the last picture
connection.on("projection", () => {
  by("progress").hidden = true;
  by("status").textContent = told;
});
picture.addEventListener("asked", () => {
  by("status").textContent ||= "asked for";
});
picture.addEventListener("shown", (event) => {
  const header = /** @type {PictureHeader} */ (/** @type {CustomEvent} */ (event).detail);
  fields.blame();
  mark();
  notice("error", header.invisible ?? "");
  by("progress").hidden = true;
  const time = header.frame_ms === null ? ""
    : ` · ${header.frame_ms.toPrecision(4)} ms simulated, ` +
      `${(1000 / header.frame_ms).toPrecision(3)} pictures a second on the card`;
  const what = header.final ? "whole picture" : "coarse picture";
  by("status").textContent = told =
    `${what} ${header.width} × ${header.height} · ${header.level}${time} · ${Math.ceil(header.host_ms)} ms here`;
  if (!header.final) return;
  by("command").textContent = header.command ?? "";
  by("python").textContent = header.python ??
    "Only gicube-render makes this one: its options of light have no Python call.";
  by("copy-python").disabled = !header.python;
  for (const what of ["png", "exr", "stats", "tf"]) by(`get-${what}`).setAttribute("href",
    address("download", { what, number: String(header.number) }));
});

/** @param {string} button @param {() => string} text */
function copies(button, text) {
  by(button).addEventListener("click", async () => {
    const label = by(button).textContent;
    try {
      await navigator.clipboard.writeText(text());
      by(button).textContent = "Copied";
    } catch {
      by("same").setAttribute("open", "");
      notice("copy", "This browser keeps pages from the clipboard: the text is below the picture.");
    }
    setTimeout(() => (by(button).textContent = label), 1500);
  });
}
copies("copy-command", () => by("command").textContent ?? "");
copies("copy-python", () => by("python").textContent ?? "");
copies("copy-address", () => view.address());

connection.open();
