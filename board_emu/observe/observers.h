// Several observers of one machine. Each receives only the cycles and rays that it has requested.
#pragma once

#include <algorithm>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "cycle/observer.h"

namespace gicube::emu {

class Observers final : public Observer {
 public:
  // `observer` must outlive this.
  void add(Observer& observer) { seats_.push_back({&observer}); }
  bool empty() const { return seats_.empty(); }

  bool is_interested() const override {
    return std::ranges::any_of(seats_, [](const Seat& seat) { return seat.observer->is_interested(); });
  }
  void begins(Cycle now, Machine& machine) override {
    watched_by_.clear();
    for (Seat& seat : seats_) seat.observer->begins(now, machine);
  }
  Cycle next(Cycle from) override {
    Cycle first = kNoCycle;
    for (Seat& seat : seats_) first = std::min(first, seat.sees = seat.observer->next(from));
    return first;
  }
  void see(Cycle now, const Machine& machine) override {
    for (Seat& seat : seats_) {
      if (seat.sees <= now) seat.observer->see(now, machine);
    }
  }
  void removed(const Machine& machine) override {
    for (Seat& seat : seats_) seat.observer->removed(machine);
  }
  bool watches(std::uint64_t ray, const wire::Ray& made) override {
    std::uint32_t by = 0;
    for (std::size_t i = 0; i < seats_.size(); ++i) by |= std::uint32_t{seats_[i].observer->watches(ray, made)} << i;
    if (by != 0) watched_by_[ray] = by;
    return by != 0;
  }
  void happened(const RayEvent& event, const Machine& machine) override {
    const std::uint32_t by = watched_by_[event.ray];
    for (std::size_t i = 0; i < seats_.size(); ++i) {
      if ((by >> i & 1) != 0) seats_[i].observer->happened(event, machine);
    }
  }

 private:
  struct Seat {
    Observer* observer;
    Cycle sees = 0;  // the next cycle that it has requested
  };
  std::vector<Seat> seats_;
  std::unordered_map<std::uint64_t, std::uint32_t> watched_by_;  // by ray: one bit per seat
};

}  // namespace gicube::emu
