#include "timeline.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace gicube::emu {

namespace {

constexpr std::uint64_t kCompletionWordBytes = 4;  // in the host's memory

}  // namespace

void Timeline::add(Picoseconds stamp, std::uint64_t id, const BusTransaction& transaction) {
  advance(stamp);
  under_way_.emplace(id, Issued{transaction, std::max(stamp, now_ps_)});
  bus_.enqueue(Direction::kDown,
               {id, transaction.kind, transaction.cargo, transaction.down_bytes, std::max(stamp, now_ps_)});
}

void Timeline::end(std::uint64_t id, Picoseconds time) {
  const auto issued = under_way_.find(id);
  if (issued->second.transaction.watched) finished_.push_back({id, time});
  under_way_.erase(issued);
}

void Timeline::deliver(const BusDelivery& delivery) {
  if (watcher_ != nullptr) watcher_->transferred(delivery);
  if (delivery.direction == Direction::kUp) return end(delivery.id, delivery.time_ps);
  if (!under_way_.at(delivery.id).transaction.dsp) return send_up(delivery.id, delivery.time_ps);
  dsp_queue_.push_back({delivery.id, delivery.time_ps});
  begin_turns();
}

void Timeline::begin_turns() {
  if (in_turn_ || dsp_queue_.empty()) return;
  const Arrived arrived = dsp_queue_.front();
  dsp_queue_.pop_front();
  const auto& [transaction, stamp] = under_way_.at(arrived.id);
  const Picoseconds busy = cycles_to_ps(transaction.dsp_cycles, dsp_khz_);
  const Picoseconds waiting_since = std::max(stamp, dsp_free_ps_);
  if (arrived.time_ps > waiting_since) host_bus_wait_ps_ += arrived.time_ps - waiting_since;
  const Picoseconds begin = std::max(arrived.time_ps, dsp_free_ps_);
  dsp_free_ps_ = begin + std::max(busy, transaction.asic_ps);
  if (watcher_ != nullptr) watcher_->served(transaction, begin, dsp_free_ps_);
  dsp_busy_ps_ += busy;
  in_turn_ = arrived.id;
}

void Timeline::end_turn() {
  const std::uint64_t id = *in_turn_;
  in_turn_.reset();
  send_up(id, dsp_free_ps_);
  begin_turns();
}

void Timeline::send_up(std::uint64_t id, Picoseconds ready) {
  const BusTransaction& transaction = under_way_.at(id).transaction;
  if (transaction.up_bytes == 0) return end(id, ready);
  bus_.enqueue(Direction::kUp, {id, TransferKind::kBulk, transaction.up_cargo, transaction.up_bytes, ready});
}

// The next thing that happens, if it does by `horizon`. A turn that ends is dealt with first: what it sends up competes
// with what is on its way down.
bool Timeline::step(Picoseconds horizon) {
  const Picoseconds turn_ends = in_turn_ ? dsp_free_ps_ : kNever;
  if (const auto delivery = bus_.next_delivery(std::min(horizon, turn_ends))) {
    deliver(*delivery);
    return true;
  }
  if (turn_ends == kNever || turn_ends > horizon) return false;
  end_turn();
  return true;
}

void Timeline::advance(Picoseconds horizon) {
  while (step(horizon)) continue;
  now_ps_ = std::max(now_ps_, horizon);
}

bool Timeline::take_back(Picoseconds stamp, std::uint64_t id) {
  advance(stamp);
  const auto found = under_way_.find(id);
  const auto waits = [id](const Arrived& arrived) { return arrived.id == id; };
  const bool on_bus = bus_.carries(Direction::kDown, id);
  if (found == under_way_.end() || (!on_bus && std::none_of(dsp_queue_.begin(), dsp_queue_.end(), waits))) return false;
  BusTransaction& transaction = found->second.transaction;
  transaction.dsp_cycles = 0;
  transaction.asic_ps = 0;
  transaction.up_bytes = kCompletionWordBytes;
  transaction.up_cargo = Cargo::kCompletion;
  return true;
}

Picoseconds Timeline::turn_of(Picoseconds stamp, const BusTransaction& transaction) const {
  constexpr std::uint64_t kAhead = ~std::uint64_t{0};
  Timeline ahead = *this;
  ahead.watcher_ = nullptr;
  ahead.add(stamp, kAhead,
            {.kind = transaction.kind,
             .cargo = transaction.cargo,
             .down_bytes = transaction.down_bytes,
             .dsp = true,
             .watched = true});
  return ahead.finish(kAhead);
}

std::optional<Picoseconds> Timeline::finish(std::uint64_t id, Picoseconds deadline) {
  const auto is_it = [id](const Finished& finished) { return finished.id == id; };
  auto found = std::find_if(finished_.begin(), finished_.end(), is_it);
  while (found == finished_.end()) {
    if (!step(deadline)) {
      if (deadline == kNever) throw std::logic_error("transaction " + std::to_string(id) + " was never added");
      advance(deadline);
      return std::nullopt;
    }
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
