#include "server/faults/fault_plan.h"

#include "server/faults/fault_plan.h"
#include "test.h"

namespace gicube::emu {
namespace {

using v1::PlannedFault;

std::vector<std::string> faults_of(std::string_view text) {
  std::vector<std::string> all;
  for (const Diagnostic& each : parse_fault_plan(text).diagnostics) all.push_back(to_string(each));
  return all;
}

v1::FaultPlan plan(std::string_view text) {
  const ParsedFaultPlan parsed = parse_fault_plan(text);
  EXPECT_EQ(to_string(parsed.diagnostics), "");
  return parsed.plan;
}

constexpr const char* kEveryKind = R"(
    # names each kind once
    fault { direction: down message: 1 kind: drop }
    fault { direction: up message: 1 kind: delay delay_ms: 20 }
    fault { direction: down message: 2 kind: corrupt bit: 7 }
    fault { direction: up message: 2 kind: duplicate }
    fault { direction: down message: 3 kind: hang }
    fault { direction: up message: 3 kind: link_loss }
    fault { direction: down message: 4 kind: kill }
    fault { direction: up message: 4 kind: slow bytes_per_second: 1000 messages: 5 }
    fault { direction: down message: 5 kind: memory_detected block: 3 }
    fault { direction: down message: 6 kind: memory_silent block: 3 bit: 9 }
    random { seed: 7 kinds: [drop, delay, slow] mean_messages: 10 max_faults: 3 first_message: 100
             max_delay_ms: 5 bytes_per_second: 5000 slow_messages: 2 direction: up }
)";

TEST(FaultPlan, EveryKindCanBeWrittenAndReadBack) {
  const v1::FaultPlan read = plan(kEveryKind);
  EXPECT_EQ(read.fault_size(), 10);
  EXPECT_EQ(read.random_size(), 1);
  std::string text;
  for (const PlannedFault& fault : read.fault()) text += to_text(fault) + "\n";
  const v1::FaultPlan again = plan(text);
  ASSERT_EQ(again.fault_size(), 10);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(again.fault(i).SerializeAsString(), read.fault(i).SerializeAsString());
}

TEST(FaultPlan, AnEmptyTextIsNoFaults) { EXPECT_THAT(faults_of("# nothing\n"), IsEmpty()); }

TEST(FaultPlan, ReportsEveryUnreadableFieldByItsPlace) {
  EXPECT_THAT(faults_of("fault { direction: down message: 1 kind: drop }\n"
                        "fault { direction: sideways message: -3 kind: hiccup }\n"
                        "random { kinds: drop kinds: flood mean_messages: \"ten\" }\n"
                        "faults { message: 1 }\n"),
              ElementsAre("line 2: fault[1].direction: expected one of down, up, got sideways",
                          "line 2: fault[1].message: expected a whole number from 0 to 18446744073709551615, got -3",
                          HasSubstr("line 2: fault[1].kind: expected one of drop, delay, corrupt"),
                          HasSubstr("line 3: random[0].kinds[1]: expected one of drop, delay, corrupt"),
                          HasSubstr("line 3: random[0].mean_messages: expected a whole number"),
                          "line 4: faults: expected one of fault, random, got \"faults\""));
}

TEST(FaultPlan, ReportsEveryMissingUselessAndWrongField) {
  EXPECT_THAT(
      faults_of("fault { direction: up message: 0 kind: memory_silent }\n"
                "fault { kind: delay bit: 3 }\n"
                "fault { direction: down message: 9 kind: slow bytes_per_second: 10 messages: 3 }\n"
                "fault { direction: down message: 9 kind: drop }\n"
                "random { kinds: delay kinds: delay max_delay_ms: 99999999 slow_messages: 3 }\n"
                "random { kinds: memory_silent direction: up mean_messages: 0 }\n"
                "random { mean_messages: 4 }\n"),
      ElementsAre(
          "line 1: fault[0].message: expected at least 1 (messages are counted from 1), got 0",
          "line 1: fault[0].direction: expected down for memory_silent, got up",
          "line 2: fault[1].direction: expected one of down, up, got nothing",
          "line 2: fault[1].message: expected a whole number from 0 to 18446744073709551615, got nothing",
          "line 2: fault[1].delay_ms: expected a whole number from 0 to 4294967295, got nothing",
          "line 2: fault[1].bit: expected it only for corrupt, memory_detected, memory_silent, got it for "
          "another kind",
          "line 3: fault[2].bytes_per_second: expected 1000 to 1000000000 bytes a second, got 10",
          "line 4: fault[3].message: expected one fault for each message, got a second one for down 9",
          "line 5: random[0].kinds[1]: expected each kind once, got delay a second time",
          "line 5: random[0].mean_messages: expected a whole number from 0 to 18446744073709551615, got nothing",
          "line 5: random[0].max_delay_ms: expected 1 to 60000 ms, got 99999999",
          "line 5: random[0].slow_messages: expected it only for slow, got it for another kind",
          "line 6: random[1].direction: expected down, since all its kinds are memory faults, got up",
          "line 6: random[1].mean_messages: expected 1 to 4294967296 messages, got 0",
          "line 7: random[2].kinds: expected at least one kind of fault, got none"));
}

// The hits among a direction's first messages of 100 bytes, as text.
std::vector<std::string> run(FaultEngine& engine, PlannedFault::Direction direction, int messages) {
  std::vector<std::string> hits;
  for (int i = 0; i < messages; ++i) {
    if (const auto fault = engine.next(direction, 100)) hits.push_back(to_text(*fault));
  }
  return hits;
}

std::vector<std::string> run(std::string_view text, PlannedFault::Direction direction, int messages) {
  FaultEngine engine(plan(text));
  return run(engine, direction, messages);
}

constexpr const char* kSeeded =
    "random { seed: 42 kinds: [drop, delay, corrupt, duplicate, hang, link_loss, slow, memory_detected, memory_silent] "
    "mean_messages: 20 max_delay_ms: 9 bytes_per_second: 100000 slow_messages: 4 }";

TEST(FaultEngine, NamedFaultsHitTheirMessageAlone) {
  const std::string text = "fault { direction: down message: 3 kind: drop }";
  EXPECT_THAT(run(text, PlannedFault::down, 1000), ElementsAre(text));
  EXPECT_THAT(run(text, PlannedFault::up, 1000), IsEmpty());
}

TEST(FaultEngine, ASeedGivesTheSameFaultsHoweverTheDirectionsInterleave) {
  FaultEngine one(plan(kSeeded)), other(plan(kSeeded));
  const auto down = run(one, PlannedFault::down, 5000), up = run(one, PlannedFault::up, 5000);
  std::vector<std::string> other_down, other_up;
  for (int i = 0; i < 5000; ++i) {
    if (const auto fault = other.next(PlannedFault::up, 100)) other_up.push_back(to_text(*fault));
    if (const auto fault = other.next(PlannedFault::down, 100)) other_down.push_back(to_text(*fault));
  }
  EXPECT_EQ(down, other_down);
  EXPECT_EQ(up, other_up);
  EXPECT_NE(down, up);
  std::string another = kSeeded;
  another.replace(another.find("42"), 2, "43");
  EXPECT_NE(run(another, PlannedFault::down, 5000), down);
}

TEST(FaultEngine, RandomFaultsComeAtTheirMeanAndOfEveryKind) {
  FaultEngine engine(plan(kSeeded));
  std::map<PlannedFault::Kind, int> down, up;
  for (int i = 0; i < 100'000; ++i) {
    if (const auto fault = engine.next(PlannedFault::down, 100)) ++down[fault->kind()];
    if (const auto fault = engine.next(PlannedFault::up, 100)) ++up[fault->kind()];
  }
  const auto sum = [](const auto& counts) {
    int all = 0;
    for (const auto& [kind, count] : counts) all += count;
    return all;
  };
  EXPECT_NEAR(sum(down), 5000, 350);  // five standard deviations
  EXPECT_NEAR(sum(up), 5000, 350);
  EXPECT_EQ(down.size(), 9u);
  EXPECT_EQ(up.size(), 7u);  // no memory faults
  for (const auto& [kind, count] : down) EXPECT_NEAR(count, 5000 / 9, 125) << PlannedFault::Kind_Name(kind);
  EXPECT_FALSE(up.contains(PlannedFault::memory_silent) || up.contains(PlannedFault::memory_detected));
}

TEST(FaultEngine, RandomFaultsKeepToTheirBounds) {
  const auto hits = run("random { kinds: delay mean_messages: 1 first_message: 5 max_faults: 2 max_delay_ms: 1 }",
                        PlannedFault::up, 100);
  EXPECT_THAT(hits, ElementsAre("fault { direction: up message: 5 kind: delay delay_ms: 1 }",
                                "fault { direction: up message: 6 kind: delay delay_ms: 1 }"));
}

TEST(FaultEngine, ANamedFaultDoesNotMoveTheOthers) {
  auto expected = run(kSeeded, PlannedFault::down, 2000);
  const std::string named = "fault { direction: down message: 1 kind: link_loss }";
  ASSERT_THAT(expected, testing::Not(testing::Contains(HasSubstr("message: 1 "))));
  expected.insert(expected.begin(), named);
  EXPECT_EQ(run(named + kSeeded, PlannedFault::down, 2000), expected);
}

TEST(FaultEngine, PartsWithOneSeedAreIndependent) {
  const std::string part = "random { seed: 5 kinds: drop mean_messages: 50 direction: down }";
  const auto one = run(part, PlannedFault::down, 10'000), both = run(part + part, PlannedFault::down, 10'000);
  EXPECT_GT(both.size(), one.size() + one.size() / 2);
}

TEST(FaultEngine, ACorruptedBitLiesInTheFrame) {
  FaultEngine engine(plan("fault { direction: down message: 1 kind: corrupt bit: 1000000001 }"));
  const auto fault = engine.next(PlannedFault::down, 48);
  ASSERT_TRUE(fault.has_value());
  EXPECT_EQ(fault->bit(), 1'000'000'001u % (48 * 8));
}

TEST(FaultEngine, TheLogOfASeededPlanIsAPlanThatGivesTheSameFaults) {
  const auto log = run(kSeeded, PlannedFault::down, 3000);
  std::string text;
  for (const std::string& line : log) text += line + "\n";
  EXPECT_EQ(run(text, PlannedFault::down, 3000), log);
}

}  // namespace
}  // namespace gicube::emu
