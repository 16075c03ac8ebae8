// Where a board's energy goes, from what it counted and the simulated time: each event and each moment of a part has a
// price, a field of EnergyConfig with its source and its uncertainty.
//
// Only the cycle level counts what costs energy. It is computed when somebody asks, so the simulation does nothing for
// it.
#pragma once

#include <cstdint>
#include <memory>
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
};

class EnergyModel {
 public:
  // `config`: resolved and checked.
  explicit EnergyModel(const v1::BoardConfig& config);
  ~EnergyModel();
  EnergyModel(const EnergyModel&) = delete;
  EnergyModel& operator=(const EnergyModel&) = delete;

  // Since power-up, by part, in an order that stays. `counters`: the board's at the time `now`.
  std::vector<PartEnergy> parts(const std::vector<wire::Counter>& counters, Picoseconds now) const;

  // Appends energy.<part>, .low and .high, and their sums as energy.total, in picojoules. Nothing at the functional
  // level.
  void count(std::vector<wire::Counter>& counters, Picoseconds now) const;

 private:
  struct Prices;
  std::unique_ptr<const Prices> prices_;  // null at the functional level
};

}  // namespace gicube::emu
