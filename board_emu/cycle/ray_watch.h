// Selects the watched rays of a machine, and reports their events to its observer.
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
  // `see_at`: the next cycle that the observer has requested; it may change after an event.
  RayWatch(const Machine& machine, const RayStore& rays, Cycle& see_at)
      : machine_(machine), rays_(rays), see_at_(see_at) {}

  void set_observer(Observer* observer) { observer_ = observer; }
  // All rays until the next call belong to this frame.
  void begin(const Frame& frame) {
    frame_ = &frame;
    watched_.clear();
  }

  // Called when a ray of the source has got its handle.
  void made(Cycle now, std::uint32_t handle, std::uint64_t number, const wire::Ray& ray);
  bool watches(std::uint32_t handle) const { return !watched_.empty() && watched_.contains(handle); }
  // Called when a watched ray sends a carrier.
  void made_carrier(std::uint32_t from, std::uint32_t carrier);

  // Called before and after an iteration of a watched ray. `how`: whether it has ended.
  void before(const RayUnderWay& ray) { before_ = ray; }
  void after(const RayEvent& event, Termination how);
  // Called for each cycle in which its sample is stalled at the end of the prefetch line, and when it continues.
  void waits(std::uint32_t handle) { ++watched_[handle].waited; }
  void goes_on(const RayEvent& event);

  void report(const RayEvent& event) override;

 private:
  struct Watched {
    std::uint64_t number = 0;
    bool is_carrier = false;
    std::uint64_t waited = 0;   // cycles
    std::uint64_t missing = 0;  // packets of the latest sample
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
