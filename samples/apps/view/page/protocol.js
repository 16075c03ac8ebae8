// Messages between page and program (samples/apps/view/protocol.h), as types.

/** @typedef {Record<string, string>} Settings options of gicube-render without their dashes */
/** @typedef {[number, number, number]} Vector */
/** @typedef {{name: string, dims: Vector, spacing: Vector, range: [number, number], world: boolean, own_look: boolean,
 *   look: string, look_why: string, window: [number, number], unit: string, whole: boolean, marks: string[], patient:
 * boolean,
 *   labels?: {value: number, colour: Vector}[]}} Volume */
/** @typedef {{type: "hello", inputs: string[], transfer_functions: string[], presets: {name: string, text: string}[],
 *   settings: Settings, volume: Volume | null, box: {low: Vector, high: Vector} | null,
 *   limits: {file_bytes: number, message_bytes: number, size: number},
 *   board: {uri: string, level: string, processors: number} | null}} Hello */
/** @typedef {Record<string, number>} Counters */
/** @typedef {{type: "machine", simulated_ms: number, running: boolean, counters: Counters, units?: Record<string,
 * string>, look?: Look}} Machine */
/** @typedef {{blocks_a_side: number, cells: Vector, waiting: number[], processors: number[], banks: number, memories:
 * number[][]}} Look */
/** @typedef {{frame_ms: number | null, settings: Settings, counters: Counters}} ComparedFrame */
/** @typedef {{type: "picture", id: number, width: number, height: number, final: boolean, frame_ms: number | null,
 * level: string,
 *   host_ms: number, invisible?: string, number?: number, command?: string, python?: string}} PictureHeader */
/** @typedef {{type: "slice", id: number, axis: "x" | "y" | "z", at: number, width: number, height: number}}
 * SliceHeader */
/** @typedef {{type: "error", id?: number, field?: string, text: string}} Failure */
/** @typedef {{type: "histogram", low: number, high: number, counts: number[]}} Histogram */

export const token = new URLSearchParams(location.search).get("token") ?? "";

/** The address of a part of the program.
 * @param {string} path @param {Record<string, string>} [query] */
export const address = (path, query = {}) => `${path}?${new URLSearchParams({ token, ...query })}`;
