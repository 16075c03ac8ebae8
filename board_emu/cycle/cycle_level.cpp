#include "cycle/cycle_level.h"

#include <algorithm>

#include "cycle/machine_counters.h"
#include "levels/counters.h"
#include "memory/sum_memory.h"

namespace gicube::emu {

Machine& CycleLevel::machine_for(const Frame& frame) {
  if (machine_ && machine_->blocks() != frame.volume->blocks()) reset();
  if (!machine_) {
    machine_ = std::make_unique<Machine>(config_, frame.volume->blocks());
    machine_->set_observer(observer_);
  }
  const bool sums = frame.sums != nullptr;
  if (caches_sums_ != sums) machine_->invalidate_caches();
  caches_sums_ = sums;
  return *machine_;
}

RunResult CycleLevel::run(RaySource& source, const Frame& frame, Progress& progress) {
  Machine& machine = machine_for(frame);
  if (frame.sums != nullptr) frame.sums->moved_anywhere(frame.max_moved);
  const RayCounters before = ray_counters(machine);
  RunResult all;
  all.answered = v1::cycle;
  try {
    const std::uint64_t count = source.count(), at_once = source.max_at_once();
    std::uint64_t begin = 0;
    do {
      const std::uint64_t end = std::min(count, begin + at_once);
      const RunResult ran = machine.run(source, frame, progress, {begin, end});
      add_run(all, ran, config_.asic().core_khz());
      begin = end;
    } while (begin < count && !all.cancelled);
  } catch (...) {
    reset();  // rays are left in it
    throw;
  }
  past_rays_ += all.rays;
  all.rays += ray_counters(machine) - before;
  if (all.cancelled) reset();
  return all;
}

void CycleLevel::volume_changed() {
  if (machine_) machine_->invalidate_caches();
}

void CycleLevel::deposits_cleared() {
  if (machine_) machine_->invalidate_caches();
}

void CycleLevel::reset() {
  if (!machine_) return;
  past_rays_ += ray_counters(*machine_);
  std::vector<wire::Counter> list;
  emu::count(*machine_, list);
  add_counters(list, past_);
  machine_.reset();
}

RayCounters CycleLevel::rays() const {
  RayCounters sum = past_rays_;
  if (machine_) sum += ray_counters(*machine_);
  return sum;
}

void CycleLevel::count(std::vector<wire::Counter>& list) const {
  std::vector<wire::Counter> mine;
  if (machine_) emu::count(*machine_, mine);
  add_counters(past_, mine);
  add_counters(mine, list);
}

// A machine of another volume's size is dropped before the next run, so it is not in the file.
void CycleLevel::state(Archive& archive, const std::array<int, 3>& blocks) {
  if (machine_ && machine_->blocks() != blocks) reset();
  archive("past_rays", past_rays_);
  counters_state(archive, "past", past_);
  archive("caches_sums", caches_sums_);
  bool has_machine = machine_ != nullptr;
  archive("has_machine", has_machine);
  if (!has_machine) return;
  if (archive.loads()) {
    archive.expect(blocks[0] > 0, "has_machine", "0 without a volume", 1);
    machine_ = std::make_unique<Machine>(config_, blocks);
    machine_->set_observer(observer_);
  }
  archive("machine", *machine_);
}

MachineLook CycleLevel::look() const { return machine_ ? emu::look(*machine_) : MachineLook(); }

}  // namespace gicube::emu
