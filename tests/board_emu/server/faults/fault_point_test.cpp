#include "server/faults/fault_point.h"

#include "server/faults/fault_plan.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

using namespace std::chrono_literals;

std::vector<std::string> texts(const std::vector<v1::PlannedFault>& log) {
  std::vector<std::string> lines;
  for (const v1::PlannedFault& fault : log) lines.push_back(to_text(fault));
  return lines;
}

TEST(FaultPoint, WithoutAPlanNothingHappensAndNothingIsCounted) {
  FaultPoint point;
  EXPECT_FALSE(point.taken(100).any());
  EXPECT_FALSE(point.sent(100).any());
  EXPECT_EQ(point.info().messages_down, 0u);
}

TEST(FaultPoint, SaysWhatBecomesOfEachMessage) {
  FaultPoint point;
  ASSERT_EQ(to_string(point.set_plan(R"(
      fault { direction: down message: 1 kind: drop }
      fault { direction: down message: 2 kind: delay delay_ms: 20 }
      fault { direction: down message: 3 kind: corrupt bit: 7 }
      fault { direction: down message: 4 kind: duplicate }
      fault { direction: down message: 5 kind: hang }
      fault { direction: down message: 6 kind: link_loss }
      fault { direction: down message: 7 kind: memory_silent block: 3 bit: 9 }
      fault { direction: down message: 8 kind: memory_detected })")),
            "");
  EXPECT_TRUE(point.taken(100).drop);
  EXPECT_EQ(point.taken(100).pause, 20ms);
  EXPECT_EQ(point.taken(100).flipped_bit, 7u);
  EXPECT_TRUE(point.taken(100).twice);
  EXPECT_TRUE(point.taken(100).hang);
  EXPECT_TRUE(point.taken(100).cut);
  const auto silent = point.taken(100).memory_error;
  ASSERT_TRUE(silent.has_value());
  EXPECT_EQ(silent->block, 3u);
  EXPECT_EQ(silent->bit, 9u);
  EXPECT_FALSE(silent->detected);
  EXPECT_TRUE(point.taken(100).memory_error.value().detected);
  EXPECT_FALSE(point.taken(100).any());
  EXPECT_FALSE(point.sent(100).any());
  EXPECT_EQ(point.info().messages_down, 9u);
  EXPECT_EQ(point.info().messages_up, 1u);
  EXPECT_EQ(point.info().faults, 8u);
}

TEST(FaultPoint, ASlowClientHoldsUpTheMessagesOfItsDirection) {
  FaultPoint point;
  point.set_plan("fault { direction: up message: 2 kind: slow bytes_per_second: 10000 messages: 2 }");
  EXPECT_EQ(point.sent(100).pause, 0us);
  EXPECT_EQ(point.sent(100).pause, 10ms);
  EXPECT_EQ(point.taken(100).pause, 0us);
  EXPECT_EQ(point.sent(50).pause, 5ms);
  EXPECT_EQ(point.sent(50).pause, 0us);
}

TEST(FaultPoint, TheLogIsSortedAndCanBeCleared) {
  FaultPoint point;
  const std::string down = "fault { direction: down message: 2 kind: drop }";
  const std::string up = "fault { direction: up message: 1 kind: drop }";
  point.set_plan(up + down);
  point.sent(100);
  point.taken(100);
  point.taken(100);
  EXPECT_THAT(texts(point.log(false).faults), ElementsAre(down, up));
  EXPECT_THAT(texts(point.log(true).faults), ElementsAre(down, up));
  EXPECT_THAT(texts(point.log(false).faults), ElementsAre());
  EXPECT_EQ(point.info().faults, 2u);
  EXPECT_FALSE(point.taken(100).any());
}

TEST(FaultPoint, ANewPlanCountsFromOneAndAFaultyOneChangesNothing) {
  FaultPoint point;
  const std::string plan = "fault { direction: down message: 2 kind: drop }";
  point.set_plan(plan);
  point.taken(100);
  EXPECT_FALSE(point.set_plan("fault { kind: oops }").empty());
  EXPECT_EQ(point.info().plan_text, plan);
  EXPECT_TRUE(point.taken(100).drop);
  EXPECT_TRUE(point.set_plan(plan).empty());
  EXPECT_FALSE(point.taken(100).drop);
  EXPECT_TRUE(point.taken(100).drop);
  EXPECT_EQ(point.log(false).faults.size(), 1u);
  EXPECT_TRUE(point.set_plan("").empty());
  EXPECT_FALSE(point.taken(100).any());
  EXPECT_EQ(point.info().plan_text, "");
}

TEST(FaultPoint, TheFileHasTheLogAsPlanTextAndIsAppendedTo) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("faults.log");
  const std::string line = "fault { direction: up message: 1 kind: duplicate }";
  for (int i = 0; i < 2; ++i) {
    FaultPoint point;
    point.set_plan(line);
    point.append_log_to(path);
    point.sent(100);
  }
  EXPECT_EQ(text_of(path), line + "\n" + line + "\n");
  FaultPoint point;
  EXPECT_THROW(point.append_log_to(folder.file("none/faults.log")), std::runtime_error);
}

TEST(FaultPoint, TheLogHoldsTheFirstFaultsAndCountsTheOthers) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("faults.log");
  const auto line = [](int message) {
    return "fault { direction: down message: " + std::to_string(message) + " kind: drop }\n";
  };
  std::string plan;
  for (int message = 1; message <= 6; ++message) plan += line(message);
  FaultPoint point(2, 3);
  ASSERT_EQ(to_string(point.set_plan(plan)), "");
  point.append_log_to(path);
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(point.taken(100).drop);
  const FaultPoint::Log log = point.log(true);
  ASSERT_EQ(log.faults.size(), 2u);
  EXPECT_EQ(log.faults[1].message(), 2u);
  EXPECT_EQ(log.left_out, 4u);
  EXPECT_EQ(point.info().faults, 6u);
  EXPECT_EQ(point.log(false).left_out, 0u);
  EXPECT_EQ(text_of(path), line(1) + line(2) + line(3) + "# more than 3 faults: those from here on are missing\n");
}

TEST(FaultPoint, AKillIsInTheFileBeforeItTakesEffect) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("faults.log");
  const std::string line = "fault { direction: down message: 1 kind: kill }";
  FaultPoint point;
  point.set_plan(line);
  point.append_log_to(path);
  EXPECT_TRUE(point.taken(100).kill);
  EXPECT_EQ(text_of(path), line + "\n");
}

TEST(FaultPoint, GoesOnWhereASavedOneWas) {
  FaultPoint point;
  point.set_plan(
      "random { seed: 4 kinds: [drop, corrupt, memory_silent] mean_messages: 5 max_faults: 9 }\n"
      "fault { direction: down message: 20 kind: slow bytes_per_second: 1000000 messages: 5 }");
  for (int i = 0; i < 22; ++i) point.taken(100);
  FaultPoint other;
  other.restore(point.saved());
  EXPECT_EQ(other.info().plan_text, point.info().plan_text);
  EXPECT_EQ(other.info().messages_down, 22u);
  EXPECT_EQ(other.info().faults, point.info().faults);
  for (int i = 0; i < 200; ++i) {
    const FaultAction a = point.taken(100), b = other.taken(100);
    EXPECT_EQ(a.pause, b.pause) << i;
    EXPECT_EQ(a.drop, b.drop) << i;
    EXPECT_EQ(a.flipped_bit, b.flipped_bit) << i;
    EXPECT_EQ(a.memory_error.has_value(), b.memory_error.has_value()) << i;
  }
}

TEST(FaultPoint, RefusesCountsThatItsPlanCannotHave) {
  FaultPoint point;
  point.set_plan("random { seed: 4 kinds: [drop] mean_messages: 5 }");
  const SavedFaults good = point.saved();
  const auto refusal = [&point](const SavedFaults& saved) -> std::string {
    return message_of<CheckpointFault>([&] { point.restore(saved); });
  };
  SavedFaults bad = good;
  bad.counts.hits.push_back(3);
  EXPECT_EQ(refusal(bad),
            "checkpoint: host.faults.hits: expected one number for each random part of the plan and direction, got 3");
  bad = good;
  bad.slow[0] = {0, 7};
  EXPECT_EQ(refusal(bad), "checkpoint: host.faults.slow: expected 1 or more bytes a second, got 0");
  bad = good;
  bad.plan_text = "random { }";
  EXPECT_THAT(refusal(bad), HasSubstr("checkpoint: host.faults.plan: line 1: random[0].kinds: expected"));
  EXPECT_EQ(refusal(good), "none");
}

}  // namespace
}  // namespace gicube::emu
