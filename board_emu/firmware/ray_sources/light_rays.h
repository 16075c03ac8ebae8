// The lighting rays of an illumination. They deposit their energy in the volume and are then discarded.
#pragma once

#include <algorithm>
#include <cstdint>

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "firmware/lighting_rays.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class LightRays : public RayByRaySource {
 public:
  // All parameters must outlive this object.
  LightRays(const LightingRays& rays, const Frame& frame) : rays_(rays), frame_(frame) {}

  std::uint64_t count() const override { return rays_.count(); }
  DspTask making(std::uint64_t) const override { return {.loop = &kMakeLightingRay}; }
  DspTask taking(std::uint64_t) const override { return {}; }
  bool misses_are_free() const override { return true; }

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override {
    auto ray = rays_.make(i);
    if (!ray) return ray;
    ray->lifetime = frame_.lifetime;
    if (frame_.light_words == 1) {
      counters.energy.emitted += ray->colour_word() >> kEnergyFractionBits;
    } else {
      count_emitted(unpack(*ray, frame_), frame_, counters);
    }
    return ray;
  }
  void take(std::uint64_t, const wire::Ray&) override {}

  std::size_t divide(std::size_t rays) override {
    constexpr std::size_t kRun = 4096;  // chosen: neighbours on a face, which share voxels
    return RayByRaySource::divide(std::max(rays, kRun));
  }

 private:
  const LightingRays& rays_;
  const Frame& frame_;
};

}  // namespace gicube::emu
