// What clients ask of checkpoints over the data plane, right and wrong. What a driver does with them:
// tests/system/save_test.cpp.
#include "session_frames.h"
#include "test.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using wire::CheckpointStep;
using wire::ErrorCode;
using wire::FrameType;
using Bytes = std::vector<std::uint8_t>;

reference::RawFrame ask(RawClient& client, CheckpointStep step, const Bytes& what = {}) {
  Bytes payload = word(static_cast<std::uint32_t>(step));
  payload.insert(payload.end(), what.begin(), what.end());
  auto answer = client.call(FrameType::kCheckpoint, 9, payload);
  if (!answer) throw std::runtime_error("the session has ended");
  return *answer;
}

std::string refusal(RawClient& client, CheckpointStep step, const Bytes& what = {}) {
  const auto answer = ask(client, step, what);
  return answer.header.error == ErrorCode::kBadValue ? answer.text() : "";
}

Bytes taken(RawClient& client, const Bytes& driver) {
  ask(client, CheckpointStep::kBegin);
  ask(client, CheckpointStep::kWrite, driver);
  const Bytes size = ask(client, CheckpointStep::kTake).payload;
  return ask(client, CheckpointStep::kRead, memory_request(0, wire::load<std::uint64_t>(size, 0))).payload;
}

TEST(SessionCheckpoint, ComesBackWithWhatTheDriverGaveAndWhatTheBoardHeld) {
  const ServedBoards boards(2);
  RawClient client = boards.open(), other = boards.open({}, 1);
  client.write_register(wire::reg::kSeed, 4711);
  const Bytes driver{1, 2, 3, 250}, bytes = taken(client, driver);
  client.write_register(wire::reg::kSeed, 1);
  constexpr std::size_t kPiece = 100'000;  // this client gives no credit back
  for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
    const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(std::min(bytes.size(), at + kPiece));
    ask(other, CheckpointStep::kWrite, {bytes.begin() + static_cast<std::ptrdiff_t>(at), end});
  }
  const auto answer = ask(other, CheckpointStep::kGoOn);
  ASSERT_EQ(answer.header.error, ErrorCode::kNone) << answer.text();
  const auto on = wire::decode<wire::WentOn>(answer.payload);
  EXPECT_EQ(on.driver_bytes, driver.size());
  EXPECT_EQ(on.fidelity, 1u);
  EXPECT_EQ(ask(other, CheckpointStep::kRead, memory_request(0, 4)).payload, driver);
  EXPECT_EQ(other.read_register(wire::reg::kSeed), 4711u);
}

TEST(SessionCheckpoint, IsRefusedWithTheReasonAndTheSessionGoesOn) {
  const ServedBoards boards;
  RawClient client = boards.open();
  client.write_register(wire::reg::kSeed, 7);
  EXPECT_EQ(refusal(client, static_cast<CheckpointStep>(6)), "checkpoint: step: expected 1 to 5, got 6");
  EXPECT_EQ(refusal(client, CheckpointStep::kTake, {1}), "checkpoint: payload: expected that of its step, got 5 bytes");
  EXPECT_EQ(refusal(client, CheckpointStep::kGoOn),
            "checkpoint: restore: expected a board process with --restore, or a checkpoint's bytes, got neither");
  EXPECT_EQ(refusal(client, CheckpointStep::kRead, memory_request(0, 1)),
            "checkpoint: length: expected at most 0, got 1");
  EXPECT_EQ(refusal(client, CheckpointStep::kRead, memory_request(~std::uint64_t{0}, 1)),
            "checkpoint: length: expected at most 0, got 1");
  Bytes bytes = taken(client, {});
  bytes[bytes.size() / 2] ^= 1;
  ask(client, CheckpointStep::kBegin);
  ask(client, CheckpointStep::kWrite, bytes);
  EXPECT_THAT(refusal(client, CheckpointStep::kGoOn), HasSubstr("checkpoint: crc32c: expected "));
  EXPECT_EQ(client.read_register(wire::reg::kSeed), 7u);
  const auto answer = client.call(FrameType::kCheckpoint, 9, Bytes{1, 2});
  EXPECT_EQ(answer->text(), "checkpoint: step: expected 1 to 5, got 0");
}

TEST(SessionCheckpoint, TakesNoMoreMemoryThanResultsMay) {
  BusOptions options = patient();
  options.max_held_bytes = 20'000;
  const ServedBoards boards(1, options);
  RawClient client = boards.open();
  const std::string limit = "checkpoint: size: expected at most 20000 bytes (gicube-board --max-results), got more";
  EXPECT_EQ(refusal(client, CheckpointStep::kWrite, Bytes(20'001)), limit);
  ask(client, CheckpointStep::kWrite, Bytes(15'000));
  EXPECT_EQ(refusal(client, CheckpointStep::kWrite, Bytes(5'001)), limit);
  EXPECT_EQ(refusal(client, CheckpointStep::kTake), limit);  // a functional board alone is larger
  EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
}

// Else a client could give a shared process a plan that ends it.
TEST(SessionCheckpoint, BringsNoFaultPlanToAProcessThatOthersUse) {
  const ServedBoards boards(2);
  boards.slots[0]->faults().set_plan("fault { direction: down message: 900 kind: kill }");
  RawClient client = boards.open(), other = boards.open({}, 1);
  const Bytes bytes = taken(client, {});
  ask(other, CheckpointStep::kWrite, bytes);
  EXPECT_EQ(
      refusal(other, CheckpointStep::kGoOn),
      "checkpoint: host.faults.plan: expected the plan of this board process (gicube-board --faults), got another");
  EXPECT_EQ(boards.slots[1]->faults().info().plan_text, "");
  // Where it is in force already its counts go on.
  client.read_register(wire::reg::kId);
  const std::uint64_t before = boards.slots[0]->faults().info().messages_down;
  ask(client, CheckpointStep::kBegin);
  ask(client, CheckpointStep::kWrite, bytes);
  EXPECT_EQ(ask(client, CheckpointStep::kGoOn).header.error, ErrorCode::kNone);
  EXPECT_LT(boards.slots[0]->faults().info().messages_down, before);
}

TEST(SessionCheckpoint, IsNoMessageOfAFaultPlanAndTakesNoTime) {
  const ServedBoards boards;
  boards.slots[0]->faults().set_plan("fault { direction: down message: 2 kind: link_loss }");
  RawClient client = boards.open();
  for (int i = 0; i < 5; ++i) taken(client, {1});
  EXPECT_EQ(boards.slots[0]->faults().info().messages_down, 0u);
  EXPECT_EQ(boards.slots[0]->counters().simulated_ps, 0u);
}

// No file is read or written for it: whatever stands in the bytes.
TEST(SessionCheckpoint, LeavesTheFoldersOfTheProcessAlone) {
  const ServedBoards boards;
  RawClient client = boards.open();
  const auto files = [&boards] {
    const std::filesystem::directory_iterator all(boards.folder.path());
    return std::distance(begin(all), end(all));
  };
  const auto before = files();
  taken(client, Bytes{'/', 't', 'm', 'p'});
  EXPECT_EQ(files(), before);
}

}  // namespace
}  // namespace gicube::emu
