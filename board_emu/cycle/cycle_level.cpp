#include "cycle/cycle_level.h"

#include <algorithm>

#include "cycle/machine_counters.h"
#include "datapath/interaction.h"
#include "levels/counters.h"
#include "words/scope_exit.h"

namespace gicube::emu {

Machine& CycleLevel::machine_for(const Frame& frame) {
  if (machine_ && machine_->blocks() != frame.volume->blocks()) reset();
  if (!machine_) {
    machine_ = std::make_unique<Machine>(config_, frame.volume->blocks());
    machine_->set_observer(observer_);
  }
  const bool accumulates = frame.accumulators != nullptr;
  if (caches_accumulators_ != accumulates) machine_->invalidate_caches();
  caches_accumulators_ = accumulates;
  return *machine_;
}

Machine& CycleLevel::machine_to_go_on(RaySource& source, const Frame& frame) {
  const bool fits =
      machine_->blocks() == frame.volume->blocks() && caches_accumulators_ == (frame.accumulators != nullptr);
  if (!fits) throw CheckpointFault("run", "the run of the same command", "another run");
  NumbersArchive archive(true, of_source_);
  archive.field("source", [&](Archive::Record& record) { source.state(record, run_->begin); });
  of_source_.clear();
  return *machine_;
}

RunResult CycleLevel::run(RaySource& source, const Frame& frame, Progress& progress) {
  const ScopeExit over{[this] { run_.reset(); }};
  bool goes_on = run_.has_value();
  try {
    Machine& machine = goes_on ? machine_to_go_on(source, frame) : machine_for(frame);
    if (!goes_on) {
      expect_deposits(frame);
      run_.emplace(Run{}).before = ray_counters(machine);
    }
    run_->source = &source;
    RunResult& all = run_->all;
    all.answered = v1::cycle;
    const std::uint64_t count = source.count(), at_once = source.max_at_once();
    const bool vectors = may_compute_ahead(machine) && !frame.in_bricks() &&
                         tracer_.prepare(count, frame, frame.segmentation_writes, threads_);
    const SimdTracer* const tracer = vectors ? &tracer_ : nullptr;
    const bool can_be_ahead = FunctionalTrace::covers(frame, tracer);
    do {
      const RayRange which{run_->begin, std::min(count, run_->begin + at_once)};
      std::optional<FunctionalTrace> values;
      if (can_be_ahead && !goes_on && may_compute_ahead(machine))
        values.emplace(source, which, frame, tracer, threads_);
      const RunResult ran = goes_on ? machine.go_on(source, frame, progress, which)
                                    : machine.run(source, frame, progress, which, values ? &*values : nullptr);
      goes_on = false;
      add_run(all, ran, config_.asic().core_khz());
      run_->begin = which.end;
    } while (run_->begin < count && !all.cancelled);
    past_rays_ += all.rays;
    all.rays += ray_counters(machine) - run_->before;
    if (all.cancelled) reset();
    return all;
  } catch (...) {
    reset();  // rays are left in the machine
    throw;
  }
}

void CycleLevel::volume_changed() {
  tracer_.clear();
  if (machine_) machine_->invalidate_caches();
}

void CycleLevel::deposits_cleared() {
  if (machine_) machine_->invalidate_caches();
}

void CycleLevel::reset() {
  tracer_.clear();
  if (run_ && run_->source == nullptr) run_.reset();
  if (!machine_) return;
  past_rays_ += ray_counters(*machine_);
  std::vector<wire::Counter> list;
  emu::count(*machine_, list);
  add_counters(list, past_);
  past_cycles_ahead_ += machine_->cycles_ahead();
  if (observer_ != nullptr) observer_->removed(*machine_);
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

// A machine for another volume size would be dropped before the next run, so it is not saved.
void CycleLevel::state(Archive& archive, const std::array<int, 3>& blocks) {
  if (machine_ && machine_->blocks() != blocks) reset();
  archive("past_rays", past_rays_);
  counters_state(archive, "past", past_);
  archive("caches_sums", caches_accumulators_);
  bool has_machine = machine_ != nullptr, is_in_run = in_run();
  archive("has_machine", has_machine);
  archive("in_run", is_in_run);
  archive.expect(has_machine || !is_in_run, "in_run", "0 without a machine", 1);
  if (!has_machine) return;
  if (archive.loads()) {
    archive.expect(blocks[0] > 0, "has_machine", "0 without a volume", 1);
    machine_ = std::make_unique<Machine>(config_, blocks);
    machine_->set_observer(observer_);
  }
  archive.set_in_run(is_in_run);
  archive("machine", *machine_);
  archive.set_in_run(false);
  if (!is_in_run) return;
  if (archive.loads()) run_.emplace(Run{});
  archive("run", *run_);
  if (RaySource* const source = run_->source; source != nullptr) {
    NumbersArchive numbers(false, of_source_);
    numbers.field("source", [&](Archive::Record& record) { source->state(record, run_->begin); });
  }
  archive.numbers("source", of_source_);
}

MachineLook CycleLevel::look() const { return machine_ ? emu::look(*machine_) : MachineLook(); }

}  // namespace gicube::emu
