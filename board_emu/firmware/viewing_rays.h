// The DSP's ray making: viewing rays of an image, clipped with the volume's box and the cut planes [P §2.1, §3.5].
//
// Double precision in, ray words out; IEEE operations only, so every machine makes the same bits.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "levels/dsp_task.h"
#include "words/words.h"

namespace gicube::emu {

// The DSP makes them by scan conversion of the volume's faces [P §2.1]: from pixel to pixel it adds increments, in words of 32 bits.
// The values are those of the clip below.
//
// A ray: direction, the two numerators of the place on the face and their denominator are moved on (6 additions); four edges
// of the face are compared. The denominator's reciprocal is a table's, with one step of Newton's (normalisation 4, 1 access,
// 2 products of 32 by 16 bits, each 2 multiplications and 2 operations); two products make the place, 4 operations keep it
// in the face. The direction's length: 3 squares, 2 sums; reciprocal root by table and one step (4 operations, 1 access, 5
// multiplications, 3 operations); 3 products with their roundings. 12 operations put the packet together, 8 accesses send it.
inline constexpr DspLoop kMakeViewingRay{"viewing ray", 4 + 4 + 3 + 5 + 3, 6 + 4 + 4 + 4 + 4 + 4 + 2 + 4 + 3 + 3 + 12,
                                         1 + 1 + 8};
// A row of a face: its edges' crossings, and the increments along it: 3 reciprocals, 15 products; state in and out.
inline constexpr DspLoop kBeginRow{"row of an image", 3 * 4 + 15 * 2, 3 * 8 + 15 * 3 + 20, 24};
// A cut plane, for each ray: its own numerators and denominator go on; a reciprocal and a product, and the later place is taken.
inline constexpr DspLoop kCutRay{"cut plane", 4 + 2, 2 + 8 + 2 + 6, 1};

// A position in voxels and a direction of any length but 0.
struct Line {
  std::array<double, 3> origin{};
  std::array<double, 3> direction{};
};

// The line through image point (x, y), pixels.
Line viewing_line(const wire::RenderCommand& command, double x, double y);

// The part of a line, t >= 0, that lies in [0, extent] and in every kept half space; nothing if there is none.
// `extent` and the planes are in the pipeline's words.
struct Interval {
  double begin = 0;
  double end = 0;
};
std::optional<Interval> clip(const Line& line, const Point& extent, std::span<const Plane> planes);

// Where a line enters, before it is rounded to a ray's words.
struct Entry {
  std::array<double, 3> position{};   // voxels
  std::array<double, 3> direction{};  // unit length
  int face = -1;                      // which of the box's faces and the planes it comes in by; -1: it begins inside
};
std::optional<Entry> entry(const Line& line, const Point& extent, std::span<const Plane> planes);

// The rendering ray that starts where `line` enters, with destination (u, v) in 12.4 pixels; nothing if it misses, or if
// its direction has no length that a double can hold: a host's vectors can cancel out or run over in a pixel.
std::optional<wire::Ray> viewing_ray(const Line& line, std::uint16_t u, std::uint16_t v, const Point& extent,
                                     std::span<const Plane> planes);

// Moves a host ray's start to where it enters; false if it misses, and then the ray is as it was.
bool enter(wire::Ray& ray, const Point& extent, std::span<const Plane> planes);

}  // namespace gicube::emu
