#include "rdram_checker.h"

#include <algorithm>
#include <array>
#include <optional>

namespace gicube::reference {
namespace {

using emu::rdram::IssuedCommand;
using Kind = emu::rdram::Command;
using Time = std::uint64_t;

struct BankHistory {
  bool open = false;
  bool refreshing = false;
  int row = 0;
  std::optional<Time> opened, precharged, read, written;
};

struct DeviceHistory {
  std::array<BankHistory, 32> banks;
  std::optional<Time> opened, precharged, written;
  Time refreshes = 0;
};

struct Interval {
  Time begin, end;
};

class Replay {
 public:
  explicit Replay(const RdramRules& rules) : rules_(rules), devices_(rules.devices) {}

  // The first rule that the command would break at `t`; empty if none.
  std::string broken_rule(const IssuedCommand& c, Time t) const {
    if (t < c.asked) return "asked";
    const bool column = c.command == Kind::kRead || c.command == Kind::kWrite;
    if (sooner(column ? column_packet_ : row_packet_, rules_.packet, t)) return column ? "COL" : "ROW";
    if (c.device >= devices_.size() || c.bank >= 32) return "address";
    if (c.command == Kind::kPrecharge) return broken_by_precharge(c, t);
    return column ? broken_by_column(c, t) : broken_by_opening(c, t);
  }

  void carry_out(const IssuedCommand& c, RdramVerdict& verdict) {
    DeviceHistory& device = devices_[c.device];
    BankHistory& bank = device.banks[c.bank];
    switch (c.command) {
      case Kind::kRefresh: ++device.refreshes; [[fallthrough]];
      case Kind::kActivate:
        bank = {true, c.command == Kind::kRefresh, c.row, c.begin, bank.precharged, {}, {}};
        device.opened = row_packet_ = c.begin;
        break;
      case Kind::kPrecharge:
        bank.open = false;
        bank.precharged = device.precharged = row_packet_ = c.begin;
        break;
      case Kind::kRead: bank.read = column_packet_ = c.begin; break;
      case Kind::kWrite: bank.written = device.written = column_packet_ = c.begin; break;
      case Kind::kData: break;
    }
    if (c.command != Kind::kRead && c.command != Kind::kWrite) return;
    data_.push_back(data_of(c, c.begin));
    verdict.data_begins.push_back(data_.back().begin);
  }

 private:
  static bool sooner(const std::optional<Time>& before, Time distance, Time t) {
    return before.has_value() && t < *before + distance;
  }

  Interval data_of(const IssuedCommand& c, Time t) const {
    const Time begin = t + rules_.packet + (c.command == Kind::kRead ? rules_.cac : rules_.cwd);
    return {begin, begin + rules_.packet};
  }

  std::string broken_by_opening(const IssuedCommand& c, Time t) const {
    const DeviceHistory& device = devices_[c.device];
    const BankHistory& bank = device.banks[c.bank];
    if (bank.open) return "open";
    if (sooner(bank.opened, rules_.ras + rules_.rp, t)) return "tRC";
    if (sooner(bank.precharged, rules_.rp, t)) return "tRP";
    for (const int other : {c.bank - 1, c.bank + 1}) {
      if (other < 0 || other > 31 || other / 16 != c.bank / 16) continue;
      if (device.banks[static_cast<std::size_t>(other)].open) return "neighbour";
      if (sooner(device.banks[static_cast<std::size_t>(other)].precharged, rules_.rp, t)) return "neighbour";
    }
    if (sooner(device.opened, rules_.rr, t)) return "tRR";
    if (c.command == Kind::kRefresh && rules_.refresh_interval != 0) return broken_by_refresh(c, t);
    return {};
  }

  std::string broken_by_refresh(const IssuedCommand& c, Time t) const {
    const DeviceHistory& device = devices_[c.device];
    if (c.bank != device.refreshes % 32) return "refresh-bank";
    // The devices share the interval evenly.
    const Time due = (device.refreshes * rules_.devices + c.device + 1) * rules_.refresh_interval / rules_.devices;
    return t < due || t > due + rules_.refresh_slack ? "refresh-time" : "";
  }

  std::string broken_by_precharge(const IssuedCommand& c, Time t) const {
    const DeviceHistory& device = devices_[c.device];
    const BankHistory& bank = device.banks[c.bank];
    if (!bank.open) return "closed";
    if (sooner(bank.opened, rules_.ras, t)) return "tRAS";
    if (sooner(device.precharged, rules_.pp, t)) return "tPP";
    if (sooner(bank.read, rules_.offp, t)) return "tOFFP";
    if (sooner(bank.written, rules_.rtr + rules_.offp, t)) return "tRTR";
    return {};
  }

  std::string broken_by_column(const IssuedCommand& c, Time t) const {
    const DeviceHistory& device = devices_[c.device];
    const BankHistory& bank = device.banks[c.bank];
    if (!bank.open || bank.refreshing) return "closed";
    if (bank.row != c.row) return "row";
    if (sooner(bank.opened, rules_.rcd, t)) return "tRCD";
    // The packet that retires the write buffer comes tRTR after the write, and the read after that packet.
    if (c.command == Kind::kRead && sooner(device.written, rules_.rtr + rules_.packet, t)) return "tRTR";
    const Interval mine = data_of(c, t);
    const std::size_t first = data_.size() < 16 ? 0 : data_.size() - 16;
    for (std::size_t i = first; i < data_.size(); ++i) {
      if (mine.begin < data_[i].end && data_[i].begin < mine.end) return "DQ";
    }
    return {};
  }

  RdramRules rules_;
  std::vector<DeviceHistory> devices_;
  std::optional<Time> row_packet_, column_packet_;
  std::vector<Interval> data_;
};

std::string fault(const std::string& rule, const IssuedCommand& c) {
  return rule + ": " + to_string(c.command) + " of device " + std::to_string(c.device) + " bank " +
         std::to_string(c.bank) + " at " + std::to_string(c.begin);
}

}  // namespace

RdramVerdict check_rdram_trace(const RdramRules& rules, std::vector<IssuedCommand> trace) {
  std::stable_sort(trace.begin(), trace.end(), [](const auto& a, const auto& b) { return a.begin < b.begin; });
  RdramVerdict verdict;
  Replay replay(rules);
  for (const IssuedCommand& c : trace) {
    const std::string rule = replay.broken_rule(c, c.begin);
    if (!rule.empty()) verdict.faults.push_back(fault(rule, c));
    if (rule == "address") continue;
    if (c.tight) {
      const bool possible = c.begin > 0 && replay.broken_rule(c, c.begin - 1).empty();
      if (possible) verdict.faults.push_back(fault("tight", c));
      verdict.tight_commands += !possible;
    }
    replay.carry_out(c, verdict);
  }
  return verdict;
}

}  // namespace gicube::reference
