// The cycle level: a machine for the volume's size, and the state that is kept when another machine replaces it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "asic/sorter/policies.h"
#include "cycle/machine.h"
#include "datapath/opacity_correction.h"
#include "functional/functional_trace.h"
#include "functional/simd/simd_tracer.h"
#include "levels/level.h"

namespace gicube::emu {

class CycleLevel : public Level {
 public:
  // `observer`: of every machine; null: none. Both must outlive this. Values of rays are computed on `threads` threads.
  CycleLevel(const v1::BoardConfig& config, Observer* observer, unsigned threads)
      : config_(config), observer_(observer), threads_(threads) {}

  // Progress is in rays that have returned.
  RunResult run(RaySource& rays, const Frame& frame, Progress& progress) override;

  void volume_changed() override;
  void deposits_cleared() override;
  // The next run starts with a new machine.
  void reset() override;
  RayCounters rays() const override;
  void count(std::vector<wire::Counter>& list) const override;
  std::uint64_t cycles_ahead() const override { return past_cycles_ahead_ + (machine_ ? machine_->cycles_ahead() : 0); }
  MachineLook look() const override;
  bool in_run() const override { return run_.has_value(); }
  void state(Archive& archive, const std::array<int, 3>& blocks) override;

 private:
  // A run that is under way.
  struct Run {
    RaySource* source = nullptr;  // null: restored from a checkpoint, and not yet continued
    std::uint64_t begin = 0;      // first of the rays that the machine is tracing
    RunResult all;                // result of the rays before these
    RayCounters before;           // the machine's counters at the start

    void state(Archive::Record& record) {
      record(begin);
      record.at_most(all.cycles, kMostCycles);
      record.at_most(all.asic_ps, cycles_to_ps(kMostCycles, 1000));
      record.at_most(all.dsp_cycles, kMostCycles);
      record(all.made, all.rays, before);
    }
  };

  Machine& machine_for(const Frame& frame);
  Machine& machine_to_go_on(RaySource& source, const Frame& frame);

  // Whether neither the policy nor an observer reads the words of rays.
  bool may_compute_ahead(const Machine& machine) const {
    return !machine.has_interested_observer() && !reads_contribution(config_.sorter().policy());
  }

  const v1::BoardConfig& config_;
  Observer* observer_;
  unsigned threads_;
  OpacityCorrection correction_;
  SimdTracer tracer_{correction_};
  std::unique_ptr<Machine> machine_;  // kept while the volume keeps its size
  bool caches_accumulators_ = false;  // its caches hold accumulators instead of voxels
  std::optional<Run> run_;
  std::vector<std::uint64_t> of_source_;  // source's state in a checkpoint's run
  RayCounters past_rays_;                 // rays of dropped machines, and of sources
  std::vector<wire::Counter> past_;       // counters of machines that were dropped
  std::uint64_t past_cycles_ahead_ = 0;   // cycles of dropped machines
};

}  // namespace gicube::emu
