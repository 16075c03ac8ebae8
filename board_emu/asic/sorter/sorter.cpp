#include "asic/sorter/sorter-inl.h"

#include <algorithm>
#include <ostream>

namespace gicube::emu {

Sorter::Sorter(const SorterSetup& setup, const SorterInputs& in, const SorterOutputs& out)
    : processor_(setup.processor),
      single_(setup.single),
      bus_waits_(setup.bus_waits),
      in_(in),
      out_(out),
      others_{&in.from_bus, &in.from_left, &in.from_right},
      queues_(setup.single ? 1 : setup.queues, setup.ideal_queues ? Queues::kUnlimited : setup.capacity, setup.policy) {
  if (setup.single || setup.ideal_sorter) {
    maximum_.emplace(queues_.count());
  } else {
    ranks_.emplace(queues_.count());
    dirty_.resize(queues_.count());
  }
}

[[gnu::noinline, gnu::cold]] void Sorter::report(Cycle now, RayStep step, const RayToken& token) const {
  listener_->report(
      {.step = step, .cycle = now, .handle = token.ray, .processor = processor_, .queue = queue_of(token)});
}

[[gnu::always_inline]] inline bool Sorter::take(Cycle now, Fifo<RayToken>& input, bool may_overflow,
                                                std::uint32_t& written) {
  const std::uint32_t queue = queue_of(input.front());
  if (input.front().has_reserved_slot || queues_.has_slot(queue)) {
    if (input.front().watched) [[unlikely]]
      report(now, RayStep::kQueued, input.front());
    write(queue, input.pop(now));
    written = queue;
    return true;
  }
  if (!may_overflow || !out_.overflow.can_push(now)) return false;
  RayToken token = input.pop(now);
  token.state = TokenStatus::kOverflowed;
  if (token.watched) [[unlikely]]
    report(now, RayStep::kOverflowed, token);
  out_.overflow.push(now, token);
  if (!bus_waits_) queues_.overflow(queue);
  ++counters_.overflows;
  return true;
}

// After the overflows of the cycle: these hold a FIFO up.
inline bool Sorter::report_slot(Cycle now) {
  if (reserved_.empty() || !out_.overflow.can_push(now)) return false;
  RayToken token;
  token.processor = processor_;
  token.queue = reserved_.front();
  token.state = TokenStatus::kSlot;
  out_.overflow.push(now, token);
  reserved_.pop_front();
  ++counters_.reserved_slots;
  return true;
}

// Most cycles need only this function: helpers with a single caller are inline.
bool Sorter::work(Cycle now, bool others_come) {
  if (ranks_) ranks_->step();
  bool moved = false;
  if (in_.released.can_pop(now)) {
    const std::uint32_t queue = single_ ? 0 : in_.released.front();
    in_.released.pop(now);
    if (queues_.release_slot(queue)) reserved_.push_back(queue);
    moved = true;
  }
  if (active_ == kNone && queues_.waiting() > 0) choose_active();
  if (active_ != kNone && out_.issue.can_push(now)) {
    out_.issue.push(now, queues_.read(active_));
    if (out_.issue.back().watched) [[unlikely]]
      report(now, RayStep::kIssued, out_.issue.back());
    ++counters_.issued;
    ++issued_since_active_;
    moved = true;
  }
  std::uint32_t written = kNone;
  const bool returned = in_.returned.can_pop(now) && take(now, in_.returned, true, written);
  moved |= returned;
  if (others_come) moved |= accept_others(now, returned ? 1 : 2, written);
  moved |= report_slot(now);
  if (ranks_) return update_ranks() || moved;
  if (active_ != kNone && queues_.waiting(active_) == 0) {
    maximum_->set(active_, 0);
    give_up_active();
  }
  return moved;
}

bool Sorter::accept_others(Cycle now, std::uint32_t turns, std::uint32_t written) {
  bool moved = false;
  std::uint32_t input = turn_;
  for (std::uint32_t tried = 0; tried < others_.size() && turns > 0; ++tried) {
    Fifo<RayToken>& fifo = *others_[input];
    const std::uint32_t next = input == 2 ? 0 : input + 1;
    if (fifo.can_pop(now)) {
      if (queue_of(fifo.front()) == written && (fifo.front().has_reserved_slot || queues_.has_slot(written))) {
        ++counters_.conflicts;
        turn_ = input;  // the input that lost its turn is first in the next cycle
        break;
      }
      if (take(now, fifo, input != 0 || !bus_waits_, written)) {
        moved = true;
        --turns;
        turn_ = next;
      }
    }
    input = next;
  }
  return moved;
}

void Queues::state(Archive& archive) {
  archive("openings", openings_);
  std::vector<std::uint32_t> used;
  for (std::uint32_t queue = 0; queue < states_.size(); ++queue) {
    if (states_[queue].slots != 0 || states_[queue].overflowed != 0) used.push_back(queue);
  }
  archive.list("used", used, states_.size());
  for (const std::uint32_t queue : used) {
    const bool is_new = queue < states_.size() && (!archive.loads() || states_[queue].slots == 0);
    archive.expect(is_new, "used", "numbers of queues, each once", queue);
    State& state = states_[queue];
    std::vector<RayToken> rays;
    std::uint32_t at = state.head;
    for (std::uint32_t i = 0; !archive.loads() && i < state.waiting; ++i, at = records_[at].next) {
      rays.push_back(records_[at].token);
    }
    archive.field("queue" + std::to_string(queue), [&](Archive::Record& record) {
      record(state.slots, state.overflowed, state.opened);
      record.list(rays, capacity_);
    });
    if (!archive.loads()) continue;
    for (const RayToken& token : rays) {
      const std::uint32_t record = grow();
      records_[record].token = token;
      (state.waiting++ == 0 ? state.head : records_[state.tail].next) = record;
      state.tail = record;
      state.contribution += weight(token);
      ++waiting_;
    }
  }
}

void Sorter::state(Archive& archive) {
  archive.expect_idle(idle() && queues_.all_free() && active_ == kNone, "a sorter");
  archive.at_most("turn", turn_, 2);
  archive.at_most("latest_active", latest_active_, queues_.count() - 1);
  archive("issued_since_active", issued_since_active_);
  archive("counters", counters_);
  if (archive.in_run()) {
    archive("queues", queues_);
    archive("active", active_);
    const bool has_rays = active_ == kNone || (active_ < queues_.count() && queues_.waiting(active_) > 0);
    archive.expect(has_rays, "active", "a queue with rays", active_);
    archive.list("kept", reserved_);
    for (const std::uint32_t queue : reserved_)
      archive.expect(queue < queues_.count(), "kept", "numbers of queues", queue);
  }
  if (maximum_) {
    archive.expect_idle(maximum_->importance() == 0, "a sorter");
    for (std::uint32_t queue = 0; archive.loads() && queue < queues_.count(); ++queue) {
      maximum_->set(queue, queues_.importance(queue));
    }
    return;
  }
  archive("ranks", *ranks_);
  archive.expect(active_ == kNone || ranks_->top() == active_, "ranks", "the active queue at the top", active_);
  for (std::uint32_t queue = 0; queue < queues_.count(); ++queue) {
    archive.expect(!ranks_->has(queue) || queues_.waiting(queue) > 0, "ranks", "items of queues with rays", queue);
  }
  std::vector<std::uint32_t> changed;  // in the order of their list
  for (std::uint32_t queue = dirty_head_; queue != kNone; queue = dirty_[queue].next) changed.push_back(queue);
  archive.list("changed", changed, queues_.count());
  if (!archive.loads()) return;
  for (const std::uint32_t queue : changed) {
    const bool is_new =
        queue < queues_.count() && dirty_[queue].next == kUnlisted && queues_.waiting(queue) > 0 && queue != active_;
    archive.expect(is_new, "changed", "queues with rays, each once", queue);
    list_dirty(queue);
  }
}

void Sorter::dump(std::ostream& out) const {
  out << "sorter: " << queues_.waiting() << " rays wait in queues";
  if (has_active()) {
    out << "; queue " << active_ << " is active with " << queues_.waiting(active_) << " rays waiting and "
        << queues_.slots_taken(active_) << " slots taken";
  }
  out << "\nsorter inputs: " << in_.returned.size() << " returned, " << in_.from_bus.size() << " from bus, "
      << in_.from_left.size() << " from left, " << in_.from_right.size()
      << " from right; outputs: " << out_.issue.size() << " to issue, " << out_.overflow.size() << " overflowed\n";
}

}  // namespace gicube::emu
