// Rays that a host application makes itself and gets back.
#pragma once

#include <array>
#include <cstdint>

#include "gicube/vector.h"

namespace gicube {

// What the board can't hold exactly is rounded: positions to 1/16384 voxel, directions to 1/16384.
struct HostRay {
  std::uint32_t id = 0;  // the caller's own; comes back unchanged
  Vec3 position;         // voxels, inside the volume: 0..size - 1 on each axis
  Vec3 direction;        // any length but 0; only the direction counts
};

// A ray as it returned: integrated through the volume until it left, was opaque, or met a cut plane.
struct TracedRay {
  std::uint32_t id = 0;
  Vec3 position;                   // where it ended, clamped to the volume; voxels
  Vec3 direction;                  // unit length in voxels
  std::array<double, 3> colour{};  // premultiplied, 0..1
  double opacity = 0;              // 0..1

  friend constexpr bool operator==(const TracedRay&, const TracedRay&) = default;
};

}  // namespace gicube
