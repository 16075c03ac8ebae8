#include "sdram.h"

#include <algorithm>
#include <utility>

namespace gicube::emu::sdram {
namespace {

using enum Command;
using enum Scope;

std::vector<Constraint> all_constraints(const v1::SdramConfig& config) {
  const std::uint32_t cl = config.t_cl();
  return {{"tRAS", kActivate, kPrecharge, kBank, config.t_ras()},
          {"tRC", kActivate, kActivate, kBank, config.t_rc()},
          {"tRC", kActivate, kRefresh, kDevice, config.t_rc()},
          {"tRCD", kActivate, kRead, kBank, config.t_rcd()},
          {"tRCD", kActivate, kWrite, kBank, config.t_rcd()},
          {"tRP", kPrecharge, kActivate, kBank, config.t_rp()},
          {"tRP", kPrecharge, kRefresh, kDevice, config.t_rp()},
          {"tRRD", kActivate, kActivate, kDevice, config.t_rrd()},
          {"tRFC", kRefresh, kActivate, kDevice, config.t_rfc()},
          {"tRFC", kRefresh, kRefresh, kDevice, config.t_rfc()},
          {"BL", kRead, kPrecharge, kBank, kBurst},
          {"BL-1+tWR", kWrite, kPrecharge, kBank, kBurst - 1 + config.t_wr()},
          {"BL", kRead, kRead, kChannel, kBurst},
          {"BL", kWrite, kWrite, kChannel, kBurst},
          {"BL", kWrite, kRead, kDevice, kBurst},
          {"BL-CL", kWrite, kRead, kChannel, kBurst > cl ? kBurst - cl : 0},
          {"CL+BL+1", kRead, kWrite, kChannel, cl + kBurst + 1},  // a clock for the wires to change hands
          {"BL+switch", kRead, kRead, kOtherDevice, kBurst + kRankSwitch},
          {"BL+switch-CL", kWrite, kRead, kOtherDevice, kBurst + kRankSwitch > cl ? kBurst + kRankSwitch - cl : 0},
          {"CL", kRead, kData, kChannel, cl},
          {"0", kWrite, kData, kChannel, 0}};
}

}  // namespace

Timing::Timing(const v1::SdramConfig& config) : Timing(all_constraints(config)) {}

Timing::Timing(std::vector<Constraint> rows) : ConstraintTable("SDRAM", Rules::honoured, std::move(rows)) {}

}  // namespace gicube::emu::sdram
