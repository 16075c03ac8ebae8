// What every fidelity level knows of a frame: registers, tables and the volume; and what it counts of the frame's rays.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "flow.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/ray.h"
#include "memory/volume_memory.h"
#include "pipeline/opacity_correction.h"

namespace gicube::emu {

// What holds for every ray of a frame: registers, tables, volume. The tables must outlive it.
struct Frame {
  const VolumeMemory* volume = nullptr;
  std::span<const wire::SegmentationEntry> segmentation;  // wire::kSegmentationEntries
  const std::uint8_t* reflectance_map = nullptr;          // wire::kReflectanceBytes
  const OpacityCorrection* opacity_correction = nullptr;
  std::vector<std::uint8_t> empty;         // one a block; nonzero = leap
  Point extent{};                          // size - 1 in position units
  std::array<std::uint32_t, 3> spacing{};  // 16.16
  std::uint32_t step = 0;                  // 16.16 voxels
  std::uint32_t opacity_threshold = wire::kOpacityOne;
  bool jitter = false;
  bool shade = false;
  bool leap = false;
  std::vector<Plane> cut_planes;
};

struct RayCounters {
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;          // trilinear samples taken
  std::uint64_t visible_samples = 0;  // of those, with an opacity
  std::uint64_t leaps = 0;
  std::uint64_t terminated = 0;  // rays that ended by the opacity threshold

  RayCounters& operator+=(const RayCounters& other) {
    rays += other.rays;
    samples += other.samples;
    visible_samples += other.visible_samples;
    leaps += other.leaps;
    terminated += other.terminated;
    return *this;
  }
};

}  // namespace gicube::emu
