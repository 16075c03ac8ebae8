// Rays that the host made, in the DSP's memory: they go back into their places, or leave only what they deposit.
#pragma once

#include <cstdint>
#include <span>

#include "levels/ray_source.h"

namespace gicube::emu {

class HostRays : public RaySource {
 public:
  struct Cycles {  // of the DSP, of each ray
    std::uint32_t make = 0;
    std::uint32_t take = 0;
  };
  // `come_back`: into their places in `rays`; else what stands there afterwards is of no use. A ray that lies behind a cut
  // plane stays as it is. Both must outlive this.
  HostRays(std::span<wire::Ray> rays, const Frame& frame, bool come_back, const Cycles& cycles)
      : rays_(rays), frame_(frame), come_back_(come_back), cycles_(cycles) {}

  std::uint64_t count() const override { return rays_.size(); }
  std::uint32_t make_cycles() const override { return cycles_.make; }
  std::uint32_t take_cycles() const override { return cycles_.take; }

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override;
  void take(std::uint64_t i, const wire::Ray& ray) override;

  std::size_t divide(std::size_t rays) override;
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override;
  void take_batch(RayBatch& batch) override;

 private:
  std::span<wire::Ray> rays_;
  const Frame& frame_;
  bool come_back_;
  Cycles cycles_;
  std::size_t batch_rays_ = 1;
};

}  // namespace gicube::emu
