// Rays that continue after waiting for a block. They end in the framebuffer, in the host's rays, or only with their
// deposits.
#pragma once

#include <cstdint>
#include <span>

#include "datapath/waiting_rays.h"
#include "firmware/framebuffer.h"
#include "firmware/lamps.h"
#include "firmware/ray_sources/host_rays.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class ContinuedRays : public RayByRaySource {
 public:
  // Destination of rays that end: one of these, or none. If `others` is not null, it receives rays of other cards.
  struct Ends {
    Framebuffer* framebuffer = nullptr;
    const Lamps* lamps = nullptr;  // with a framebuffer
    std::span<wire::Ray> host_rays{};
    WaitingRays* others = nullptr;
  };

  // All parameters must outlive this object.
  ContinuedRays(std::span<const WaitingRay> rays, const Frame& frame, const Ends& ends)
      : rays_(rays), frame_(frame), ends_(ends) {}

  std::uint64_t count() const override { return rays_.size(); }
  std::uint64_t max_under_way() const override { return kViewingRaysUnderWay; }
  DspTask making(std::uint64_t i) const override {
    return DspTask{.loop = &kPassRay}.with(in_batch(i, SdramUse::Kind::kRead));
  }
  DspTask taking(std::uint64_t i) const override {
    const RayState& ray = rays_[i].ray_state;
    if (rays_[i].home != 0) {
      return ends_.others != nullptr ? DspTask{.loop = &kPassRay}.with(in_batch(i, SdramUse::Kind::kWrite)) : DspTask{};
    }
    if (ends_.framebuffer != nullptr) return ends_.framebuffer->task(ray.u, ray.v, false);
    if (ends_.host_rays.empty()) return {};
    return DspTask{.loop = &kPassRay}.with(in_batch(i, SdramUse::Kind::kWrite));
  }
  DspTask looking(const wire::Ray& ray) const override {
    return ends_.lamps != nullptr ? ends_.lamps->task(ray) : DspTask{};
  }

  // Returns the packet. The level gets the remaining bits from the frame's WaitingRays.
  std::optional<wire::Ray> make(std::uint64_t i, RayCounters&) override { return pack(rays_[i].ray_state, frame_); }
  void take(std::uint64_t i, const wire::Ray& ray) override {
    if (rays_[i].home != 0) {
      if (ends_.others != nullptr) ends_.others->add_ended({rays_[i].number, rays_[i].home, ray});
    } else if (ends_.framebuffer != nullptr) {
      ends_.framebuffer->add(ends_.lamps->seen_by(ray));
    } else if (!ends_.host_rays.empty()) {
      put_back(ray, ends_.host_rays[static_cast<std::size_t>(rays_[i].number)]);
    }
  }

 private:
  std::span<const WaitingRay> rays_;
  const Frame& frame_;
  Ends ends_;
};

}  // namespace gicube::emu
