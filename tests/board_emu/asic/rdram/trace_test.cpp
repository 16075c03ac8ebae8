// Whole traces of the controller against the independent checker, and the checker against faulty traces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rdram_checker.h"
#include "rdram_traffic.h"

namespace gicube::emu::rdram {
namespace {

using reference::check_rdram_trace;
using reference::RdramRules;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;
using enum Command;
using test_traffic::random_traffic;

IssuedCommand command(Command kind, unsigned bank, Tcycle begin, unsigned row = 1, unsigned device = 0) {
  return {kind,
          false,
          static_cast<std::uint16_t>(device),
          static_cast<std::uint16_t>(row),
          static_cast<std::uint8_t>(bank),
          0,
          begin,
          0};
}

using Trace = std::vector<IssuedCommand>;

// A trace whose last command is legal, and breaks `rule` one tCYCLE earlier.
struct Edge {
  const char* rule;
  Trace trace;
};

void PrintTo(const Edge& edge, std::ostream* out) { *out << edge.rule; }

class RdramChecker : public testing::TestWithParam<Edge> {};

TEST_P(RdramChecker, SeesTheFaultOneCycleTooEarlyAndNoneInTime) {
  const RdramRules rules{.devices = 2};
  Trace trace = GetParam().trace;
  EXPECT_THAT(check_rdram_trace(rules, trace).faults, IsEmpty());
  trace.back().begin -= 1;
  EXPECT_THAT(check_rdram_trace(rules, trace).faults, ElementsAre(StartsWith(std::string(GetParam().rule) + ":")));
}

const Edge kEdges[] = {
    {"tRAS", {command(kActivate, 4, 100), command(kPrecharge, 4, 120)}},
    {"tRC", {command(kActivate, 4, 100), command(kPrecharge, 4, 120), command(kActivate, 4, 128)}},
    {"tRP", {command(kActivate, 4, 100), command(kPrecharge, 4, 130), command(kActivate, 4, 138)}},
    {"tRP", {command(kActivate, 4, 100), command(kPrecharge, 4, 130), command(kRefresh, 4, 138)}},
    {"neighbour", {command(kActivate, 4, 100), command(kPrecharge, 4, 130), command(kActivate, 5, 138)}},
    {"neighbour", {command(kActivate, 4, 100), command(kPrecharge, 4, 130), command(kActivate, 3, 138)}},
    {"tRR", {command(kActivate, 4, 100), command(kActivate, 8, 108)}},
    {"tRR", {command(kRefresh, 4, 100), command(kActivate, 8, 108)}},
    {"tPP",
     {command(kActivate, 4, 100), command(kActivate, 8, 108), command(kPrecharge, 4, 140),
      command(kPrecharge, 8, 148)}},
    {"tRCD", {command(kActivate, 4, 100), command(kRead, 4, 107)}},
    {"tRCD", {command(kActivate, 4, 100), command(kWrite, 4, 107)}},
    {"tOFFP", {command(kActivate, 4, 100), command(kRead, 4, 130), command(kPrecharge, 4, 134)}},
    {"tRTR", {command(kActivate, 4, 100), command(kWrite, 4, 130), command(kPrecharge, 4, 142)}},
    {"tRTR", {command(kActivate, 4, 100), command(kActivate, 8, 108), command(kWrite, 4, 130), command(kRead, 8, 142)}},
    {"ROW", {command(kActivate, 4, 100), command(kActivate, 4, 104, 1, 1)}},
    {"COL", {command(kActivate, 4, 100), command(kRead, 4, 107), command(kRead, 4, 111)}},
    {"DQ", {command(kActivate, 4, 100), command(kRead, 4, 107), command(kWrite, 4, 113)}},
};

INSTANTIATE_TEST_SUITE_P(Rule, RdramChecker, testing::ValuesIn(kEdges));

std::vector<std::string> faults(const Trace& trace) {
  return check_rdram_trace(RdramRules{.devices = 1}, trace).faults;
}

TEST(RdramCheckerOfStates, SeesWhatNoTimeMakesRight) {
  EXPECT_THAT(faults({command(kActivate, 4, 100), command(kActivate, 4, 900)}), ElementsAre(StartsWith("open:")));
  EXPECT_THAT(faults({command(kActivate, 4, 100), command(kActivate, 5, 900)}), ElementsAre(StartsWith("neighbour:")));
  EXPECT_THAT(faults({command(kActivate, 15, 100), command(kActivate, 16, 900)}), IsEmpty());
  EXPECT_THAT(faults({command(kRead, 4, 900)}), ElementsAre(StartsWith("closed:")));
  EXPECT_THAT(faults({command(kPrecharge, 4, 900)}), ElementsAre(StartsWith("closed:")));
  EXPECT_THAT(faults({command(kRefresh, 4, 100), command(kRead, 4, 900)}), ElementsAre(StartsWith("closed:")));
  EXPECT_THAT(faults({command(kActivate, 4, 100), command(kRead, 4, 900, 2)}), ElementsAre(StartsWith("row:")));
  EXPECT_THAT(faults({command(kActivate, 4, 100, 1, 3)}), ElementsAre(StartsWith("address:")));
}

TEST(RdramCheckerOfStates, SeesACommandBeforeItWasAskedFor) {
  Trace trace{command(kActivate, 4, 100)};
  trace[0].asked = 101;
  EXPECT_THAT(faults(trace), ElementsAre(StartsWith("asked:")));
}

TEST(RdramCheckerOfStates, SeesAFalseClaimToBeTight) {
  Trace trace{command(kActivate, 4, 100), command(kRead, 4, 107)};
  trace[1].tight = true;
  EXPECT_THAT(faults(trace), IsEmpty());
  trace[1].begin = 108;
  EXPECT_THAT(faults(trace), ElementsAre(StartsWith("tight:")));
}

TEST(RdramCheckerOfStates, SeesARefreshOutOfTurnOrTime) {
  const RdramRules rules{.refresh_interval = 781, .refresh_slack = 100, .devices = 1};
  EXPECT_THAT(check_rdram_trace(rules, {command(kRefresh, 0, 781)}).faults, IsEmpty());
  EXPECT_THAT(check_rdram_trace(rules, {command(kRefresh, 1, 781)}).faults, ElementsAre(StartsWith("refresh-bank:")));
  EXPECT_THAT(check_rdram_trace(rules, {command(kRefresh, 0, 780)}).faults, ElementsAre(StartsWith("refresh-time:")));
  EXPECT_THAT(check_rdram_trace(rules, {command(kRefresh, 0, 882)}).faults, ElementsAre(StartsWith("refresh-time:")));
}

class RdramTrace : public testing::TestWithParam<unsigned> {};  // devices

TEST_P(RdramTrace, OfRandomTrafficBreaksNoRuleAndIsTight) {
  const unsigned devices = GetParam();
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Trace trace;
    Channel channel(v1::RdramConfig(), devices);
    channel.set_trace(&trace);
    const std::vector<Tcycle> begins = random_traffic(channel, devices, 20'000, seed);
    const auto verdict = check_rdram_trace({.refresh_interval = 781, .devices = devices}, trace);
    EXPECT_THAT(verdict.faults, IsEmpty());
    EXPECT_EQ(verdict.data_begins, begins) << "data do not come when the controller said";
    EXPECT_GT(verdict.tight_commands, trace.size() * 9 / 10);
    EXPECT_GT(channel.counters().refreshes, 100u);
    EXPECT_GT(channel.counters().row_hits, 1000u);
    EXPECT_GT(channel.counters().conflicts, 1000u);
  }
}

INSTANTIATE_TEST_SUITE_P(Devices, RdramTrace, testing::Values(1u, 2u, 5u));

TEST(RdramTraceOfOtherTimings, FollowsTheConfiguration) {
  v1::RdramConfig config;
  config.set_t_ras(31), config.set_t_rp(11), config.set_t_rr(9), config.set_t_pp(13), config.set_t_rcd(12);
  config.set_t_cac(9), config.set_t_cwd(12), config.set_t_rtr(5), config.set_t_offp(7),
      config.set_refresh_interval(500);
  const RdramRules rules{.ras = 31,
                         .rp = 11,
                         .rr = 9,
                         .pp = 13,
                         .rcd = 12,
                         .cac = 9,
                         .cwd = 12,
                         .rtr = 5,
                         .offp = 7,
                         .refresh_interval = 500,
                         .devices = 2};
  Trace trace;
  Channel channel(config, 2);
  channel.set_trace(&trace);
  const std::vector<Tcycle> begins = random_traffic(channel, 2, 20'000, 9);
  const auto verdict = check_rdram_trace(rules, trace);
  EXPECT_THAT(verdict.faults, IsEmpty());
  EXPECT_EQ(verdict.data_begins, begins);
}

}  // namespace
}  // namespace gicube::emu::rdram
