// Advancing a ray: steps in the position's fixed point, the end of a ray, and leaps over empty blocks [P §2.1].
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "datapath/fixed.h"
#include "words/words.h"

namespace gicube::emu {

// The vector of one step of `length` (16.16 voxels) along a ray's direction (1.14, unit length).
constexpr Point step_vector(const std::array<std::int16_t, 3>& direction, std::uint32_t length) {
  Point step{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    step[axis] = static_cast<std::int32_t>(round_shift<16>(std::int64_t{direction[axis]} * length));
  }
  return step;
}

constexpr bool inside(const Point& position, const Point& extent) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (position[axis] < 0 || position[axis] > extent[axis]) return false;
  }
  return true;
}

// True once a ray that runs out of a kept half space has left it. A ray that runs into it was placed on the plane by the
// DSP and may stand a rounding short of it.
constexpr bool beyond(const Plane& plane, const Point& position, const Point& step) {
  return dot(plane.normal, step) < 0 && dot(plane.normal, position) < plane.offset;
}

// The least number of whole steps that take `position` out of the block [low, low + size) on some axis; at least 1.
// Whole steps keep the samples where they would have been: without jitter, leaping never changes a bit. (The paper leaps
// to the block's face, "but at least dr"; docs/reference/hardware.md.)
constexpr std::int32_t leap_steps(const Point& position, const Point& step, const Point& low, std::int32_t size) {
  std::int32_t least = size;  // a step that moves at all moves at least one unit
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t s = step[axis];
    if (s > 0) {
      least = std::min(least, (low[axis] + size - position[axis] + s - 1) / s);
    } else if (s < 0) {
      least = std::min(least, (position[axis] - low[axis]) / -s + 1);
    }
  }
  return least;
}

}  // namespace gicube::emu
