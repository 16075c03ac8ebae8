// Computes a board's energy from its counters and the simulated time. Each event costs an energy and each part a power:
// fields of EnergyConfig, with their sources and uncertainties.
//
// Only the cycle level has the counters. The energy is computed on request, so it costs the simulation nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/counter_list.h"
#include "words/clock.h"

namespace gicube::emu {

// The energy of one part of the card. `low` and `high` are the results if all prices are wrong by their uncertainty, in
// one direction.
struct PartEnergy {
  const char* part = "";
  std::uint64_t pj = 0, low_pj = 0, high_pj = 0;

  PartEnergy& operator+=(const PartEnergy& other) {
    pj += other.pj, low_pj += other.low_pj, high_pj += other.high_pj;
    return *this;
  }
};

class EnergyModel {
 public:
  // `config`: resolved and checked; it must outlive this.
  explicit EnergyModel(const v1::BoardConfig& config);
  ~EnergyModel();
  EnergyModel(const EnergyModel&) = delete;
  EnergyModel& operator=(const EnergyModel&) = delete;

  // Energy since power-up by part, always in the same order; empty at the functional level. `counters`: those of the
  // board at the time `now`.
  std::vector<PartEnergy> parts(const std::vector<wire::Counter>& counters, Picoseconds now) const;
  // Energy by part while a command runs: for the time of `asic.cycles`, with the DSP's work for the ASIC, without the
  // host bus. All samples count as visible, because their values are computed ahead of the clock.
  std::vector<PartEnergy> of_machine(const std::vector<wire::Counter>& counters) const;
  // Energy of the DSP in `time`, of which it works for `busy`, and of bytes on the host bus; 0 at the functional level.
  std::uint64_t dsp_pj(Picoseconds busy, Picoseconds time) const;
  std::uint64_t host_bus_pj(std::uint64_t bytes) const;

  // Appends energy.<part>, .low and .high, and their sums as energy.total, in picojoules. Appends nothing at the
  // functional level.
  void count(std::vector<wire::Counter>& counters, Picoseconds now) const;

 private:
  struct Prices;
  class Values;

  // Computed at the first call; null at the functional level.
  const Prices* prices() const;
  std::vector<PartEnergy> parts_of(const Values& counted, Picoseconds now) const;

  const v1::BoardConfig& config_;
  mutable std::once_flag priced_;
  mutable std::unique_ptr<const Prices> prices_;
};

}  // namespace gicube::emu
