// Observes the machine after its cycles, and the events of the rays that it selects. The board does not depend on it,
// unless it sets a word on purpose.
#pragma once

#include <cstdint>

#include "asic/sim/ray_event.h"
#include "datapath/ray_step.h"
#include "datapath/shade.h"
#include "words/clock.h"

namespace gicube::emu {

class Machine;

// A range of core cycles, begin <= cycle < end.
struct CycleWindow {
  Cycle begin = 0;
  Cycle end = kNoCycle;

  bool has(Cycle cycle) const { return cycle >= begin && cycle < end; }
};

// The sample of a watched ray.
struct RaySample {
  Point position{};
  std::int16_t density = 0;  // 12.3
  Point gradient{};          // as in the datapath's channels
  unsigned tag = 0;
  Colour12 colour{};   // classified and shaded, not weighted by opacity
  double opacity = 0;  // opacity of the step that the sample represents, 0..1; exact
  Termination end = Termination::kActive;
};

class Observer {
 public:
  virtual ~Observer() = default;

  // Whether any function below is to be called. Queried at the start of a run and, until it is true, every 4096 cycles
  // of the run. While it is false the machine computes ahead; from then on the rest of the run is observed.
  virtual bool is_interested() const { return true; }
  // Called when a run of the machine starts with cycle `now`.
  virtual void begins(Cycle /*now*/, Machine& /*machine*/) {}
  // The first cycle from `from` on after which see() is to be called; kNoCycle: none. Queried at the start of a run,
  // after each call, after happened(), and every 4096 cycles.
  virtual Cycle next(Cycle from) { return from; }
  virtual void see(Cycle /*now*/, const Machine& /*machine*/) {}
  // The machine is about to be removed, because its run was cancelled or failed.
  virtual void removed(const Machine& /*machine*/) {}

  // Whether happened() is to be called for ray number `ray` of the run's source. Queried once, when the DSP makes the
  // ray.
  virtual bool watches(std::uint64_t /*ray*/, const wire::Ray& /*made*/) { return false; }
  // Called in the cycle of the event; some parts may not have ticked yet. The event's pointers are valid only in the
  // call.
  virtual void happened(const RayEvent& /*event*/, const Machine& /*machine*/) {}
};

}  // namespace gicube::emu
