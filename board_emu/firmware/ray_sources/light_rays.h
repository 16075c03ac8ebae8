// The lighting rays of an illumination: they leave their energy in the volume, and nothing of them is kept.
#pragma once

#include <algorithm>
#include <cstdint>

#include "datapath/ray_step.h"
#include "firmware/lighting_rays.h"
#include "gicube/v1/board_config.pb.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class LightRays : public RayByRaySource {
 public:
  // All must outlive this.
  LightRays(const LightingRays& rays, const Frame& frame, const v1::DspConfig& dsp)
      : rays_(rays), frame_(frame), dsp_(dsp) {}

  std::uint64_t count() const override { return rays_.count(); }
  std::uint32_t make_cycles() const override { return dsp_.lighting_ray_cycles(); }
  std::uint32_t take_cycles() const override { return 0; }
  bool misses_are_free() const override { return true; }

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override {
    auto ray = rays_.make(i);
    if (!ray) return ray;
    ray->lifetime = frame_.lifetime;
    counters.energy.emitted += ray->colour_word() >> kEnergyFractionBits;
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
  const v1::DspConfig& dsp_;
};

}  // namespace gicube::emu
