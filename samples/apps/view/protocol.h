// Messages between the page and gicube-view.
//
// HTTP, one address: http://127.0.0.1:PORT/?token=T, or https: with a certificate. Host and Origin are checked on every
// request, the token on all but the page's own modules. The page's address may carry the state of a view after a #,
// which the program never sees.
//   GET  /?token=T
//       index.html
//   GET  /NAME
//       the other files of samples/apps/view/page
//   POST /file?token=T&name=NAME
//       keeps the body as NAME for {"do":"open"}, and the open file of that name until then; NAME has no slash and no
//       leading dot. 204; 413 too large; 507 a full disk
//   GET  /download?token=T&number=N&what=png|exr|stats|tf
//       a whole picture, its statistics (JSON), the points of its transfer function; 404: it is not among the last few
//   GET  /socket?token=T
//       WebSocket
// Other answers are 400 (no such method or form), 403 (token, Host, Origin), 404, 413, 503 (too many connections), 507,
// with one line of text.
//
// Settings are options of gicube-render without their dashes, text to text, as gicube-sweep names them:
// {"eye":"1,2,3", "step":"0.5"}. A flag is "on" or "off". `cut` may have several planes, separated by ;. A name with a
// dot is a field of the board's configuration ("asic.processors":"8"). `input` is one of hello's inputs, and the open
// one from then on. `transfer-function` is a preset, one of hello's transfer functions, or the whole text of a .tf file
// (it has line ends). Omitted settings are as in hello. Settings that only a command line may have (output, board,
// config, ...) are refused. A world's units are those of the scene, otherwise voxels, as everywhere in gicube-render.
//
// From the page, JSON text:
//   {"do":"picture","id":N,"moving":BOOL,"projection"?:"max"|"mean","settings":{...}}
//       id grows. A newer one replaces one that waits, and stops one that is being made. moving: one coarse picture
//       only, made for the frame budget. Otherwise a coarse one at once if the whole one takes longer than that, then
//       the whole one ("final"), and with `projection` the greatest or the mean value along each pixel's ray
//   {"do":"slice","id":N,"axis":"x"|"y"|"z","at":K}
//       voxel K of the axis, of hello's dims
//   {"do":"histogram"}
//       of the input
//   {"do":"open","names":[...]}
//       opens posted files: one file, or slices, or a header with its data; it becomes the input. An "error" if it
//       can't be read, or if another "open" comes meanwhile: the input stays
//   {"do":"machine","on":BOOL}
//       ten "machine" messages per second while on
//   {"do":"compare","id":N,"settings":{...},"other":{...}}
//       the same frame on two new boards of these settings; the page's next picture stops it
//   {"do":"board"}
//       a new board after one was lost
// Any other message ends the connection (WebSocket close 1008).
//
// From the program, JSON text:
//   {"type":"hello","inputs":[NAME...],"transfer_functions":[NAME...],"presets":[{"name","text"}...],"settings":{...},
//    "volume":{"name","dims":[x,y,z],"spacing":[x,y,z],"range":[low,high],"world":BOOL,"own_look":BOOL,
//              "look":TEXT,"look_why":TEXT,"window":[low,high],"unit":TEXT,"whole":BOOL,"marks":[6 TEXTS],
//              "patient":BOOL,"labels"?:[{"value","colour":[r,g,b]}...]},
//    "box":{"low":[x,y,z],"high":[x,y,z]},"limits":{"file_bytes","message_bytes","size":4095},
//    "board":{"uri","level","processors"}}
//       at the start, and again to every page once another input is open; with "volume":null while nothing is open.
//       own_look: without a transfer function the input has its own; otherwise look is the .tf text of the automatic
//       one, and look_why its reason. window: of values, for slices at first; unit: of the values, HU or nothing;
//       whole: they are whole numbers; marks: of the low and the high ends of x, y and z, of a patient R L A P I S.
//       labels: of a label map, whose slices have their indices. presets' texts are in the volume's values where these
//       are known. The settings name eye, look-at, up, fov, size, step and threshold, and switches that are on
//   {"type":"histogram","low","high","counts":[256 numbers]}
//       over the volume's range
//   {"type":"machine","simulated_ms","running":BOOL,"counters":{NAME:VALUE...},"units":{NAME:UNIT...},"look"?:{...}}
//       all counters of the board since its start (docs/reference/counters.md), where they have changed; the page
//       computes shares and rates. units come once. Within a frame only for a board of this user on this machine at the
//       cycle level, which also has a look: MachineLook of management.proto, as {"blocks_a_side","cells":[x,y,z],
//       "waiting":[...],"processors":[...],"banks","memories":[[packets...]...]}
//   {"type":"compared","id","frames":[{"frame_ms","settings":{...},"counters":{...}} x 2],"same":BOOL}
//       same: the pictures are equal
//   {"type":"progress","text","done","all"}
//       of a long step: reading, loading, lighting
//   {"type":"board","state":"lost"|"ready","text"}
//       lost: {"do":"board"} starts another, and the page should ask for the picture again
//   {"type":"error","id"?,"field"?,"text"}
//       field: the faulty setting, without dashes, if there is one
// Binary: the header's length, 4 bytes little endian; the header, JSON; the bytes.
//   {"type":"picture","id","width","height","final":BOOL,"frame_ms","level","host_ms","invisible"?,"number","command",
//    "python"}
//       + RGBA, 8 bits, as in gicube-render -o picture.png. frame_ms is null if the level models no time. invisible:
//       why nothing is visible. A coarse picture has fewer pixels than requested, and no number, command and python.
//       There is no python if its package has no call for the settings.
//   {"type":"slice","id","axis","at","width","height"}
//       + 16 bits, little endian: 0..4095 over the volume's range, or indices of labels; rows from the lowest y (of z:
//       y down, x across; of y: z down, x across; of x: z down, y across)
//   {"type":"projection","id","width","height"}
//       + such words, from the upper left as the picture, of at most 512 pixels a side; never of a world or a label map
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace gicube::samples::view {

constexpr std::size_t kMaxConnections = 32;  // chosen: a few pages, each with a socket and its modules
constexpr std::uint64_t kMaxFileBytes = std::uint64_t{2}
                                        << 30;        // chosen: of all posted files together, those that come included
constexpr std::size_t kMaxMessageBytes = 256 * 1024;  // chosen: 4096 points of a transfer function fit
constexpr std::size_t kMaxMade = 8;      // chosen: whole pictures that can be downloaded: a few pages' last ones
constexpr std::size_t kMaxWaiting = 64;  // chosen: messages of one page that wait to be carried out
constexpr std::chrono::seconds kRequestTime{
    10};  // chosen: for a request of one without the token, any header, and each part of a body
constexpr std::chrono::milliseconds kFrameBudget{
    50};  // chosen: of a picture while something moves; 15 a second with room

}  // namespace gicube::samples::view
