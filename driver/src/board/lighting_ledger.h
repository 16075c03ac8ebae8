// The board's accounts of a lighting pass and of backprojecting rays in the application's units.
#pragma once

#include "gicube/illumination.h"
#include "gicube/ray.h"
#include "gicube/wire/command.h"

namespace gicube {

// Adds energies in units of the words, each worth `report.unit` of the lights' power.
inline void add(const wire::LightingLedger& ledger, LightingReport& report) {
  report.rays += ledger.rays;
  report.emitted += static_cast<double>(ledger.emitted) * report.unit;
  report.deposited += static_cast<double>(ledger.deposited) * report.unit;
  report.escaped += static_cast<double>(ledger.escaped) * report.unit;
  report.scattered_away += static_cast<double>(ledger.scattered_away) * report.unit;
  report.given_up += static_cast<double>(ledger.given_up) * report.unit;
  report.clipped += static_cast<double>(ledger.clipped) * report.unit;
}

inline void add(const wire::DepositLedger& ledger, DepositReport& report) {
  report.rays += ledger.rays;
  report.samples += ledger.samples;
  report.kept += static_cast<double>(ledger.kept) * report.unit;
  report.clipped += static_cast<double>(ledger.clipped) * report.unit;
  report.overflowed += ledger.overflowed;
}

}  // namespace gicube
