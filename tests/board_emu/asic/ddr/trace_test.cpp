// Whole traces of the controller against the independent checker, and the checker against faulty traces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ddr_traffic.h"
#include "rank_checker.h"

namespace gicube::emu::ddr {
namespace {

using reference::check_rank_trace;
using reference::RankRules;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;
using enum Command;
using test_traffic::random_traffic;

IssuedCommand command(Command kind, unsigned bank, Tcycle begin, unsigned row = 1, unsigned rank = 0) {
  return {kind,
          false,
          static_cast<std::uint16_t>(rank),
          static_cast<std::uint16_t>(row),
          static_cast<std::uint8_t>(bank),
          0,
          begin,
          0};
}

using Trace = std::vector<IssuedCommand>;

// A trace whose last command is legal, and breaks `rule` one clock earlier.
struct Edge {
  const char* rule;
  Trace trace;
};

void PrintTo(const Edge& edge, std::ostream* out) { *out << edge.rule; }

class DdrChecker : public testing::TestWithParam<Edge> {};

TEST_P(DdrChecker, SeesTheFaultOneClockTooEarlyAndNoneInTime) {
  const RankRules rules{.ranks = 2};
  Trace trace = GetParam().trace;
  EXPECT_THAT(check_rank_trace(rules, trace).faults, IsEmpty());
  trace.back().begin -= 1;
  EXPECT_THAT(check_rank_trace(rules, trace).faults, ElementsAre(StartsWith(std::string(GetParam().rule) + ":")));
}

const Edge kEdges[] = {
    {"tRAS", {command(kActivate, 1, 100), command(kPrecharge, 1, 105)}},
    {"tRC", {command(kActivate, 1, 100), command(kPrecharge, 1, 105), command(kActivate, 1, 107)}},
    {"tRP", {command(kActivate, 1, 100), command(kPrecharge, 1, 110), command(kActivate, 1, 112)}},
    {"tRP", {command(kActivate, 1, 100), command(kPrecharge, 1, 110), command(kRefresh, 0, 112)}},
    {"tRRD", {command(kActivate, 1, 100), command(kActivate, 2, 102)}},
    {"tRCD", {command(kActivate, 1, 100), command(kRead, 1, 102)}},
    {"tRCD", {command(kActivate, 1, 100), command(kWrite, 1, 102)}},
    {"tRFC", {command(kRefresh, 0, 100), command(kActivate, 1, 108)}},
    {"tRFC", {command(kRefresh, 0, 100), command(kRefresh, 0, 108)}},
    {"tWR", {command(kActivate, 1, 100), command(kWrite, 1, 110), command(kPrecharge, 1, 114)}},
    {"tWTR", {command(kActivate, 1, 100), command(kActivate, 2, 102), command(kWrite, 1, 110), command(kRead, 2, 113)}},
    {"command", {command(kActivate, 1, 100), command(kActivate, 1, 101, 1, 1)}},
    {"DQ", {command(kActivate, 1, 100), command(kRead, 1, 110), command(kWrite, 1, 113)}},
    {"DQ",
     {command(kActivate, 1, 100), command(kActivate, 1, 101, 1, 1), command(kRead, 1, 110),
      command(kRead, 1, 112, 1, 1)}},
};

INSTANTIATE_TEST_SUITE_P(Rule, DdrChecker, testing::ValuesIn(kEdges));

std::vector<std::string> faults(const Trace& trace) { return check_rank_trace(RankRules{.ranks = 1}, trace).faults; }

TEST(DdrCheckerOfStates, SeesWhatNoTimeMakesRight) {
  EXPECT_THAT(faults({command(kActivate, 1, 100), command(kActivate, 1, 900)}), ElementsAre(StartsWith("open:")));
  EXPECT_THAT(faults({command(kActivate, 1, 100), command(kRefresh, 0, 900)}), ElementsAre(StartsWith("open:")));
  EXPECT_THAT(faults({command(kRead, 1, 900)}), ElementsAre(StartsWith("closed:")));
  EXPECT_THAT(faults({command(kPrecharge, 1, 900)}), ElementsAre(StartsWith("closed:")));
  EXPECT_THAT(faults({command(kActivate, 1, 100), command(kRead, 1, 900, 2)}), ElementsAre(StartsWith("row:")));
  EXPECT_THAT(faults({command(kActivate, 1, 100, 1, 3)}), ElementsAre(StartsWith("address:")));
  EXPECT_THAT(faults({command(kActivate, 4, 100)}), ElementsAre(StartsWith("address:")));
}

TEST(DdrCheckerOfStates, SeesACommandBeforeItWasAskedFor) {
  Trace trace{command(kActivate, 1, 100)};
  trace[0].asked = 101;
  EXPECT_THAT(faults(trace), ElementsAre(StartsWith("asked:")));
}

TEST(DdrCheckerOfStates, SeesAFalseClaimToBeTight) {
  Trace trace{command(kActivate, 1, 100), command(kRead, 1, 102)};
  trace[1].tight = true;
  EXPECT_THAT(faults(trace), IsEmpty());
  trace[1].begin = 103;
  EXPECT_THAT(faults(trace), ElementsAre(StartsWith("tight:")));
}

TEST(DdrCheckerOfStates, SeesARefreshOutOfTime) {
  const RankRules rules{.refresh_interval = 1562, .refresh_slack = 100, .ranks = 1};
  EXPECT_THAT(check_rank_trace(rules, {command(kRefresh, 0, 1562)}).faults, IsEmpty());
  EXPECT_THAT(check_rank_trace(rules, {command(kRefresh, 0, 1561)}).faults, ElementsAre(StartsWith("refresh-time:")));
  EXPECT_THAT(check_rank_trace(rules, {command(kRefresh, 0, 1663)}).faults, ElementsAre(StartsWith("refresh-time:")));
}

class DdrTrace : public testing::TestWithParam<unsigned> {};  // ranks

TEST_P(DdrTrace, OfRandomTrafficBreaksNoRuleAndIsTight) {
  const unsigned ranks = GetParam();
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Trace trace;
    Channel channel(v1::DdrConfig(), ranks);
    channel.set_trace(&trace);
    const std::vector<Tcycle> begins = random_traffic(channel, ranks, 20'000, seed);
    const auto verdict = check_rank_trace({.refresh_interval = 1562, .ranks = ranks}, trace);
    EXPECT_THAT(verdict.faults, IsEmpty());
    EXPECT_EQ(verdict.data_begins, begins) << "data do not come when the controller said";
    EXPECT_GT(verdict.tight_commands, trace.size() * 9 / 10);
    EXPECT_GT(channel.counters().refreshes, 100u);
    EXPECT_GT(channel.counters().row_hits, 1000u);
    EXPECT_GT(channel.counters().conflicts, 1000u);
  }
}

INSTANTIATE_TEST_SUITE_P(Ranks, DdrTrace, testing::Values(1u, 2u, 4u));

TEST(DdrTraceOfOtherTimings, FollowsTheConfiguration) {
  v1::DdrConfig config;
  config.set_t_ras(8), config.set_t_rc(13), config.set_t_rp(3), config.set_t_rrd(4), config.set_t_rcd(5);
  config.set_t_cl(3), config.set_t_wr(5), config.set_t_wtr(3), config.set_t_rfc(20), config.set_refresh_interval(500);
  const RankRules rules{.ras = 80,
                        .rc = 130,
                        .rp = 30,
                        .rrd = 40,
                        .rcd = 50,
                        .wr = 50,
                        .rfc = 200,
                        .cl = 3,
                        .wtr = 3,
                        .refresh_interval = 500,
                        .ranks = 2};
  Trace trace;
  Channel channel(config, 2);
  channel.set_trace(&trace);
  const std::vector<Tcycle> begins = random_traffic(channel, 2, 20'000, 9);
  const auto verdict = check_rank_trace(rules, trace);
  EXPECT_THAT(verdict.faults, IsEmpty());
  EXPECT_EQ(verdict.data_begins, begins);
}

}  // namespace
}  // namespace gicube::emu::ddr
