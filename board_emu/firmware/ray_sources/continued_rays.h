// Rendering rays that have waited for a block and go on, into the framebuffer.
#pragma once

#include <cstdint>
#include <span>

#include "datapath/waiting_ray.h"
#include "firmware/framebuffer.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class ContinuedRays : public RayByRaySource {
 public:
  // All must outlive this.
  ContinuedRays(std::span<const WaitingRay> rays, Framebuffer& framebuffer) : rays_(rays), framebuffer_(framebuffer) {}

  std::uint64_t count() const override { return rays_.size(); }
  std::uint64_t max_under_way() const override { return kViewingRaysUnderWay; }
  DspTask making(std::uint64_t i) const override {
    return DspTask{.loop = &kPassRay}.with(in_batch(i, SdramUse::Kind::kRead));
  }
  DspTask taking(std::uint64_t i) const override { return framebuffer_.task(rays_[i].ray.u, rays_[i].ray.v, false); }

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters&) override { return rays_[i].ray; }
  void take(std::uint64_t, const wire::Ray& ray) override { framebuffer_.add(ray); }

 private:
  std::span<const WaitingRay> rays_;
  Framebuffer& framebuffer_;
};

}  // namespace gicube::emu
