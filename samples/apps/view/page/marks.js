// Marks on the picture: the directions of the axes, and the point of the slices.
/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./protocol.js").Vector} Vector */
/** @typedef {import("./protocol.js").Volume} Volume */
import { by, shape } from "./dom.js";

const kArm = 26, kMiddle = 38; // pixels

/** @param {Camera} camera @param {Volume | null} volume @param {Vector | null} point */
export function draw_marks(camera, volume, point) {
  const svg = by("marks"), canvas = by("picture");
  svg.replaceChildren();
  if (!volume) return;
  const { clientWidth: width, clientHeight: height, offsetLeft: left, offsetTop: top } = canvas;
  Object.assign(svg.style, { left: `${left}px`, top: `${top}px`, width: `${width}px`, height: `${height}px` });
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const y0 = height - kMiddle;
  const ends = camera.axes().flatMap(({ x, y, near }, axis) => [-1,
    1].map((side) => ({ x: side * x, y: side * y, near: side * near, text: volume.marks[2 * axis + (side + 1) / 2],
    side })));
  for (const end of ends.sort((a, b) => a.near - b.near)) {
    if (!volume.patient && end.side < 0) continue;
    const faint = end.near < -0.3 ? { class: "far" } : {};
    svg.append(shape("line", { x1: kMiddle, y1: y0, x2: kMiddle + 0.75 * kArm * end.x, y2: y0 - 0.75 * kArm * end.y,
      ...faint }),
      shape("text", { x: kMiddle + kArm * end.x, y: y0 - kArm * end.y, ...faint }, end.text));
  }
  const at = point && camera.project(point, width / height);
  if (at) svg.append(shape("path", { class: "point", d: `M${at.x * width - 7},${at.y * height}h14m-7,-7v14` }));
}
