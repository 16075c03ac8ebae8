// The channels of all memory standards, with the times of their data sheets, and packets for tests of them.
#pragma once

#include <cctype>

#include "asic/ddr/channel.h"
#include "asic/rdram/channel.h"
#include "dram_checkers.h"
#include "dsp/sdram.h"
#include "gicube/v1/board_config.pb.h"
#include "test.h"

namespace gicube::emu::dram {

// The times of packets, in clocks from the arrival of a request to its first data, and what random traffic is like.
struct Ddr {
  using Channel = ddr::Channel;
  using Config = v1::DdrConfig;
  using CheckedRules = reference::RankRules;
  static constexpr const char* kName = "Ddr";
  static constexpr unsigned kColdRead = 2 + 2, kColdWrite = 2 + 1, kOpenRow = 2, kOtherRow = 2 + 2 + 2, kBurst = 1;
  static constexpr unsigned kRefresh = 1562, kBanks = 4, kColumns = 512, kPause = 50, kQueue = 32, kGap = 1;
  static constexpr unsigned kDevices[] = {1, 2, 4};
  static constexpr CheckedRules kRules{.refresh_interval = kRefresh};

  // Other times than those of the data sheet, as the checker counts them.
  static CheckedRules set_other_times(Config& config) {
    config.set_t_ras(8), config.set_t_rc(13), config.set_t_rp(3), config.set_t_rrd(4), config.set_t_rcd(5);
    config.set_t_cl(3), config.set_t_wr(5), config.set_t_wtr(3), config.set_t_rfc(20), config.set_refresh_interval(500);
    return {.ras = 80, .rc = 130, .rp = 30, .rrd = 40, .rcd = 50, .wr = 50, .rfc = 200, .cl = 3, .wtr = 3};
  }
};

struct Sdram {
  using Channel = sdram::Channel;
  using Config = v1::SdramConfig;
  using CheckedRules = reference::RankRules;
  static constexpr const char* kName = "Sdram";
  static constexpr unsigned kColdRead = 2 + 2, kColdWrite = 2, kOpenRow = 2, kOtherRow = 2 + 2 + 2, kBurst = 4;
  static constexpr unsigned kRefresh = 1562, kBanks = 4, kColumns = 128, kPause = 50, kQueue = 8, kGap = 1;
  static constexpr unsigned kDevices[] = {1, 2, 8};
  // wr: from the clock after the last beat, where the board's tWR counts from the beat.
  static constexpr CheckedRules kRules{
      .rrd = 20, .wr = 0, .rfc = 70, .wl = 0, .wtr = 0, .burst = kBurst, .refresh_interval = kRefresh};

  static CheckedRules set_other_times(Config& config) {
    config.set_t_ras(8), config.set_t_rc(13), config.set_t_rp(3), config.set_t_rrd(4), config.set_t_rcd(5);
    config.set_t_cl(3), config.set_t_wr(5), config.set_t_rfc(20), config.set_refresh_interval(500);
    CheckedRules rules{.ras = 80, .rc = 130, .rp = 30, .rrd = 40, .rcd = 50, .wr = 40, .rfc = 200, .cl = 3};
    rules.wl = 0, rules.wtr = 0, rules.burst = kBurst;
    return rules;
  }
};

struct Rdram {
  using Channel = rdram::Channel;
  using Config = v1::RdramConfig;
  using CheckedRules = reference::RdramRules;
  static constexpr const char* kName = "Rdram";
  // ACT, RD 7 later, data 8 after the end of its packet of 4.
  static constexpr unsigned kColdRead = 7 + 4 + 8, kColdWrite = 7 + 4 + 6, kOpenRow = 4 + 8, kOtherRow = 8 + 7 + 12;
  static constexpr unsigned kBurst = 4;
  static constexpr unsigned kRefresh = 781, kBanks = 32, kColumns = 64, kPause = 200, kQueue = 32, kGap = 4;
  static constexpr unsigned kDevices[] = {1, 2, 5};
  static constexpr CheckedRules kRules{.refresh_interval = kRefresh};

  static CheckedRules set_other_times(Config& config) {
    config.set_t_ras(31), config.set_t_rp(11), config.set_t_rr(9), config.set_t_pp(13), config.set_t_rcd(12);
    config.set_t_cac(9), config.set_t_cwd(12), config.set_t_rtr(5), config.set_t_offp(7);
    config.set_refresh_interval(500);
    return {.ras = 31, .rp = 11, .rr = 9, .pp = 13, .rcd = 12, .cac = 9, .cwd = 12, .rtr = 5, .offp = 7};
  }
};

inline Location at(unsigned bank, unsigned row, unsigned column = 0, unsigned device = 0) {
  return {static_cast<std::uint16_t>(device), static_cast<std::uint16_t>(row), static_cast<std::uint8_t>(bank),
          static_cast<std::uint16_t>(column)};
}

template <typename Standard>
typename Standard::Config without_refresh() {
  typename Standard::Config config;
  config.set_refresh_interval(0);
  return config;
}

// When the data of random packets begin: reads and writes, in bursts and after pauses, few rows so that some are open.
template <typename Standard>
std::vector<Tcycle> random_traffic(typename Standard::Channel& channel, unsigned devices, int packets, unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&random](unsigned limit) { return static_cast<unsigned>(random() % limit); };
  std::vector<Tcycle> begins;
  Tcycle now = 0;
  while (packets > 0) {
    if (draw(8) == 0) now += draw(Standard::kPause);
    if (draw(400) == 0) now += 10'000;
    if (begins.size() > Standard::kQueue) now = std::max(now, begins[begins.size() - Standard::kQueue]);
    const bool write = draw(3) == 0;
    const Location first = at(draw(Standard::kBanks), draw(3), draw(Standard::kColumns), draw(devices));
    for (unsigned n = draw(4); n-- > 0 && packets > 0; --packets) {
      begins.push_back((write ? channel.write(first, now) : channel.read(first, now)).data_begin);
      now += draw(2) * Standard::kGap;
    }
  }
  return begins;
}

// The share of the data wires over whole periods in the steady state, all packets asked for at once.
template <typename Standard>
double use_of_data_wires(const std::vector<Access>& accesses, std::size_t skip) {
  const Tcycle begin = accesses[skip].data_begin, end = accesses.back().data_begin;
  return static_cast<double>(Standard::kBurst * (accesses.size() - 1 - skip)) / static_cast<double>(end - begin);
}

// The Rules enforce constraints between the pairs of `rows`, between those of `others`, and between no more.
template <typename Rules>
void expect_enforced(const std::vector<Constraint>& rows, const std::vector<Constraint>& others = {}) {
  for (std::size_t scope = 0; scope < kScopes; ++scope) {
    for (std::size_t from = 0; from < kCommands; ++from) {
      for (std::size_t to = 0; to < kCommands; ++to) {
        const Constraint pair{"tX", static_cast<Command>(from), static_cast<Command>(to), static_cast<Scope>(scope), 3};
        const auto is_of_pair = [&pair](const Constraint& each) {
          return each.from == pair.from && each.to == pair.to && each.scope == pair.scope;
        };
        EXPECT_EQ(Rules::enforced(pair.scope, pair.from, pair.to),
                  std::ranges::any_of(rows, is_of_pair) || std::ranges::any_of(others, is_of_pair))
            << to_string(pair.from) << ' ' << to_string(pair.to) << ' ' << to_string(pair.scope);
      }
    }
  }
}

// The name of a test of a row.
inline std::string name_of_row(const testing::TestParamInfo<Constraint>& row) {
  std::string name = std::to_string(row.index) + row.param.name + to_string(row.param.from) + to_string(row.param.to) +
                     to_string(row.param.scope);
  std::erase_if(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
  return name;
}

// The issue of a command by hand.
inline IssuedCommand command(Command kind, unsigned bank, Tcycle begin, unsigned row = 1, unsigned device = 0) {
  return {.command = kind,
          .tight = false,
          .device = static_cast<std::uint16_t>(device),
          .row = static_cast<std::uint16_t>(row),
          .bank = static_cast<std::uint8_t>(bank),
          .column = 0,
          .begin = begin,
          .asked = 0};
}

}  // namespace gicube::emu::dram
