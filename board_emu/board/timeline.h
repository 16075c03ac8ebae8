// Simulated time of the host bus and the DSP, for all fidelity levels.
//
// A transaction is sent down the bus, passes through the DSP in the order of arrival, and returns up the bus. It can be
// cancelled until its turn at the DSP begins. Time advances only as far as it is final: no transaction before the
// host's latest timestamp follows.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "board/board_observer.h"
#include "board/bus/host_bus.h"
#include "gicube/archive.h"
#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/command.h"
#include "words/clock.h"

namespace gicube::emu {

struct BusTransaction {
  TransferKind kind = TransferKind::kBulk;
  Cargo cargo = Cargo::kRegister;
  std::uint64_t down_bytes = 0;
  bool dsp = false;              // waits for its turn at the DSP, even without cycles of its own
  std::uint64_t dsp_cycles = 0;  // busy time of the DSP
  Picoseconds asic_ps = 0;       // minimum length of the turn: the working time of the ASIC
  std::uint64_t up_bytes = 0;
  Cargo up_cargo = Cargo::kCompletion;
  bool watched = false;   // finish() or take_finished() will ask for its end
  const char* name = "";  // name of its turn at the DSP in a trace: its command, or kReadMemory

  void state(Archive::Record& record);
};

// The only work of the DSP besides commands.
inline constexpr const char* kReadMemory = "read memory";

inline void BusTransaction::state(Archive::Record& record) {
  record.at_most(kind, TransferKind::kRegisterRead);
  record.at_most(cargo, Cargo::kCompletion);
  record.at_most(down_bytes, kMostBytes);
  record(dsp);
  record.at_most(dsp_cycles, kMostCycles);
  record.at_most(asic_ps, kMostSpan);
  record.at_most(up_bytes, kMostBytes);
  record.at_most(up_cargo, Cargo::kCompletion);
  record(watched);
  // Saved as the opcode; kReadMemory as the number after the last opcode; no name as 0.
  constexpr auto& kNames = wire::kOpcodeNames;
  const std::string_view now = name;
  std::size_t which = now == kReadMemory ? kNames.size() : 0;
  for (std::size_t opcode = 1; opcode < kNames.size(); ++opcode) which = now == kNames[opcode] ? opcode : which;
  record.at_most(which, kNames.size());
  name = which == 0 ? "" : which == kNames.size() ? kReadMemory : kNames[which];
}

// A time of a transaction: its arrival at the DSP or its end.
struct TimeOf {
  std::uint64_t id = 0;
  Picoseconds time_ps = 0;

  void state(Archive::Record& record) {
    record(id);
    record.at_most(time_ps, kMostTime);
  }
};

class Timeline {
 public:
  Timeline(const BusTiming& bus, std::uint64_t dsp_khz) : bus_(bus), dsp_khz_(dsp_khz) {}

  // Adds a transaction that the host issues at `stamp`, with a unique id. First advances to `stamp`.
  void add(Picoseconds stamp, std::uint64_t id, const BusTransaction& transaction) {
    advance(stamp);
    under_way_.emplace(id, Issued{transaction, std::max(stamp, now_ps_)});
    bus_.enqueue(BusDirection::kDown,
                 {id, transaction.kind, transaction.cargo, transaction.down_bytes, std::max(stamp, now_ps_)});
  }

  // When the DSP turn of a transaction would begin if it were added at `stamp` and no earlier one is cancelled.
  Picoseconds turn_of(Picoseconds stamp, const BusTransaction& transaction) const {
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

  void set_watcher(BoardObserver* watcher) { watcher_ = watcher; }

  void advance(Picoseconds horizon) {
    while (step(horizon)) continue;
    now_ps_ = std::max(now_ps_, horizon);
  }

  // Advances until this watched transaction, which was not taken yet, is finished. Returns its time, or nothing if it
  // is after `deadline`.
  std::optional<Picoseconds> finish(std::uint64_t id, Picoseconds deadline) {
    const auto is_it = [id](const TimeOf& finished) { return finished.id == id; };
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
  Picoseconds finish(std::uint64_t id) { return *finish(id, kNever); }

  // Cancels a transaction at `stamp`: the DSP spends no time on it, and only a completion word is sent up. Returns
  // false if it is too late.
  bool take_back(Picoseconds stamp, std::uint64_t id) {
    advance(stamp);
    const auto found = under_way_.find(id);
    const auto waits = [id](const TimeOf& arrived) { return arrived.id == id; };
    const bool on_bus = bus_.carries(BusDirection::kDown, id);
    if (found == under_way_.end() || (!on_bus && std::none_of(dsp_queue_.begin(), dsp_queue_.end(), waits)))
      return false;
    BusTransaction& transaction = found->second.transaction;
    transaction.dsp_cycles = 0;
    transaction.asic_ps = 0;
    transaction.up_bytes = kCompletionWordBytes;
    transaction.up_cargo = Cargo::kCompletion;
    return true;
  }

  // Returns the watched transactions that have finished by now and were not taken yet, in the order of their times.
  std::vector<TimeOf> take_finished() {
    const auto later = std::stable_partition(finished_.begin(), finished_.end(),
                                             [this](const TimeOf& finished) { return finished.time_ps <= now_ps_; });
    std::vector<TimeOf> taken(finished_.begin(), later);
    finished_.erase(finished_.begin(), later);
    std::stable_sort(taken.begin(), taken.end(),
                     [](const TimeOf& a, const TimeOf& b) { return a.time_ps < b.time_ps; });
    return taken;
  }

  // Number of transactions that were added and have not finished, or were not taken yet.
  std::size_t under_way() const { return under_way_.size() + finished_.size(); }
  Picoseconds now() const { return now_ps_; }
  Picoseconds dsp_busy_ps() const { return dsp_busy_ps_; }
  // Idle time of the DSP while a command for it was on its way down the bus.
  Picoseconds host_bus_wait_ps() const { return host_bus_wait_ps_; }
  const HostBus& bus() const { return bus_; }
  // Whether a transaction with this number or a later one is in progress, or was not taken yet.
  bool has_from(std::uint64_t id) const {
    const auto is_later = [id](const auto& each) { return each.first >= id; };
    const auto has_finished = [id](const TimeOf& each) { return each.id >= id; };
    return std::ranges::any_of(under_way_, is_later) || std::ranges::any_of(finished_, has_finished);
  }
  // Whether finish() would find this transaction.
  bool has_watched(std::uint64_t id) const {
    const auto is_it = [id](const TimeOf& finished) { return finished.id == id; };
    const auto found = under_way_.find(id);
    if (found != under_way_.end()) return found->second.transaction.watched;
    return std::ranges::any_of(finished_, is_it);
  }
  void state(Archive& archive);

 private:
  static constexpr std::uint64_t kCompletionWordBytes = 4;  // in the host's memory

  // Executes the next event by `horizon`, if there is one. The bus advances only to the end of the current turn,
  // because the data that the turn then sends up competes with transfers on the way down.
  bool step(Picoseconds horizon) {
    const Picoseconds turn_ends = in_turn_ ? dsp_free_ps_ : kNever;
    if (const auto delivery = bus_.next_delivery(std::min(horizon, turn_ends))) {
      deliver(*delivery);
      return true;
    }
    if (turn_ends == kNever || turn_ends > horizon) return false;
    end_turn();
    return true;
  }
  void deliver(const BusDelivery& delivery) {
    if (watcher_ != nullptr) watcher_->transferred(delivery);
    if (delivery.direction == BusDirection::kUp) return end(delivery.id, delivery.time_ps);
    if (!under_way_.at(delivery.id).transaction.dsp) return send_up(delivery.id, delivery.time_ps);
    dsp_queue_.push_back({delivery.id, delivery.time_ps});
    begin_turns();
  }
  void begin_turns() {
    if (in_turn_ || dsp_queue_.empty()) return;
    const TimeOf arrived = dsp_queue_.front();
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
  void end_turn() {
    const std::uint64_t id = *in_turn_;
    in_turn_.reset();
    send_up(id, dsp_free_ps_);
    begin_turns();
  }
  void send_up(std::uint64_t id, Picoseconds ready) {
    const BusTransaction& transaction = under_way_.at(id).transaction;
    if (transaction.up_bytes == 0) return end(id, ready);
    bus_.enqueue(BusDirection::kUp, {id, TransferKind::kBulk, transaction.up_cargo, transaction.up_bytes, ready});
  }
  void end(std::uint64_t id, Picoseconds time) {
    const auto transaction = under_way_.find(id);
    if (transaction->second.transaction.watched) finished_.push_back({id, time});
    under_way_.erase(transaction);
  }

  HostBus bus_;
  std::uint64_t dsp_khz_;
  BoardObserver* watcher_ = nullptr;
  Picoseconds now_ps_ = 0;
  Picoseconds dsp_free_ps_ = 0;
  Picoseconds dsp_busy_ps_ = 0;
  Picoseconds host_bus_wait_ps_ = 0;
  struct Issued {
    BusTransaction transaction;
    Picoseconds stamp_ps = 0;

    void state(Archive::Record& record) {
      record(transaction);
      record.at_most(stamp_ps, kMostTime);
    }
  };
  std::unordered_map<std::uint64_t, Issued> under_way_;
  std::deque<TimeOf> dsp_queue_;          // transactions that wait for their turns
  std::optional<std::uint64_t> in_turn_;  // the transaction at the DSP, until dsp_free_ps_
  std::vector<TimeOf> finished_;
};

// Each transaction in progress is in exactly one place.
inline void Timeline::state(Archive& archive) {
  archive("bus", bus_);
  archive.field("times", [this](Archive::Record& record) {
    record.at_most(now_ps_, kMostTime);
    record.at_most(dsp_free_ps_, kMostTime);
    record(dsp_busy_ps_, host_bus_wait_ps_);
  });
  std::vector<std::pair<std::uint64_t, Issued>> issued(under_way_.begin(), under_way_.end());
  std::ranges::sort(issued, {}, &std::pair<std::uint64_t, Issued>::first);
  archive.list("under_way", issued);
  archive.list("dsp_queue", dsp_queue_);
  std::vector<std::uint64_t> turn;
  if (in_turn_) turn.push_back(*in_turn_);
  archive.list("in_turn", turn, 1);
  archive.list("finished", finished_);
  if (!archive.loads()) return;
  under_way_.insert(issued.begin(), issued.end());
  if (!turn.empty()) in_turn_ = turn.front();
  std::vector<std::uint64_t> places = bus_.transfers(), ids;
  for (const TimeOf& waiting : dsp_queue_) places.push_back(waiting.id);
  places.insert(places.end(), turn.begin(), turn.end());
  for (const auto& [id, transaction] : under_way_) ids.push_back(id);
  std::ranges::sort(places);
  std::ranges::sort(ids);
  archive.expect(places == ids, "under_way", "each transaction in one place", places.size());
  // Single values are within their limits, but their sum decides how long the board works.
  std::uint64_t bytes = 0;
  Picoseconds span = 0;
  for (const auto& [id, each] : issued) {
    bytes += each.transaction.down_bytes + each.transaction.up_bytes;
    span += std::max(cycles_to_ps(each.transaction.dsp_cycles, dsp_khz_), each.transaction.asic_ps);
    archive.expect(bytes <= kMostBytes, "under_way", "at most " + std::to_string(kMostBytes) + " bytes", bytes);
    archive.expect(span <= kMostSpan, "under_way", "at most " + std::to_string(kMostSpan) + " ps", span);
  }
}

}  // namespace gicube::emu
