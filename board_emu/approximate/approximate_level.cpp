#include "approximate/approximate_level.h"

#include <algorithm>

#include "approximate/traced_passes.h"
#include "levels/counters.h"

namespace gicube::emu {

// Passes know nothing of rays that wait for blocks.
bool ApproximateLevel::answers(const Frame& frame) const { return !frame.in_bricks() && PassMachine::covers(config_); }

PassMachine& ApproximateLevel::machine_for(const Frame& frame) {
  if (machine_ && machine_->blocks() != frame.volume->blocks()) drop_machines();
  if (!machine_) machine_ = std::make_unique<PassMachine>(config_, frame.volume->blocks());
  return *machine_;
}

RunResult ApproximateLevel::run(RaySource& source, const Frame& frame, Progress& progress) {
  if (!answers(frame)) return cycle_level_.run(source, frame, progress);
  PassMachine& machine = machine_for(frame);
  RunResult all;
  all.answered = v1::approximate;
  const std::uint64_t count = source.count(), at_once = source.max_at_once();
  const bool vectors = tracer_.prepare(count, frame, frame.segmentation_writes, threads_);
  std::uint64_t begin = 0;
  try {
    do {
      const std::uint64_t end = std::min(count, begin + at_once);
      TracedPasses passes(source, {begin, end}, frame, vectors ? &tracer_ : nullptr, threads_,
                          config_.cache().splat_rule());
      RunResult ran = machine.run(passes, frame, progress, threads_ > 1);
      ran.made = passes.made();
      ran.rays = passes.rays();
      add_run(all, ran, config_.asic().core_khz());
      begin = end;
    } while (begin < count && !all.cancelled);
  } catch (...) {
    drop_machines();  // rays are left in it
    throw;
  }
  rays_ += all.rays;
  if (all.cancelled) drop_machines();
  return all;
}

void ApproximateLevel::state(Archive& archive, const std::array<int, 3>& blocks) {
  archive.within("cycle", [&] { cycle_level_.state(archive, blocks); });
  archive("rays", rays_);
  std::vector<wire::Counter> past = past_;
  const bool is_old = machine_ && machine_->blocks() != blocks;  // it is dropped before the next run
  if (is_old) {
    std::vector<wire::Counter> list;
    machine_->count(list);
    add_counters(list, past);
  }
  counters_state(archive, "past", past);
  bool has_machine = machine_ != nullptr && !is_old;
  archive("has_machine", has_machine);
  if (archive.loads()) {
    past_ = past;
    archive.expect(!has_machine || (blocks[0] > 0 && PassMachine::covers(config_)), "has_machine", "0 here", 1);
    if (has_machine) machine_ = std::make_unique<PassMachine>(config_, blocks);
  }
  if (has_machine) archive("machine", *machine_);
}

void ApproximateLevel::volume_changed() {
  if (machine_) machine_->invalidate_caches();
  cycle_level_.volume_changed();
  tracer_.clear();
}

void ApproximateLevel::deposits_cleared() {
  if (machine_) machine_->invalidate_caches();
  cycle_level_.deposits_cleared();
}

void ApproximateLevel::reset() {
  drop_machines();
  tracer_.clear();
}

void ApproximateLevel::drop_machines() {
  cycle_level_.reset();
  if (!machine_) return;
  std::vector<wire::Counter> list;
  machine_->count(list);
  add_counters(list, past_);
  machine_.reset();
}

RayCounters ApproximateLevel::rays() const {
  RayCounters sum = rays_;
  sum += cycle_level_.rays();
  return sum;
}

void ApproximateLevel::count(std::vector<wire::Counter>& list) const {
  cycle_level_.count(list);
  std::vector<wire::Counter> mine;
  if (machine_) machine_->count(mine);
  add_counters(past_, mine);
  add_counters(mine, list);
}

}  // namespace gicube::emu
