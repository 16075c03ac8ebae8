// Which rays of a machine are watched, and what its observer is told of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <unordered_map>

#include "asic/sim/ray_event.h"
#include "cycle/observer.h"
#include "cycle/ray_store.h"

namespace gicube::emu {

class RayWatch final : public RayListener {
 public:
  // `see_at`: the cycle from which on the observer sees the machine; it may want another after an event.
  RayWatch(const Machine& machine, const RayStore& rays, Cycle& see_at)
      : machine_(machine), rays_(rays), see_at_(see_at) {}

  void set_observer(Observer* observer) { observer_ = observer; }
  // All rays until the next call are of this frame.
  void begin(const Frame& frame) {
    frame_ = &frame;
    watched_.clear();
  }

  // A ray of the source has got its handle.
  void made(Cycle now, std::uint32_t handle, std::uint64_t number, const wire::Ray& ray);
  bool watches(std::uint32_t handle) const { return !watched_.empty() && watched_.contains(handle); }
  // A watched ray sends its deposit on.
  void made_carrier(std::uint32_t from, std::uint32_t carrier);

  // Round a pass through the pipeline of a watched ray. `how`: whether it ended.
  void before(const RayUnderWay& ray) { before_ = ray; }
  void after(const RayEvent& event, Termination how);
  // Its sample stands at the end of the prefetch line for another cycle, or no longer.
  void waits(std::uint32_t handle) { ++watched_[handle].waited; }
  void goes_on(const RayEvent& event);

  void tell(const RayEvent& event) override;

 private:
  struct Watched {
    std::uint64_t number = 0;
    bool is_carrier = false;
    std::uint64_t waited = 0;   // cycles
    std::uint64_t missing = 0;  // packets, of the latest sample
  };

  void happened(const RayEvent& event) {
    if (observer_ == nullptr) return;
    observer_->happened(event, machine_);
    see_at_ = std::max(event.cycle, observer_->next(event.cycle));
  }

  const Machine& machine_;
  const RayStore& rays_;
  Cycle& see_at_;
  Observer* observer_ = nullptr;
  const Frame* frame_ = nullptr;
  std::unordered_map<std::uint32_t, Watched> watched_;  // by handle
  RayUnderWay before_;
};

}  // namespace gicube::emu
