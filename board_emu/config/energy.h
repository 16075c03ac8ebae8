// Where a board's energy goes, from what it counted and the simulated time: each event and each moment of a part has a
// price, a field of EnergyConfig with its source and its uncertainty.
//
// Only the cycle level counts what costs energy. It is computed when somebody asks, so the simulation does nothing for
// it.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/counter_list.h"
#include "words/clock.h"

namespace gicube::emu {

// The energy of one part of the card. `low` and `high` are what it took if all its prices are wrong in one direction by
// their uncertainty.
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

  // Since power-up, by part, in an order that stays. `counters`: the board's at the time `now`.
  std::vector<PartEnergy> parts(const std::vector<wire::Counter>& counters, Picoseconds now) const;
  // While a command runs: in the time of `asic.cycles`, with the DSP's work for the ASIC and without the host bus. All
  // samples count as visible, since values are computed ahead.
  std::vector<PartEnergy> of_machine(const std::vector<wire::Counter>& counters) const;
  // The DSP in `time` with work in `busy` of it, and bytes on the host bus; 0 at the functional level.
  std::uint64_t dsp_pj(Picoseconds busy, Picoseconds time) const;
  std::uint64_t host_bus_pj(std::uint64_t bytes) const;

  // Appends energy.<part>, .low and .high, and their sums as energy.total, in picojoules. Nothing at the functional
  // level.
  void count(std::vector<wire::Counter>& counters, Picoseconds now) const;

 private:
  struct Prices;
  class Values;

  // Made when they are first needed; null at the functional level.
  const Prices* prices() const;
  std::vector<PartEnergy> parts_of(const Values& counted, Picoseconds now) const;

  const v1::BoardConfig& config_;
  mutable std::once_flag priced_;
  mutable std::unique_ptr<const Prices> prices_;
};

}  // namespace gicube::emu
