#include "asic/ddr/channel.h"

#include <algorithm>
#include <utility>

namespace gicube::emu::ddr {
namespace {

using enum Command;
using enum Scope;

std::vector<Constraint> all_constraints(const v1::DdrConfig& config) {
  const std::uint32_t cl = config.t_cl(), written = kWriteLatency + kBurst;
  // Data on the wires keep a clock between read and written ones, and between those of two ranks.
  const auto apart = [](std::uint32_t first, std::uint32_t second, std::uint32_t gap) {
    return std::max(kBurst, first + kBurst + gap > second ? first + kBurst + gap - second : 0);
  };
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
          {"BL/2", kRead, kPrecharge, kBank, kBurst},
          {"WL+BL/2+tWR", kWrite, kPrecharge, kBank, written + config.t_wr()},
          {"WL+BL/2+tWTR", kWrite, kRead, kDevice, written + config.t_wtr()},
          {"tCCD", kRead, kRead, kChannel, kBurst},
          {"tCCD", kWrite, kWrite, kChannel, kBurst},
          {"CL+BL/2+1-WL", kRead, kWrite, kChannel, apart(cl, kWriteLatency, 1)},
          {"WL+BL/2-CL", kWrite, kRead, kChannel, apart(kWriteLatency, cl, 0)},
          {"BL/2+switch", kRead, kRead, kOtherDevice, kBurst + kRankSwitch},
          {"WL+BL/2+switch-CL", kWrite, kRead, kOtherDevice, apart(kWriteLatency, cl, kRankSwitch)},
          {"CL", kRead, kData, kChannel, cl},
          {"WL", kWrite, kData, kChannel, kWriteLatency}};
}

}  // namespace

Timing::Timing(const v1::DdrConfig& config) : Timing(all_constraints(config)) {}

Timing::Timing(std::vector<Constraint> rows) : ConstraintTable("DDR", Rules::honoured, std::move(rows)) {}

}  // namespace gicube::emu::ddr
