#include "asic/raybus/ray_bus.h"

#include <algorithm>
#include <cassert>
#include <ostream>

namespace gicube::emu {

RunPool::Run RunPool::add(std::span<const RayToken> rays) {
  assert(!rays.empty());
  if (free_.empty()) {
    free_.push_back(static_cast<Run>(runs_.size()));
    runs_.emplace_back();
  }
  const Run run = free_.back();
  free_.pop_back();
  runs_[run].rays.assign(rays.begin(), rays.end());
  runs_[run].holders = listeners_;
  return run;
}

void RunPool::release(Run run) {
  assert(runs_[run].holders > 0);
  if (--runs_[run].holders == 0) free_.push_back(run);
}

void RunPool::state(Archive& archive) {
  archive.field("runs", [this](Archive::Record& record) {
    std::uint64_t count = runs_.size();
    record.at_most(count, 0xFFFF);  // chosen: far above what FIFO and buffers hold
    runs_.resize(static_cast<std::size_t>(count));
    for (Entry& entry : runs_) {
      record.at_most(entry.holders, listeners_);
      if (entry.holders > 0) record.list(entry.rays, ~std::uint64_t{0});
    }
  });
  archive.list("free", free_, runs_.size());
  std::vector<bool> seen(runs_.size());
  for (const Run run : free_) {
    archive.expect(run < runs_.size() && runs_[run].holders == 0 && !seen[run], "free", "unused runs, each once", run);
    seen[run] = true;
  }
}

RayBus::RayBus(Fifo<RayToken>& down, Fifo<RunPool::Run>& runs, RunPool& pool,
               const std::vector<Fifo<RayToken>*>& to_processors)
    : down_(down), runs_(runs), pool_(pool), listeners_(to_processors.size()) {
  for (std::size_t i = 0; i < listeners_.size(); ++i) listeners_[i].fifo = to_processors[i];
}

bool RayBus::tick(Cycle now) {
  if (down_.empty() && runs_.empty() && idle()) return false;
  bool moved = send(now);
  if (extrapolating_ > 0) {
    for (std::size_t i = 0; i < listeners_.size(); ++i) moved |= extrapolate(now, static_cast<std::uint8_t>(i));
  }
  if (sent_run_) take_in_run();
  return moved;
}

// Sends one packet.
bool RayBus::send(Cycle now) {
  if (sending_) {  // the second packet of a run
    sending_ = false;
    sent_run_ = true;
    ++counters_.busy;
    return true;
  }
  const bool ray = down_.can_pop(now);
  const bool run = runs_.can_pop(now);
  const bool ray_goes = ray && ray_can_go(now);
  const bool run_goes = run && run_can_go();
  if (run_goes && (run_next_ || !ray_goes)) {
    run_ = runs_.pop(now);
    sending_ = true;
    run_next_ = false;
    ++counters_.runs;
  } else if (ray_goes) {
    const RayToken token = down_.pop(now);
    Listener& owner = listeners_[token.processor];
    owner.fifo->push(now, token);
    owner.run_had_turn = false;
    run_next_ = true;
    ++counters_.rays;
  } else {
    if (ray || run) ++counters_.waits;
    return false;
  }
  ++counters_.busy;
  return true;
}

bool RayBus::ray_can_go(Cycle now) const {
  const Listener& owner = listeners_[down_.front().processor];
  const bool other_has_turn = owner.count > 0 && !owner.run_had_turn;
  return !other_has_turn && owner.fifo->can_push(now);
}

bool RayBus::run_can_go() const {
  return std::all_of(listeners_.begin(), listeners_.end(), [](const Listener& l) { return l.count < kRunBuffers; });
}

// Called at the end of the second packet's cycle. Processors without a ray in the run drop it at once.
void RayBus::take_in_run() {
  sent_run_ = false;
  for (std::size_t i = 0; i < listeners_.size(); ++i) {
    const std::uint32_t first = next_own(run_, 0, static_cast<std::uint8_t>(i));
    if (first == pool_.rays(run_).size()) {
      pool_.release(run_);
      continue;
    }
    listeners_[i].runs[listeners_[i].count++] = {run_, first};
    ++extrapolating_;
  }
}

bool RayBus::extrapolate(Cycle now, std::uint8_t processor) {
  Listener& listener = listeners_[processor];
  if (listener.count == 0 || !listener.fifo->can_push(now)) return false;
  Buffered& oldest = listener.runs.front();
  const std::span<const RayToken> rays = pool_.rays(oldest.run);
  listener.fifo->push(now, rays[oldest.next]);
  listener.run_had_turn = true;
  ++counters_.run_rays;
  oldest.next = next_own(oldest.run, oldest.next + 1, processor);
  if (oldest.next == rays.size()) {
    pool_.release(oldest.run);
    std::shift_left(listener.runs.begin(), listener.runs.end(), 1);
    --listener.count;
    --extrapolating_;
  }
  return true;
}

std::uint32_t RayBus::next_own(RunPool::Run run, std::uint32_t from, std::uint8_t processor) const {
  const std::span<const RayToken> rays = pool_.rays(run);
  while (from < rays.size() && rays[from].processor != processor) ++from;
  return from;
}

std::vector<std::uint32_t> RunPool::holders() const {
  std::vector<std::uint32_t> out;
  for (const Entry& entry : runs_) out.push_back(entry.holders);
  return out;
}

// Called at the end of a cycle, when no run has just arrived.
void RayBus::runs_state(Archive& archive) {
  std::vector<std::uint32_t> holders = pool_.holders();
  bool fits = true;
  const auto uses = [&](RunPool::Run run, std::size_t listeners) {
    fits = fits && run < holders.size() && holders[run] >= listeners;
    if (fits) holders[run] -= static_cast<std::uint32_t>(listeners);
    return fits;
  };
  archive.field("runs", [&](Archive::Record& record) {
    record(sending_);
    if (sending_) record(run_);
    if (sending_) uses(run_, listeners_.size());
    for (std::size_t i = 0; i < runs_.size(); ++i) uses(runs_[i], listeners_.size());
    extrapolating_ = 0;
    for (std::size_t i = 0; i < listeners_.size(); ++i) {
      Listener& listener = listeners_[i];
      record.at_most(listener.count, kRunBuffers);
      extrapolating_ += listener.count;
      for (std::size_t k = 0; k < listener.count; ++k) {
        Buffered& run = listener.runs[k];
        record(run.run, run.next);
        if (!uses(run.run, 1)) continue;
        const std::span<const RayToken> rays = pool_.rays(run.run);
        fits = run.next < rays.size() && rays[run.next].processor == i;
      }
    }
    fits = fits && std::ranges::all_of(holders, [](std::uint32_t left) { return left == 0; });
    record.expect(fits, "all runs of the pool", pool_.in_use());
  });
}

void RayBus::dump(std::ostream& out) const {
  out << "ray bus: " << down_.size() << " rays and " << runs_.size() << " runs wait";
  if (!down_.empty()) out << "; the first ray is for processor " << int{down_.front().processor};
  for (std::size_t i = 0; i < listeners_.size(); ++i) {
    out << "\n  processor " << i << ": " << listeners_[i].fifo->size() << " rays, " << listeners_[i].count << " runs";
  }
  out << '\n';
}

}  // namespace gicube::emu
