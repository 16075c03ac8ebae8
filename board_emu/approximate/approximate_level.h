// The approximate level: values as the functional level, time by the passes that rays take through the pipeline
// (pass_machine.h). It answers on boards that PassMachine::covers(); all else it hands to a cycle level.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "approximate/pass_machine.h"
#include "cycle/cycle_level.h"
#include "functional/simd/simd_tracer.h"
#include "levels/level.h"

namespace gicube::emu {

class ApproximateLevel : public Level {
 public:
  // `observer`: of the cycle level's machines; null for none. Both must outlive this.
  ApproximateLevel(const v1::BoardConfig& config, Observer* observer, unsigned threads)
      : config_(config), threads_(threads), cycle_level_(config, observer, threads) {}

  // Progress is in rays that came back.
  RunResult run(RaySource& rays, const Frame& frame, Progress& progress) override;

  void volume_changed() override;
  void deposits_cleared() override;
  void reset() override;
  RayCounters rays() const override;
  void count(std::vector<wire::Counter>& list) const override;
  std::uint64_t cycles_ahead() const override { return cycle_level_.cycles_ahead(); }
  MachineLook look() const override { return cycle_level_.look(); }
  bool in_run() const override { return cycle_level_.in_run(); }
  void state(Archive& archive, const std::array<int, 3>& blocks) override;

 private:
  bool answers(const Frame& frame) const;
  PassMachine& machine_for(const Frame& frame);
  void drop_machines();

  const v1::BoardConfig& config_;
  unsigned threads_;
  CycleLevel cycle_level_;
  OpacityCorrection correction_;
  SimdTracer tracer_{correction_};
  std::unique_ptr<PassMachine> machine_;  // as long as the volume keeps its size
  RayCounters rays_;                      // of its runs
  std::vector<wire::Counter> past_;       // counters of machines that were dropped
};

}  // namespace gicube::emu
