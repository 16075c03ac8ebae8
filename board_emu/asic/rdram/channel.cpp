#include "asic/rdram/channel.h"

#include <algorithm>
#include <utility>

namespace gicube::emu::rdram {
namespace {

using enum Command;
using enum Scope;

std::vector<Constraint> row_constraints(const v1::RdramConfig& config) {
  std::vector<Constraint> rows;
  for (const Command opens : {kActivate, kRefresh}) {
    rows.push_back({"tRAS", opens, kPrecharge, kBank, config.t_ras()});
    rows.push_back({"tRP", kPrecharge, opens, kBank, config.t_rp()});
    // Neighbours share sense amps, which must be precharged before either bank uses them.
    rows.push_back({"tRP", kPrecharge, opens, kNeighbour, config.t_rp()});
    for (const Command again : {kActivate, kRefresh}) {
      rows.push_back({"tRC", opens, again, kBank, config.t_ras() + config.t_rp()});
      rows.push_back({"tRR", opens, again, kDevice, config.t_rr()});
    }
  }
  rows.push_back({"tPP", kPrecharge, kPrecharge, kDevice, config.t_pp()});
  for (const Command from : {kActivate, kPrecharge, kRefresh}) {
    for (const Command to : {kActivate, kPrecharge, kRefresh}) {
      rows.push_back({"tPACK", from, to, kChannel, kPacket});
    }
  }
  return rows;
}

std::vector<Constraint> column_constraints(const v1::RdramConfig& config) {
  const std::uint32_t cac = config.t_cac(), cwd = config.t_cwd(), retire = config.t_rtr();
  // The delay from packet to data differs between reads and writes; data may not overlap on DQ.
  const std::uint32_t read_write = kPacket + (cac > cwd ? cac - cwd : 0);
  const std::uint32_t write_read = kPacket + (cwd > cac ? cwd - cac : 0);
  return {{"tRCD", kActivate, kRead, kBank, config.t_rcd()},
          {"tRCD", kActivate, kWrite, kBank, config.t_rcd()},
          {"tOFFP", kRead, kPrecharge, kBank, config.t_offp()},
          // Written data reach the bank only when the write buffer is retired.
          {"tRTR+tOFFP", kWrite, kPrecharge, kBank, retire + config.t_offp()},
          {"tRTR+tPACK", kWrite, kRead, kDevice, retire + kPacket},
          {"tPACK", kRead, kRead, kChannel, kPacket},
          {"tPACK", kWrite, kWrite, kChannel, kPacket},
          {"tPACK+tCAC-tCWD", kRead, kWrite, kChannel, read_write},
          {"tPACK", kWrite, kRead, kChannel, write_read},
          {"tPACK+tCAC", kRead, kData, kChannel, kPacket + cac},
          {"tPACK+tCWD", kWrite, kData, kChannel, kPacket + cwd}};
}

}  // namespace

dram::ConstraintTable timing(const v1::RdramConfig& config) {
  std::vector<Constraint> rows = row_constraints(config);
  for (Constraint& row : column_constraints(config)) rows.push_back(std::move(row));
  return {Rules::kName, Rules::enforced, std::move(rows)};
}

Channel::Channel(const v1::RdramConfig& config, std::uint32_t devices)
    : dram::Channel<Channel, Rules>(timing(config), devices, config.refresh_interval()),
      recovery_(config.t_ras() + config.t_rp()),
      refresh_gap_(config.t_rr()),
      refreshed_open_(config.t_ras()) {}

bool Channel::held_by_refresh(const Location& at, Tcycle arrival) const {
  if (last_open_was_refresh_ && arrival < last_open_ + refresh_gap_) return true;
  const std::uint32_t same_amps = neighbours(at.bank) | 1u << at.bank;
  return arrival < refreshed_until_ && at.device == refreshed_.device && (same_amps >> refreshed_.bank & 1) != 0;
}

void Channel::refresh_until(Tcycle now) {
  while (next_event_ <= now) {
    if (closing_.pending && closing_.due <= refresh_due_) {
      close_refreshed();
    } else {
      refresh();
    }
    next_event_ = next_event();
  }
}

void Channel::refresh() {
  if (closing_.pending) close_refreshed();
  const std::uint64_t devices = devices_.size();
  refreshed_.device = static_cast<std::uint16_t>(refresh_count_ % devices);
  refreshed_.bank = static_cast<std::uint8_t>(refresh_count_ / devices % Rules::kBanks);
  const Tcycle begin = refresh_next(refreshed_);
  refreshed_until_ = begin + recovery_;
  closing_ = {true, refreshed_.device, refreshed_.bank, begin + refreshed_open_};
}

void Channel::close_refreshed() {
  closing_.pending = false;
  // A packet that needed the bank may have precharged it already.
  if (devices_[closing_.device].open_row(closing_.bank) != dram::kRefreshRow) return;
  precharge(closing_.device, closing_.bank, closing_.due);
}

}  // namespace gicube::emu::rdram
