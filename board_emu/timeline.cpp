#include "timeline.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace gicube::emu {

void Timeline::add(Picoseconds stamp, std::uint64_t id, const Errand& errand) {
  advance(stamp);
  under_way_.emplace(id, Issued{errand, std::max(stamp, now_ps_)});
  bus_.enqueue(Direction::kDown, {id, errand.kind, errand.cargo, errand.down_bytes, std::max(stamp, now_ps_)});
}

void Timeline::end(std::uint64_t id, Picoseconds time) {
  const auto errand = under_way_.find(id);
  if (errand->second.errand.watched) finished_.push_back({id, time});
  under_way_.erase(errand);
}

void Timeline::deliver(const BusDelivery& delivery) {
  const auto [errand, stamp] = under_way_.at(delivery.id);
  if (watcher_ != nullptr) watcher_->transferred(delivery);
  if (delivery.direction == Direction::kUp) return end(delivery.id, delivery.time_ps);
  Picoseconds done = delivery.time_ps;
  if (errand.dsp) {
    const Picoseconds busy = cycles_to_ps(errand.dsp_cycles, dsp_khz_);
    const Picoseconds work = std::max(busy, errand.asic_ps);
    const Picoseconds waiting_since = std::max(stamp, dsp_free_ps_);
    if (delivery.time_ps > waiting_since) host_bus_wait_ps_ += delivery.time_ps - waiting_since;
    done = std::max(done, dsp_free_ps_) + work;
    dsp_free_ps_ = done;
    if (watcher_ != nullptr) watcher_->served(errand, done - work, done);
    dsp_busy_ps_ += busy;
  }
  if (errand.up_bytes == 0) return end(delivery.id, done);
  bus_.enqueue(Direction::kUp, {delivery.id, TransferKind::kBulk, errand.up_cargo, errand.up_bytes, done});
}

void Timeline::advance(Picoseconds horizon) {
  while (const auto delivery = bus_.next_delivery(horizon)) deliver(*delivery);
  now_ps_ = std::max(now_ps_, horizon);
}

Picoseconds Timeline::turn_of(Picoseconds stamp, const Errand& errand) const {
  constexpr std::uint64_t kAhead = ~std::uint64_t{0};
  Timeline ahead = *this;
  ahead.watcher_ = nullptr;
  ahead.add(
      stamp, kAhead,
      {.kind = errand.kind, .cargo = errand.cargo, .down_bytes = errand.down_bytes, .dsp = true, .watched = true});
  return ahead.finish(kAhead);
}

Picoseconds Timeline::finish(std::uint64_t id) {
  const auto is_it = [id](const Finished& finished) { return finished.id == id; };
  auto found = std::find_if(finished_.begin(), finished_.end(), is_it);
  while (found == finished_.end()) {
    const auto delivery = bus_.next_delivery(kNever);
    if (!delivery) throw std::logic_error("errand " + std::to_string(id) + " was never added");
    deliver(*delivery);
    found = std::find_if(finished_.begin(), finished_.end(), is_it);
  }
  const Picoseconds time = found->time_ps;
  advance(time);
  return time;
}

std::vector<Finished> Timeline::take_finished() {
  const auto later = std::stable_partition(finished_.begin(), finished_.end(),
                                           [this](const Finished& finished) { return finished.time_ps <= now_ps_; });
  std::vector<Finished> taken(finished_.begin(), later);
  finished_.erase(finished_.begin(), later);
  std::stable_sort(taken.begin(), taken.end(),
                   [](const Finished& a, const Finished& b) { return a.time_ps < b.time_ps; });
  return taken;
}

}  // namespace gicube::emu
