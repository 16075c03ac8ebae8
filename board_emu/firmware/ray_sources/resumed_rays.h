// Rays that the host has scattered (trap.h) and that go on: lighting rays, or rendering rays into the framebuffer.
#pragma once

#include <cstdint>
#include <span>

#include "datapath/interaction.h"
#include "firmware/framebuffer.h"
#include "gicube/v1/board_config.pb.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class ResumedRays : public RayByRaySource {
 public:
  // All must outlive this.
  ResumedRays(std::span<const wire::Ray> answers, const Frame& frame, Framebuffer& framebuffer,
              const v1::DspConfig& dsp)
      : answers_(answers), frame_(frame), framebuffer_(framebuffer), dsp_(dsp) {}

  std::uint64_t count() const override { return answers_.size(); }
  std::uint32_t make_cycles() const override { return dsp_.host_ray_cycles() / 2; }
  std::uint32_t take_cycles() const override { return frame_.lights() ? 0 : dsp_.returned_ray_cycles(); }

  // A ray that ends by its answer goes no further. What answers bring and take counts.
  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override {
    wire::Ray ray = answers_[i];
    if (!take_answer(ray, frame_, counters)) return ray;
    take(i, ray);
    return std::nullopt;
  }
  void take(std::uint64_t, const wire::Ray& ray) override {
    if (!frame_.lights()) framebuffer_.add(ray);
  }

 protected:
  bool pays_for_misses() const override { return true; }

 private:
  std::span<const wire::Ray> answers_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  const v1::DspConfig& dsp_;
};

}  // namespace gicube::emu
