// Advancing a ray: fixed-point steps, the end of a ray, and skipping empty blocks [P §2.1] [H801, H802].
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "datapath/fixed.h"
#include "words/words.h"

namespace gicube::emu {

// A position or step of the wide datapath: 30 fraction bits, which hold a direction times a length exactly. Nothing is
// rounded, so a ray's position is exactly its start plus a number of steps.
using FinePoint = std::array<std::int64_t, 3>;
inline constexpr int kRestBits = 16;  // beyond the fraction bits of a Point
// The additional fraction bits. A path segment starts at one half of a unit, so that units_of() rounds to nearest.
using Rest = std::array<std::uint16_t, 3>;
inline constexpr std::uint16_t kHalfUnit = 1u << (kRestBits - 1);
inline constexpr Rest kHalfUnits{kHalfUnit, kHalfUnit, kHalfUnit};

constexpr FinePoint fine(const Point& units, const Rest& rest) {
  FinePoint out{};
  for (std::size_t axis = 0; axis < 3; ++axis) out[axis] = std::int64_t{units[axis]} * (1 << kRestBits) + rest[axis];
  return out;
}
constexpr Point units_of(const FinePoint& fine) {
  Point out{};
  for (std::size_t axis = 0; axis < 3; ++axis) out[axis] = static_cast<std::int32_t>(fine[axis] >> kRestBits);
  return out;
}
constexpr Rest rest_of(const FinePoint& fine) {
  Rest out{};
  for (std::size_t axis = 0; axis < 3; ++axis) out[axis] = static_cast<std::uint16_t>(fine[axis]);
  return out;
}
constexpr FinePoint moved(const FinePoint& position, const FinePoint& step, std::int64_t steps) {
  return {position[0] + steps * step[0], position[1] + steps * step[1], position[2] + steps * step[2]};
}

// The vector of one step of `length` (16.16 voxels) along a ray's direction (1.14, unit length).
constexpr Point step_vector(const std::array<std::int16_t, 3>& direction, std::uint32_t length) {
  Point step{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    step[axis] = static_cast<std::int32_t>(round_shift<16>(std::int64_t{direction[axis]} * length));
  }
  return step;
}

// step_vector() for the wide datapath.
constexpr FinePoint fine_step_vector(const std::array<std::int16_t, 3>& direction, std::uint32_t length) {
  FinePoint step{};
  for (std::size_t axis = 0; axis < 3; ++axis) step[axis] = std::int64_t{direction[axis]} * length;
  return step;
}

constexpr bool inside(const Point& position, const Point& extent) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (position[axis] < 0 || position[axis] > extent[axis]) return false;
  }
  return true;
}

// The face (wire::kFaces) that a ray crossed first among those whose plane it is beyond; there must be one. `step`: the
// last step, or several; if it does not lead out along an axis, the ray was beyond that plane before.
constexpr std::size_t face_left_by(const Point& position, const FinePoint& step, const Point& extent) {
  std::size_t face = 0;
  std::int64_t beyond_face = 0, out_of_face = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool low = position[axis] < 0;
    const std::int64_t beyond = low ? -std::int64_t{position[axis]} : std::int64_t{position[axis]} - extent[axis];
    const std::int64_t out = std::max<std::int64_t>(low ? -step[axis] : step[axis], 0);
    if (beyond <= 0 || beyond * out_of_face <= beyond_face * out) continue;  // compares fractions of the step beyond
    face = 2 * axis + (low ? 0 : 1);
    beyond_face = beyond, out_of_face = out;
  }
  return face;
}

// Whether a ray has left a kept half space. Rays that enter it do not count: the DSP starts them on the plane, and
// rounding may put them slightly outside.
constexpr bool beyond(const Plane& plane, const Point& position, const Point& step) {
  return dot(plane.normal, step) < 0 && dot(plane.normal, position) < plane.offset;
}

// Whether a sample lies at a cut face: within a voxel of a plane through which its ray has entered. The gradient there
// is not that of a surface.
constexpr bool at_cut_face(const Plane& plane, const Point& position, const Point& step) {
  constexpr std::int64_t kDepth = std::int64_t{1} << kPlaneFractionBits;
  return dot(plane.normal, step) > 0 && dot(plane.normal, position) - plane.offset < kDepth;
}

// Height above a cut plane of a position of the wide datapath, which is half a unit too high; 44 fraction bits.
constexpr std::int64_t fine_height(const Plane& plane, const FinePoint& position) {
  constexpr std::int64_t kFarOff = std::int64_t{1} << 46;  // beyond any volume
  std::int64_t height = -std::clamp(plane.offset, -kFarOff, kFarOff) * (1 << kRestBits);
  for (std::size_t axis = 0; axis < 3; ++axis) height += plane.normal[axis] * (position[axis] - kHalfUnit);
  return height;
}
constexpr std::int64_t fine_slope(const Plane& plane, const FinePoint& step) {
  return plane.normal[0] * step[0] + plane.normal[1] * step[1] + plane.normal[2] * step[2];
}
constexpr bool fine_beyond(const Plane& plane, const FinePoint& position, const FinePoint& step) {
  return fine_slope(plane, step) < 0 && fine_height(plane, position) < 0;
}

// The least number of whole steps that take `position` out of the block [low, low + size) on some axis; at least 1.
// Whole steps keep the sample positions: without jitter, skipping never changes a bit. (The paper skips to the block's
// face, "but at least dr"; docs/reference/hardware.md.)
template <typename Word>
constexpr std::int32_t skip_steps(const std::array<Word, 3>& position, const std::array<Word, 3>& step,
                                  const std::array<Word, 3>& low, std::type_identity_t<Word> size) {
  Word least = size;  // a step that moves at all moves at least one unit
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Word s = step[axis];
    if (s > 0) {
      least = std::min<Word>(least, (low[axis] + size - position[axis] + s - 1) / s);
    } else if (s < 0) {
      least = std::min<Word>(least, (position[axis] - low[axis]) / -s + 1);
    }
  }
  return static_cast<std::int32_t>(least);
}

// The least number of whole steps, at most `most`, that take a position inside the volume out of it.
template <typename Word>
constexpr std::int32_t steps_inside(const std::array<Word, 3>& position, const std::array<Word, 3>& step,
                                    const std::array<Word, 3>& extent, std::int32_t most) {
  Word least = most;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Word s = step[axis];
    if (s > 0) least = std::min<Word>(least, (extent[axis] - position[axis]) / s + 1);
    if (s < 0) least = std::min<Word>(least, position[axis] / -s + 1);
  }
  return static_cast<std::int32_t>(least);
}
// The greatest position of the wide datapath inside the volume.
constexpr FinePoint fine_extent(const Point& extent) { return fine(extent, {0xFFFF, 0xFFFF, 0xFFFF}); }

}  // namespace gicube::emu
