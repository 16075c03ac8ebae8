// The functional level's way of a ray: the pipeline's pure stages in a loop, without queues, caches or clocks.
//
// What enters: a ray and the frame's constants; what leaves: the ray as it ends. Nothing a ray computes depends on other
// rays, so any number of threads gives the same bits.
#pragma once

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

// Takes `ray` from its position to its end: out of the volume, behind a cut plane, or opaque enough. The ray comes back
// with its gathered colour and opacity and the position where it ended, clamped to the volume.
void integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters);

}  // namespace gicube::emu
