// What a client sees of each kind of fault, message by message.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "served_boards.h"
#include "server/faults/fault_plan.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using reference::RawFrame;
using wire::ErrorCode;
using wire::FrameType;
namespace reg = wire::reg;

// A board with one fault; the client's messages are register accesses.
class SessionFault : public testing::Test {
 protected:
  RawClient open(const std::string& fault) {
    EXPECT_EQ(to_string(boards.slots[0]->faults().set_plan("fault { " + fault + " }")), "");
    return boards.open();
  }
  std::optional<RawFrame> read_id(RawClient& client, std::uint32_t frame_id) {
    std::array<std::uint8_t, 4> payload{};
    wire::store(std::span<std::uint8_t>(payload), 0, reg::kId);
    return client.call(FrameType::kRegisterRead, frame_id, payload);
  }
  std::vector<std::string> log() {
    std::vector<std::string> lines;
    for (const v1::PlannedFault& fault : boards.slots[0]->faults().log(false).faults) lines.push_back(to_text(fault));
    return lines;
  }

  ServedBoards boards;
};

TEST_F(SessionFault, ALostMessageShowsAsAGapAtTheNext) {
  RawClient client = open("direction: down message: 2 kind: drop");
  EXPECT_EQ(client.read_register(reg::kId), wire::kIdValue);
  client.write_register(reg::kVolumeX, 64);
  const auto last = read_id(client, 9);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.error, ErrorCode::kCorrupted);
  EXPECT_THAT(last->text(), testing::HasSubstr("expected frame number 2, got 3"));
  EXPECT_THAT(log(), testing::ElementsAre("fault { direction: down message: 2 kind: drop }"));
}

TEST_F(SessionFault, AMessageLostOnItsWayUpLeavesAGapThere) {
  RawClient client = open("direction: up message: 2 kind: drop");
  EXPECT_EQ(read_id(client, 1)->header.sequence, 1u);
  std::array<std::uint8_t, 4> payload{};
  wire::store(std::span<std::uint8_t>(payload), 0, reg::kId);
  client.send(FrameType::kRegisterRead, 2, 0, payload);
  const auto third = read_id(client, 3);
  ASSERT_TRUE(third.has_value());
  EXPECT_EQ(third->header.id, 3u);
  EXPECT_EQ(third->header.sequence, 3u);
}

TEST_F(SessionFault, ADelayedMessageComesAllTheSame) {
  for (const std::string direction : {"down", "up"}) {
    RawClient client = open("direction: " + direction + " message: 1 kind: delay delay_ms: 30");
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(client.read_register(reg::kId), wire::kIdValue);
    EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(30)) << direction;
  }
}

TEST_F(SessionFault, ADamagedMessageIsKnownByItsChecksum) {
  for (const int bit : {0, 8 * 20, 8 * 48 + 3}) {  // magic, credit, payload
    RawClient client = open("direction: down message: 1 kind: corrupt bit: " + std::to_string(bit));
    const auto last = read_id(client, 9);
    ASSERT_TRUE(last.has_value());
    EXPECT_EQ(last->header.error, ErrorCode::kCorrupted) << bit;
    EXPECT_THAT(last->text(), testing::HasSubstr("expected the checksum")) << bit;
  }
  {
    RawClient client = open("direction: up message: 1 kind: corrupt bit: 390");
    EXPECT_THROW(read_id(client, 9), std::runtime_error);
  }
  RawClient client = open("direction: up message: 1 kind: corrupt bit: 0");
  EXPECT_THAT([&] { read_id(client, 9); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("something that is no frame")))
      << "bits are counted from the header on";
}

TEST_F(SessionFault, ADoubledMessageIsTakenOnceAndSentTwice) {
  {
    RawClient client = open("direction: down message: 1 kind: duplicate");
    client.write_register(reg::kVolumeX, 64);
    EXPECT_EQ(client.read_register(reg::kVolumeX), 64u);
  }
  RawClient client = open("direction: up message: 1 kind: duplicate");
  const auto first = read_id(client, 9), second = client.receive_answer();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->header.sequence, 1u);
  EXPECT_EQ(second->header.sequence, 1u);
  EXPECT_EQ(first->payload, second->payload);
  EXPECT_EQ(client.read_register(reg::kId), wire::kIdValue);
}

TEST_F(SessionFault, AHangingBoardIsSilentUntilTheConnectionEnds) {
  for (const std::string direction : {"down", "up"}) {
    {
      RawClient client = open("direction: " + direction + " message: 2 kind: hang");
      EXPECT_EQ(client.read_register(reg::kId), wire::kIdValue);
      for (int i = 0; i < 20; ++i) client.write_register(reg::kVolumeX, 64);
      std::array<std::uint8_t, 4> payload{};
      client.send(FrameType::kRegisterRead, 3, 0, payload);
      client.send(FrameType::kRegisterRead, 4, 0, payload);
      client.end_sending();
      EXPECT_FALSE(client.receive_answer().has_value()) << direction;
    }
    boards.slots[0]->faults().set_plan("");
    EXPECT_TRUE(serves_afresh(boards));
  }
}

TEST_F(SessionFault, ALostLinkHasNoLastWord) {
  for (const std::string direction : {"down", "up"}) {
    RawClient client = open("direction: " + direction + " message: 1 kind: link_loss");
    EXPECT_FALSE(read_id(client, 1).has_value()) << direction;
  }
}

TEST_F(SessionFault, ASlowLinkTakesItsTimeForTheBytes) {
  // 52 bytes at 1000 a second: the second and the third answer.
  RawClient client = open("direction: up message: 2 kind: slow bytes_per_second: 1000 messages: 2");
  EXPECT_EQ(client.read_register(reg::kId), wire::kIdValue);
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(client.read_register(reg::kId), wire::kIdValue);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(104));
}

TEST_F(SessionFault, AMemoryErrorComesBeforeItsMessage) {
  RawClient client = open("direction: down message: 4 kind: memory_detected");
  for (const std::uint32_t axis : {reg::kVolumeX, reg::kVolumeY, reg::kVolumeZ}) client.write_register(axis, 16);
  std::vector<std::uint8_t> payload(wire::kVerifyCommandBytes);
  wire::store(std::span(payload), 0, static_cast<std::uint32_t>(wire::Opcode::kVerify));
  wire::store(std::span(payload), 8, std::uint32_t{1});
  for (const ErrorCode expected : {ErrorCode::kMemory, ErrorCode::kNone}) {
    client.send(FrameType::kCommand, 7, wire::kPosted, payload);
    std::array<std::uint8_t, 4> ticket{};
    wire::store(std::span<std::uint8_t>(ticket), 0, std::uint32_t{7});
    client.send(FrameType::kWait, 8, 0, ticket);
    const auto completion = client.receive_answer();
    ASSERT_TRUE(completion.has_value());
    EXPECT_EQ(completion->header.type, FrameType::kCompletion);
    EXPECT_EQ(completion->header.error, expected);
    client.receive_answer();
  }
}

TEST_F(SessionFault, MessagesAreCountedOverAllSessions) {
  open("direction: down message: 3 kind: link_loss").read_register(reg::kId);
  RawClient second = boards.open();
  EXPECT_EQ(second.read_register(reg::kId), wire::kIdValue);
  EXPECT_FALSE(read_id(second, 1).has_value());
  EXPECT_TRUE(serves_afresh(boards));
}

}  // namespace
}  // namespace gicube::emu
