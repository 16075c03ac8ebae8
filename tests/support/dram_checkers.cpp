#include "dram_checkers.h"

#include <algorithm>
#include <array>
#include <optional>

namespace gicube::reference {
namespace {

using emu::dram::IssuedCommand;
using Kind = emu::dram::Command;
using Time = std::uint64_t;
using Past = std::optional<Time>;

struct RankBank {
  bool open = false;
  int row = 0;
  Past opened, precharged, read, written;
};

struct RankHistory {
  std::array<RankBank, 4> banks;
  Past opened, precharged, written, refreshed;
  Time refreshes = 0;
};

struct Burst {
  Time begin;
  bool write;
  unsigned rank;
};

class RankReplay {
 public:
  explicit RankReplay(const RankRules& rules) : rules_(rules), ranks_(rules.devices) {}

  // The first rule that the command would break at `t`; empty if none.
  std::string broken_rule(const IssuedCommand& c, Time t) const {
    if (t < c.asked) return "asked";
    if (last_ && t <= *last_) return "command";  // one a clock
    if (c.device >= ranks_.size() || c.bank >= 4) return "address";
    const RankHistory& rank = ranks_[c.device];
    if (too_soon(rank.refreshed, rules_.rfc, t)) return "tRFC";
    switch (c.command) {
      case Kind::kActivate: return broken_by_activation(rank, rank.banks[c.bank], t);
      case Kind::kPrecharge: return broken_by_precharge(rank.banks[c.bank], t);
      case Kind::kRefresh: return broken_by_refresh(rank, c, t);
      case Kind::kRead:
      case Kind::kWrite: return broken_by_column(rank, c, t);
      case Kind::kData: break;
    }
    return "command";
  }

  void carry_out(const IssuedCommand& c, TraceVerdict& verdict) {
    RankHistory& rank = ranks_[c.device];
    RankBank& bank = rank.banks[c.bank];
    last_ = c.begin;
    switch (c.command) {
      case Kind::kRefresh:
        ++rank.refreshes;
        rank.refreshed = c.begin;
        break;
      case Kind::kActivate:
        bank = {true, c.row, c.begin, bank.precharged, {}, {}};
        rank.opened = c.begin;
        break;
      case Kind::kPrecharge:
        bank.open = false;
        bank.precharged = rank.precharged = c.begin;
        break;
      case Kind::kRead: bank.read = c.begin; break;
      case Kind::kWrite: bank.written = rank.written = c.begin; break;
      case Kind::kData: break;
    }
    if (c.command != Kind::kRead && c.command != Kind::kWrite) return;
    bursts_.push_back(burst_of(c, c.begin));
    verdict.data_begins.push_back(bursts_.back().begin);
  }

 private:
  // In whole clocks a time in ns is rounded up.
  bool too_soon(const Past& before, Time ns, Time t) const {
    return before.has_value() && (t - *before) * rules_.tck < ns;
  }
  // `ns` after the end of the data that were written by a WR at `before`.
  bool too_soon_after_data(const Past& before, Time ns, Time t) const {
    if (!before.has_value()) return false;
    const Time end = *before + rules_.wl + rules_.burst;
    return t < end || (t - end) * rules_.tck < ns;
  }

  Burst burst_of(const IssuedCommand& c, Time t) const {
    const bool write = c.command == Kind::kWrite;
    return {t + (write ? rules_.wl : rules_.cl), write, c.device};
  }

  std::string broken_by_activation(const RankHistory& rank, const RankBank& bank, Time t) const {
    if (bank.open) return "open";
    if (too_soon(bank.opened, rules_.rc, t)) return "tRC";
    if (too_soon(bank.precharged, rules_.rp, t)) return "tRP";
    return too_soon(rank.opened, rules_.rrd, t) ? "tRRD" : "";
  }

  std::string broken_by_precharge(const RankBank& bank, Time t) const {
    if (!bank.open) return "closed";
    if (too_soon(bank.opened, rules_.ras, t)) return "tRAS";
    if (bank.read && t < *bank.read + rules_.burst) return "BL";
    return too_soon_after_data(bank.written, rules_.wr, t) ? "tWR" : "";
  }

  std::string broken_by_refresh(const RankHistory& rank, const IssuedCommand& c, Time t) const {
    for (const RankBank& bank : rank.banks) {
      if (bank.open) return "open";
    }
    if (too_soon(rank.opened, rules_.rc, t)) return "tRC";
    if (too_soon(rank.precharged, rules_.rp, t)) return "tRP";
    if (rules_.refresh_interval == 0) return {};
    // The ranks share the interval evenly.
    const Time due = (rank.refreshes * rules_.devices + c.device + 1) * rules_.refresh_interval / rules_.devices;
    return t < due || t > due + rules_.refresh_slack ? "refresh-time" : "";
  }

  std::string broken_by_column(const RankHistory& rank, const IssuedCommand& c, Time t) const {
    const RankBank& bank = rank.banks[c.bank];
    if (!bank.open) return "closed";
    if (bank.row != c.row) return "row";
    if (too_soon(bank.opened, rules_.rcd, t)) return "tRCD";
    if (c.command == Kind::kRead && too_soon_after_data(rank.written, rules_.wtr * rules_.tck, t)) return "tWTR";
    const Burst mine = burst_of(c, t);
    const std::size_t first = bursts_.size() < 8 ? 0 : bursts_.size() - 8;
    for (std::size_t i = first; i < bursts_.size(); ++i) {
      const Burst& other = bursts_[i];
      // The strobes are handed over: from a read to a write, and between ranks unless the controller drives both.
      Time gap = 0;
      if (!other.write && mine.write) gap = 1;
      if (other.rank != mine.rank && !mine.write) gap = rules_.rank_switch;
      if (mine.begin < other.begin + rules_.burst + gap) return "DQ";
    }
    return {};
  }

  RankRules rules_;
  std::vector<RankHistory> ranks_;
  Past last_;
  std::vector<Burst> bursts_;
};

struct DeviceBank {
  bool open = false;
  bool refreshing = false;
  int row = 0;
  Past opened, precharged, read, written;
};

struct DeviceHistory {
  std::array<DeviceBank, 32> banks;
  Past opened, precharged, written;
  Time refreshes = 0;
};

struct Interval {
  Time begin, end;
};

class RdramReplay {
 public:
  explicit RdramReplay(const RdramRules& rules) : rules_(rules), devices_(rules.devices) {}

  // The first rule that the command would break at `t`; empty if none.
  std::string broken_rule(const IssuedCommand& c, Time t) const {
    if (t < c.asked) return "asked";
    const bool column = c.command == Kind::kRead || c.command == Kind::kWrite;
    if (sooner(column ? column_packet_ : row_packet_, rules_.packet, t)) return column ? "COL" : "ROW";
    if (c.device >= devices_.size() || c.bank >= 32) return "address";
    if (c.command == Kind::kPrecharge) return broken_by_precharge(c, t);
    return column ? broken_by_column(c, t) : broken_by_opening(c, t);
  }

  void carry_out(const IssuedCommand& c, TraceVerdict& verdict) {
    DeviceHistory& device = devices_[c.device];
    DeviceBank& bank = device.banks[c.bank];
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
  static bool sooner(const Past& before, Time distance, Time t) { return before.has_value() && t < *before + distance; }

  Interval data_of(const IssuedCommand& c, Time t) const {
    const Time begin = t + rules_.packet + (c.command == Kind::kRead ? rules_.cac : rules_.cwd);
    return {begin, begin + rules_.packet};
  }

  std::string broken_by_opening(const IssuedCommand& c, Time t) const {
    const DeviceHistory& device = devices_[c.device];
    const DeviceBank& bank = device.banks[c.bank];
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
    const DeviceBank& bank = device.banks[c.bank];
    if (!bank.open) return "closed";
    if (sooner(bank.opened, rules_.ras, t)) return "tRAS";
    if (sooner(device.precharged, rules_.pp, t)) return "tPP";
    if (sooner(bank.read, rules_.offp, t)) return "tOFFP";
    if (sooner(bank.written, rules_.rtr + rules_.offp, t)) return "tRTR";
    return {};
  }

  std::string broken_by_column(const IssuedCommand& c, Time t) const {
    const DeviceHistory& device = devices_[c.device];
    const DeviceBank& bank = device.banks[c.bank];
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
  Past row_packet_, column_packet_;
  std::vector<Interval> data_;
};

std::string fault(const std::string& rule, const IssuedCommand& c) {
  return rule + ": " + to_string(c.command) + " of device " + std::to_string(c.device) + " bank " +
         std::to_string(c.bank) + " at " + std::to_string(c.begin);
}

template <typename Replay>
TraceVerdict check(Replay replay, std::vector<IssuedCommand> trace) {
  std::ranges::stable_sort(trace, {}, &IssuedCommand::begin);
  TraceVerdict verdict;
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

}  // namespace

TraceVerdict check_trace(const RankRules& rules, std::vector<IssuedCommand> trace) {
  return check(RankReplay(rules), std::move(trace));
}

TraceVerdict check_trace(const RdramRules& rules, std::vector<IssuedCommand> trace) {
  return check(RdramReplay(rules), std::move(trace));
}

}  // namespace gicube::reference
