// Rays that the host has scattered (trap.h) and that continue: lighting rays, or rendering rays into the framebuffer.
#pragma once

#include <cstdint>
#include <span>

#include "datapath/interaction.h"
#include "firmware/framebuffer.h"
#include "firmware/lamps.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class ResumedRays : public RayByRaySource {
 public:
  // All parameters must outlive this object.
  ResumedRays(std::span<const wire::Ray> answers, const Frame& frame, Framebuffer& framebuffer, const Lamps& lamps)
      : answers_(answers), frame_(frame), framebuffer_(framebuffer), lamps_(lamps) {}

  std::uint64_t count() const override { return answers_.size(); }
  DspTask making(std::uint64_t i) const override {
    return DspTask{.loop = &kPassRay}.with(in_batch(i, SdramUse::Kind::kRead));
  }
  DspTask taking(std::uint64_t i) const override {
    return frame_.lights() ? DspTask{} : framebuffer_.task(answers_[i].u, answers_[i].v, false);
  }
  DspTask looking(const wire::Ray& ray) const override { return lamps_.task(ray); }

  // A ray may end with its answer; it is then taken here. The energy returned and removed by answers is counted.
  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override {
    wire::Ray ray = answers_[i];
    if (!take_answer(ray, frame_, counters)) return ray;
    take(i, ray);
    return std::nullopt;
  }
  void take(std::uint64_t, const wire::Ray& ray) override {
    if (!frame_.lights()) framebuffer_.add(lamps_.seen_by(ray));
  }

 protected:
  bool pays_for_misses() const override { return true; }

 private:
  std::span<const wire::Ray> answers_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  const Lamps& lamps_;
};

}  // namespace gicube::emu
