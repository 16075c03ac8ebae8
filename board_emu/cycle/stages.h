// The two halves of the ray integration pipeline as one line of rays: the prefetch stages, in which a sample waits for
// its packets, and the compute stages, which all move or all stall [P §3.3, §3.4].
//
//   enter() -> prefetch stages -> start_computing() -> compute stages -> leave() [H307, H308]
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gicube/archive.h"
#include "words/clock.h"
#include "words/words.h"

namespace gicube::emu {

struct InFlight {
  Cycle ready = 0;           // cycle, or clock of the compute stages, at which it has passed its present stages
  RayToken token;            // the ray's destination after the pipeline
  std::uint32_t from = 0;    // queue from which it was issued
  std::uint8_t packets = 0;  // packets that the sample still waits for
  bool sampled = false;      // false: it skipped
  bool splats = false;       // has a deposit or carriers
  std::uint32_t block = 0;   // block whose voxels it reads, if sampled

  void state(Archive::Record& record) {
    record.times(ready);
    record(token, from, packets, sampled, splats, block);
  }
};

class Stages {
 public:
  Stages(std::uint32_t prefetch, std::uint32_t compute)
      : prefetch_stages_(prefetch),
        compute_stages_(compute),
        mask_(std::bit_ceil(std::size_t{prefetch} + compute) - 1),
        ring_(mask_ + 1) {}

  std::size_t prefetch_stages() const { return prefetch_stages_; }
  std::size_t compute_stages() const { return compute_stages_; }
  std::size_t size() const { return prefetching_ + computing_; }
  bool empty() const { return size() == 0; }
  std::size_t prefetching() const { return prefetching_; }
  std::size_t computing() const { return computing_; }

  bool can_enter() const { return prefetching_ < prefetch_stages_; }
  InFlight& enter(Cycle now) {
    InFlight& ray = ring_[(head_ + computing_ + prefetching_++) & mask_];
    ray.ready = now + prefetch_stages_;
    return ray;
  }
  InFlight& oldest_prefetching() { return ring_[(head_ + computing_) & mask_]; }
  // Entry `i` of the prefetch stages, oldest first.
  InFlight& prefetching(std::size_t i) { return ring_[(head_ + computing_ + i) & mask_]; }
  const InFlight& oldest_prefetching() const { return ring_[(head_ + computing_) & mask_]; }
  // Moves the oldest entry of the prefetch stages on. `clock` counts the cycles in which the compute stages move.
  void start_computing(Cycle clock) {
    oldest_prefetching().ready = clock + compute_stages_;
    --prefetching_;
    ++computing_;
  }
  const InFlight& oldest_computing() const { return ring_[head_ & mask_]; }
  void leave() {
    ++head_;
    --computing_;
  }
  void state(Archive::Record& record) {
    record.at_most(prefetching_, prefetch_stages_);
    record.at_most(computing_, ring_.size() - prefetch_stages_);
    for (std::size_t i = 0; i < size(); ++i) record(ring_[(head_ + i) & mask_]);
  }
  // For inner loops that move rays for some cycles. Indices count without wrapping: rays compute from `out`, are
  // prefetched from `middle`, and enter at `in`.
  struct Line {
    InFlight* ring;
    std::size_t mask, out, middle, in;

    InFlight& operator[](std::size_t slot) const { return ring[slot & mask]; }
  };
  Line line() { return {ring_.data(), mask_, head_, head_ + computing_, head_ + computing_ + prefetching_}; }
  void put_back(const Line& line) {
    head_ = line.out;
    computing_ = line.middle - line.out;
    prefetching_ = line.in - line.middle;
  }
  // Entry `i`, oldest first.
  const InFlight& operator[](std::size_t i) const { return ring_[(head_ + i) & mask_]; }

 private:
  std::size_t prefetch_stages_;
  std::size_t compute_stages_;
  std::size_t mask_;
  std::vector<InFlight> ring_;
  std::size_t head_ = 0;
  std::size_t computing_ = 0;
  std::size_t prefetching_ = 0;
};

}  // namespace gicube::emu
