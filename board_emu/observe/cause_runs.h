// Merges the causes of a processor's cycles into slices that are long enough to read.
//
// A run is a sequence of cycles with the same cause. A run of at least kLongRun cycles is a slice. Consecutive shorter
// runs share a slice, which ends with the run that brings it to kMixed cycles, or before the next long run. A slice
// that is still shorter than kLongRun is merged into the slice before it, and so is a long run with that slice's cause.
// Each cycle is in exactly one slice, which counts the causes of its cycles.
#pragma once

#include <algorithm>
#include <cstddef>

#include "asic/sim/causes.h"
#include "words/clock.h"

namespace gicube::emu {

struct CauseSlice {
  Cycle begin = 0;
  Cycle end = 0;  // the cycle after the last
  CauseCounts counts{};

  // The most frequent cause; of equally frequent ones, that with the lowest number.
  Cause cause() const { return static_cast<Cause>(std::max_element(counts.begin(), counts.end()) - counts.begin()); }
};

class CauseRuns {
 public:
  static constexpr Cycle kLongRun = 8;  // chosen: half a pipeline's length
  static constexpr Cycle kMixed = 64;   // chosen: more than half a microsecond at the design point

  // `cycle`: the first cycle to be added.
  void start(Cycle cycle) {
    begin_ = cycle;
    mixed_ = pending_ = {.begin = cycle, .end = cycle, .counts = {}};
  }
  // Adds a cycle. Cycles must be consecutive, beginning with that of start(). Passes complete slices to `emit`.
  template <typename Emit>
  void add(Cycle cycle, Cause cause, const Emit& emit) {
    if (cause == cause_) [[likely]]
      return;
    end_run(cycle, emit);
    cause_ = cause;
  }
  // Passes the remaining slices to `emit`. `end`: the cycle after the last.
  template <typename Emit>
  void finish(Cycle end, const Emit& emit) {
    end_run(end, emit);
    add_slice(mixed_, emit);
    if (pending_.end > pending_.begin) emit(pending_);
  }

 private:
  template <typename Emit>
  void end_run(Cycle end, const Emit& emit) {
    const Cycle length = end - begin_;
    const auto cause = static_cast<std::size_t>(cause_);
    if (length >= kLongRun) {
      add_slice(mixed_, emit);
      CauseSlice slice{begin_, end, {}};
      slice.counts[cause] = length;
      add_slice(slice, emit);
      mixed_ = {.begin = end, .end = end, .counts = {}};
    } else {
      mixed_.counts[cause] += length;
      mixed_.end = end;
      if (end - mixed_.begin >= kMixed) {
        add_slice(mixed_, emit);
        mixed_ = {.begin = end, .end = end, .counts = {}};
      }
    }
    begin_ = end;
  }

  template <typename Emit>
  void add_slice(const CauseSlice& slice, const Emit& emit) {
    const Cycle length = slice.end - slice.begin;
    const Cause cause = slice.cause();
    const bool pure = slice.counts[static_cast<std::size_t>(cause)] == length;
    if (pending_.end > pending_.begin && (length < kLongRun || (pure && cause == pending_.cause()))) {
      pending_.end = slice.end;
      for (std::size_t i = 0; i < kCauses; ++i) pending_.counts[i] += slice.counts[i];
      return;
    }
    if (pending_.end > pending_.begin) emit(pending_);
    pending_ = slice;
  }

  Cause cause_ = Cause::kBusy;  // cause of the run since begin_
  Cycle begin_ = 0;
  CauseSlice mixed_;    // short runs up to begin_
  CauseSlice pending_;  // complete, unless the next slice is merged into it
};

}  // namespace gicube::emu
