// Sees the machine after its cycles, and what happens to the rays that it chooses. Nothing on the board depends on it, unless it sets a
// word on purpose.
#pragma once

#include <cstdint>

#include "asic/sim/ray_event.h"
#include "datapath/ray_step.h"
#include "datapath/shade.h"
#include "words/clock.h"

namespace gicube::emu {

class Machine;

// Core cycles of the machine's clock, begin <= cycle < end.
struct CycleWindow {
  Cycle begin = 0;
  Cycle end = kNoCycle;

  bool has(Cycle cycle) const { return cycle >= begin && cycle < end; }
};

// What a sample of a watched ray was.
struct RaySample {
  Point position{};
  std::int16_t density = 0;  // 12.3
  Point gradient{};          // as the datapath's channels
  unsigned tag = 0;
  Colour12 colour{};   // classified and shaded, not weighted by opacity
  double opacity = 0;  // of the step that the sample stands for, 0..1; exact
  Termination end = Termination::kNot;
};

class Observer {
 public:
  virtual ~Observer() = default;

  // Whether anything below is to be called. Asked at a run's begin and, until it is true, every 4096 cycles of the run. The machine
  // computes ahead while it is false. After it became true the rest of the run is observed.
  virtual bool is_interested() const { return true; }
  // A run of the machine begins with cycle `now`.
  virtual void begins(Cycle /*now*/, Machine& /*machine*/) {}
  // The first cycle from `from` on after which see() is to be called; kNoCycle: none. Asked at a run's begin, after each call,
  // after happened(), and every 4096 cycles.
  virtual Cycle next(Cycle from) { return from; }
  virtual void see(Cycle /*now*/, const Machine& /*machine*/) {}

  // Whether happened() is to be called for ray number `ray` of the run's source. Asked once, as the DSP makes it.
  virtual bool watches(std::uint64_t /*ray*/, const wire::Ray& /*made*/) { return false; }
  // In the cycle of the event, of which not all parts may have ticked yet. What the event points to is gone afterwards.
  virtual void happened(const RayEvent& /*event*/, const Machine& /*machine*/) {}
};

}  // namespace gicube::emu
