// The DSP's ray making: viewing rays of an image, clipped with the volume's box and the cut planes [P §2.1, §3.5].
//
// Double precision in, ray words out; IEEE operations only, so every machine makes the same bits.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

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

// The rendering ray that starts where `line` enters, with destination (u, v) in 12.4 pixels; nothing if it misses, or if
// its direction has no length that a double can hold: a host's vectors can cancel out or run over in a pixel.
std::optional<wire::Ray> viewing_ray(const Line& line, std::uint16_t u, std::uint16_t v, const Point& extent,
                                     std::span<const Plane> planes);

// Moves a host ray's start to where it enters; false if it misses, and then the ray is as it was.
bool enter(wire::Ray& ray, const Point& extent, std::span<const Plane> planes);

}  // namespace gicube::emu
