#include "rank_checker.h"

#include <algorithm>
#include <array>
#include <optional>

namespace gicube::reference {
namespace {

using emu::dram::IssuedCommand;
using Kind = emu::dram::Command;
using Time = std::uint64_t;
using Past = std::optional<Time>;

struct BankHistory {
  bool open = false;
  int row = 0;
  Past opened, precharged, read, written;
};

struct RankHistory {
  std::array<BankHistory, 4> banks;
  Past opened, precharged, written, refreshed;
  Time refreshes = 0;
};

struct Burst {
  Time begin;
  bool write;
  unsigned rank;
};

class Replay {
 public:
  explicit Replay(const RankRules& rules) : rules_(rules), ranks_(rules.ranks) {}

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

  void carry_out(const IssuedCommand& c, RankVerdict& verdict) {
    RankHistory& rank = ranks_[c.device];
    BankHistory& bank = rank.banks[c.bank];
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

  std::string broken_by_activation(const RankHistory& rank, const BankHistory& bank, Time t) const {
    if (bank.open) return "open";
    if (too_soon(bank.opened, rules_.rc, t)) return "tRC";
    if (too_soon(bank.precharged, rules_.rp, t)) return "tRP";
    return too_soon(rank.opened, rules_.rrd, t) ? "tRRD" : "";
  }

  std::string broken_by_precharge(const BankHistory& bank, Time t) const {
    if (!bank.open) return "closed";
    if (too_soon(bank.opened, rules_.ras, t)) return "tRAS";
    if (bank.read && t < *bank.read + rules_.burst) return "BL";
    return too_soon_after_data(bank.written, rules_.wr, t) ? "tWR" : "";
  }

  std::string broken_by_refresh(const RankHistory& rank, const IssuedCommand& c, Time t) const {
    for (const BankHistory& bank : rank.banks) {
      if (bank.open) return "open";
    }
    if (too_soon(rank.opened, rules_.rc, t)) return "tRC";
    if (too_soon(rank.precharged, rules_.rp, t)) return "tRP";
    if (rules_.refresh_interval == 0) return {};
    // The ranks share the interval evenly.
    const Time due = (rank.refreshes * rules_.ranks + c.device + 1) * rules_.refresh_interval / rules_.ranks;
    return t < due || t > due + rules_.refresh_slack ? "refresh-time" : "";
  }

  std::string broken_by_column(const RankHistory& rank, const IssuedCommand& c, Time t) const {
    const BankHistory& bank = rank.banks[c.bank];
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

std::string fault(const std::string& rule, const IssuedCommand& c) {
  return rule + ": " + to_string(c.command) + " of rank " + std::to_string(c.device) + " bank " +
         std::to_string(c.bank) + " at " + std::to_string(c.begin);
}

}  // namespace

RankVerdict check_rank_trace(const RankRules& rules, std::vector<IssuedCommand> trace) {
  std::stable_sort(trace.begin(), trace.end(), [](const auto& a, const auto& b) { return a.begin < b.begin; });
  RankVerdict verdict;
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
