// A small scene with visible and empty parts, in which rays of all processors meet, for tests of what observers write.
#pragma once

#include "bare_board.h"
#include "machine_rig.h"

namespace gicube::emu {

inline constexpr std::array<int, 3> kObservedSize{24, 20, 17};

inline wire::Voxel observed_voxel(int x, int y, int z) {
  const int dx = x - 12, dy = y - 10, dz = z - 8, inside = 49 - dx * dx - dy * dy - dz * dz;
  wire::Voxel voxel;
  if (inside > 0) voxel.density = static_cast<std::uint16_t>(1000 + inside * 20);
  return voxel;
}

inline wire::SegmentationEntry observed_material(unsigned density) {
  wire::SegmentationEntry entry;
  entry.opacity = static_cast<std::uint16_t>(density < 900 ? 0 : 4000);
  entry.colour = {static_cast<std::uint16_t>(density), 2000, 1000};
  entry.ambient = entry.reflect = entry.knee = 128;
  return entry;
}

// A machine in which every kind of part has something to do.
inline v1::BoardConfig observed_config(std::vector<std::string> more = {}) {
  std::vector<std::string> assignments{"asic.block_voxels=8", "asic.processors=3", "asic.queue_rays=16",
                                       "asic.partition=skewed_block", "asic.max_volume_voxels=32"};
  assignments.insert(assignments.end(), more.begin(), more.end());
  return config_with(assignments);
}

struct ObservedScene : Scene {
  ObservedScene() : Scene(kObservedSize, 8) {
    fill(observed_voxel);
    for (std::size_t i = 0; i < segmentation.size(); ++i) segmentation[i] = observed_material(i & 4095);
  }
};

}  // namespace gicube::emu
