// The cycle level for some commands, drawn at random, and the functional level for the others, whose time and traffic are estimated
// from those (sampled_series.h). Values are those of every level.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "cycle/cycle_level.h"
#include "functional/functional_level.h"
#include "levels/level.h"
#include "sampled/sampled_series.h"

namespace gicube::emu {

class SampledLevel : public Level {
 public:
  // `config` has its sample_error. `observer`: of the cycle level's machines; null for none. Both must outlive this.
  SampledLevel(const v1::BoardConfig& config, Observer* observer, unsigned threads)
      : config_(config), cycle_(config, observer, threads), functional_(threads) {}

  RunResult run(RaySource& rays, const Frame& frame, Progress& progress) override;

  void volume_changed() override;
  void deposits_cleared() override { cycle_.deposits_cleared(); }
  void reset() override;
  RayCounters rays() const override;
  // Those of the cycle level have what was estimated in them.
  void count(std::vector<wire::Counter>& list) const override;
  std::uint64_t cycles_ahead() const override { return cycle_.cycles_ahead(); }
  MachineLook look() const override { return cycle_.look(); }
  bool in_run() const override { return cycle_.in_run(); }
  void state(Archive& archive, const std::array<int, 3>& blocks) override;

 private:
  // Commands of one kind of rays, about as many each.
  struct Kind {
    std::uint64_t rays = 0;
    SampledSeries series;

    void state(Archive& archive) { series.state(archive); }
  };
  struct Totals {
    std::uint64_t commands = 0, estimated = 0;
    SampledQuantities took{};    // estimated
    SampledQuantities within{};  // of kinds that were dropped

    void state(Archive::Record& record) { record(commands, estimated, took, within); }
  };

  SampledSeries& series_of(std::uint64_t rays);
  RunResult simulate(SampledSeries& series, RaySource& rays, const Frame& frame, Progress& progress);
  RunResult estimate(SampledSeries& series, RaySource& rays, const Frame& frame, Progress& progress);
  SampledQuantities within() const;

  const v1::BoardConfig& config_;
  CycleLevel cycle_;
  FunctionalLevel functional_;
  std::deque<Kind> kinds_;
  std::vector<wire::Counter> before_;     // the cycle level's, when its command began
  std::vector<wire::Counter> estimated_;  // by how much they would have grown
  Totals totals_;
};

}  // namespace gicube::emu
