// The independent checkers of whole traces, against faulty ones.
#include "channels.h"

namespace gicube::emu::dram {
namespace {

using reference::RankRules;
using reference::RdramRules;
using enum Command;
using Trace = std::vector<IssuedCommand>;

template <typename Rules>
std::vector<std::string> faults(const Trace& trace, const Rules& rules = {}) {
  return reference::check_trace(rules, trace).faults;
}

auto is_fault_of(const std::string& rule) { return ElementsAre(StartsWith(rule + ":")); }

// A trace whose last command is legal, and breaks `rule` one clock earlier.
struct Edge {
  const char* rule;
  Trace trace;
};

template <typename Rules>
void expect_edges(const std::vector<Edge>& edges) {
  for (auto [rule, trace] : edges) {
    EXPECT_THAT(faults<Rules>(trace, {.devices = 2}), IsEmpty()) << rule;
    trace.back().begin -= 1;
    EXPECT_THAT(faults<Rules>(trace, {.devices = 2}), is_fault_of(rule));
  }
}

TEST(RankChecker, SeesTheFaultOneClockTooEarlyAndNoneInTime) {
  const IssuedCommand opened = command(kActivate, 1, 100), of_other_rank = command(kActivate, 1, 101, 1, 1);
  expect_edges<RankRules>({
      {"tRAS", {opened, command(kPrecharge, 1, 105)}},
      {"tRC", {opened, command(kPrecharge, 1, 105), command(kActivate, 1, 107)}},
      {"tRP", {opened, command(kPrecharge, 1, 110), command(kActivate, 1, 112)}},
      {"tRP", {opened, command(kPrecharge, 1, 110), command(kRefresh, 0, 112)}},
      {"tRRD", {opened, command(kActivate, 2, 102)}},
      {"tRCD", {opened, command(kRead, 1, 102)}},
      {"tRCD", {opened, command(kWrite, 1, 102)}},
      {"tRFC", {command(kRefresh, 0, 100), command(kActivate, 1, 108)}},
      {"tRFC", {command(kRefresh, 0, 100), command(kRefresh, 0, 108)}},
      {"tWR", {opened, command(kWrite, 1, 110), command(kPrecharge, 1, 114)}},
      {"tWTR", {opened, command(kActivate, 2, 102), command(kWrite, 1, 110), command(kRead, 2, 113)}},
      {"command", {opened, of_other_rank}},
      {"DQ", {opened, command(kRead, 1, 110), command(kWrite, 1, 113)}},
      {"DQ", {opened, of_other_rank, command(kRead, 1, 110), command(kRead, 1, 112, 1, 1)}},
  });
}

TEST(RankChecker, SeesWhatNoTimeMakesRight) {
  const IssuedCommand opened = command(kActivate, 1, 100);
  EXPECT_THAT(faults<RankRules>({opened, command(kActivate, 1, 900)}), is_fault_of("open"));
  EXPECT_THAT(faults<RankRules>({opened, command(kRefresh, 0, 900)}), is_fault_of("open"));
  EXPECT_THAT(faults<RankRules>({command(kRead, 1, 900)}), is_fault_of("closed"));
  EXPECT_THAT(faults<RankRules>({command(kPrecharge, 1, 900)}), is_fault_of("closed"));
  EXPECT_THAT(faults<RankRules>({opened, command(kRead, 1, 900, 2)}), is_fault_of("row"));
  EXPECT_THAT(faults<RankRules>({command(kActivate, 1, 100, 1, 3)}), is_fault_of("address"));
  EXPECT_THAT(faults<RankRules>({command(kActivate, 4, 100)}), is_fault_of("address"));
}

TEST(RankChecker, SeesARefreshOutOfTime) {
  const RankRules rules{.refresh_interval = 1562, .refresh_slack = 100};
  EXPECT_THAT(faults({command(kRefresh, 0, 1562)}, rules), IsEmpty());
  EXPECT_THAT(faults({command(kRefresh, 0, 1561)}, rules), is_fault_of("refresh-time"));
  EXPECT_THAT(faults({command(kRefresh, 0, 1663)}, rules), is_fault_of("refresh-time"));
}

TEST(RdramChecker, SeesTheFaultOneCycleTooEarlyAndNoneInTime) {
  const IssuedCommand opened = command(kActivate, 4, 100), other = command(kActivate, 8, 108);
  expect_edges<RdramRules>({
      {"tRAS", {opened, command(kPrecharge, 4, 120)}},
      {"tRC", {opened, command(kPrecharge, 4, 120), command(kActivate, 4, 128)}},
      {"tRP", {opened, command(kPrecharge, 4, 130), command(kActivate, 4, 138)}},
      {"tRP", {opened, command(kPrecharge, 4, 130), command(kRefresh, 4, 138)}},
      {"neighbour", {opened, command(kPrecharge, 4, 130), command(kActivate, 5, 138)}},
      {"neighbour", {opened, command(kPrecharge, 4, 130), command(kActivate, 3, 138)}},
      {"tRR", {opened, other}},
      {"tRR", {command(kRefresh, 4, 100), other}},
      {"tPP", {opened, other, command(kPrecharge, 4, 140), command(kPrecharge, 8, 148)}},
      {"tRCD", {opened, command(kRead, 4, 107)}},
      {"tRCD", {opened, command(kWrite, 4, 107)}},
      {"tOFFP", {opened, command(kRead, 4, 130), command(kPrecharge, 4, 134)}},
      {"tRTR", {opened, command(kWrite, 4, 130), command(kPrecharge, 4, 142)}},
      {"tRTR", {opened, other, command(kWrite, 4, 130), command(kRead, 8, 142)}},
      {"ROW", {opened, command(kActivate, 4, 104, 1, 1)}},
      {"COL", {opened, command(kRead, 4, 107), command(kRead, 4, 111)}},
      {"DQ", {opened, command(kRead, 4, 107), command(kWrite, 4, 113)}},
  });
}

TEST(RdramChecker, SeesWhatNoTimeMakesRight) {
  const IssuedCommand opened = command(kActivate, 4, 100);
  EXPECT_THAT(faults<RdramRules>({opened, command(kActivate, 4, 900)}), is_fault_of("open"));
  EXPECT_THAT(faults<RdramRules>({opened, command(kActivate, 5, 900)}), is_fault_of("neighbour"));
  EXPECT_THAT(faults<RdramRules>({command(kActivate, 15, 100), command(kActivate, 16, 900)}), IsEmpty());
  EXPECT_THAT(faults<RdramRules>({command(kRead, 4, 900)}), is_fault_of("closed"));
  EXPECT_THAT(faults<RdramRules>({command(kPrecharge, 4, 900)}), is_fault_of("closed"));
  EXPECT_THAT(faults<RdramRules>({command(kRefresh, 4, 100), command(kRead, 4, 900)}), is_fault_of("closed"));
  EXPECT_THAT(faults<RdramRules>({opened, command(kRead, 4, 900, 2)}), is_fault_of("row"));
  EXPECT_THAT(faults<RdramRules>({command(kActivate, 4, 100, 1, 3)}), is_fault_of("address"));
}

TEST(RdramChecker, SeesARefreshOutOfTurnOrTime) {
  const RdramRules rules{.refresh_interval = 781, .refresh_slack = 100};
  EXPECT_THAT(faults({command(kRefresh, 0, 781)}, rules), IsEmpty());
  EXPECT_THAT(faults({command(kRefresh, 1, 781)}, rules), is_fault_of("refresh-bank"));
  EXPECT_THAT(faults({command(kRefresh, 0, 780)}, rules), is_fault_of("refresh-time"));
  EXPECT_THAT(faults({command(kRefresh, 0, 882)}, rules), is_fault_of("refresh-time"));
}

template <typename Rules>
void expect_asked_and_tight(Tcycle first_read) {
  Trace early{command(kActivate, 1, 100)};
  early[0].asked = 101;
  EXPECT_THAT(faults<Rules>(early), is_fault_of("asked"));

  Trace trace{command(kActivate, 1, 100), command(kRead, 1, first_read)};
  trace[1].tight = true;
  EXPECT_THAT(faults<Rules>(trace), IsEmpty());
  ++trace[1].begin;
  EXPECT_THAT(faults<Rules>(trace), is_fault_of("tight"));
}

TEST(Checkers, SeeACommandBeforeItWasAskedForAndAFalseClaimToBeTight) {
  expect_asked_and_tight<RankRules>(102);
  expect_asked_and_tight<RdramRules>(107);
}

}  // namespace
}  // namespace gicube::emu::dram
