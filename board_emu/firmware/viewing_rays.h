// Generation of viewing rays by the DSP: rays of an image, clipped to the volume's box and the cut planes [P §2.1,
// §3.5].
//
// Double precision in, ray words out. Only IEEE operations are used, so all machines get the same bits.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "levels/dsp_task.h"
#include "words/words.h"

namespace gicube::emu {

// The DSP generates them by scan conversion of the volume's faces [P §2.1]: it adds increments from pixel to pixel, in
// words of 32 bits. The values are those of clip() below.
//
// One ray: the direction, the two numerators of the position on the face and their denominator are incremented (6
// additions); four edges of the face are compared. The reciprocal of the denominator is from a table, with one Newton
// step (normalisation 4, 1 access, 2 products of 32 by 16 bits, each 2 multiplications and 2 operations). Two products
// give the position, 4 operations keep it in the face. The direction's length takes 3 squares and 2 sums; the
// reciprocal root is from a table with one step (4 operations, 1 access, 5 multiplications, 3 operations); then 3
// products with their roundings. 12 operations assemble the packet, 8 accesses send it.
inline constexpr DspLoop kMakeViewingRay{"viewing ray", 4 + 4 + 3 + 5 + 3, 6 + 4 + 4 + 4 + 4 + 4 + 2 + 4 + 3 + 3 + 12,
                                         1 + 1 + 8};
// A row of a face: the crossings of its edges, and the increments along it: 3 reciprocals, 15 products; load and store
// of the state.
inline constexpr DspLoop kBeginRow{"row of an image", 3 * 4 + 15 * 2, 3 * 8 + 15 * 3 + 20, 24};
// A cut plane, per ray: its own numerators and denominator are incremented; a reciprocal and a product; the later
// position is used.
inline constexpr DspLoop kCutRay{"cut plane", 4 + 2, 2 + 8 + 2 + 6, 1};

// A position in voxels and a direction of any length but 0.
struct Line {
  std::array<double, 3> origin{};
  std::array<double, 3> direction{};
};

// The line through image point (x, y), in pixels.
Line viewing_line(const wire::RenderCommand& command, double x, double y);

// The part of a line, t >= 0, within [0, extent] and all kept half spaces; nothing if it is empty. `extent` and the
// planes are in the pipeline's words.
struct Interval {
  double begin = 0;
  double end = 0;
};
std::optional<Interval> clip(const Line& line, const Point& extent, std::span<const Plane> planes);

// The entry of a line, before rounding to a ray's words.
struct Entry {
  std::array<double, 3> position{};   // voxels
  std::array<double, 3> direction{};  // unit length
  int face = -1;                      // index of the box face or plane where it enters; -1: it begins inside
};
std::optional<Entry> entry(const Line& line, const Point& extent, std::span<const Plane> planes);

// The rendering ray that starts where `line` enters, for pixel (u, v) in 12.4. Returns nothing if it misses, or if the
// length of its direction is zero or overflows: vectors of the host may cancel out or overflow at a pixel.
std::optional<wire::Ray> viewing_ray(const Line& line, std::uint16_t u, std::uint16_t v, const Point& extent,
                                     std::span<const Plane> planes);

// Moves a host ray's start to its entry. Returns false, and leaves the ray unchanged, if it misses.
bool enter(wire::Ray& ray, const Point& extent, std::span<const Plane> planes);

}  // namespace gicube::emu
