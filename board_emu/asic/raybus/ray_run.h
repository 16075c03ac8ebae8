// Runs of viewing rays: the ray differentials of [P §3.6].
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "words/words.h"

namespace gicube::emu {

// Runs on their way to the processors. On the bus a run is two packets: its first ray, and the differential and count
// from which each processor extrapolates its own rays. Here it is the list of the rays' tokens in their order: the
// packets themselves were made by the DSP's own arithmetic, so that differentials change time and no bit of an image.
class RunPool {
 public:
  using Run = std::uint32_t;  // handle

  explicit RunPool(std::uint32_t listeners) : listeners_(listeners) {}

  // A run of at least one ray. The handle goes into the bus's FIFO of runs.
  Run add(std::span<const RayToken> rays);
  std::span<const RayToken> rays(Run run) const { return runs_[run].rays; }
  // One listener has no more use for it; the last one frees it.
  void release(Run run);
  std::uint32_t in_use() const { return static_cast<std::uint32_t>(runs_.size() - free_.size()); }

 private:
  struct Entry {
    std::vector<RayToken> rays;
    std::uint32_t holders = 0;
  };

  std::uint32_t listeners_;
  std::vector<Entry> runs_;
  std::vector<Run> free_;
};

}  // namespace gicube::emu
