// What a session may have under way: frames in the window, results that nobody fetches, credit.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "session_frames.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using testing::HasSubstr;
using wire::ErrorCode;
using wire::FrameHeader;
using wire::FrameType;

TEST(Session, MoreFramesThanTheWindowHoldsEndIt) {
  BusOptions options = patient();
  options.version.window_slots = 16;
  const ServedBoards boards(1, options);
  RawClient client = boards.open();
  post_long_command(client, 1);  // keeps the board from consuming what follows
  for (std::uint32_t id = 2; id < 20; ++id) client.send(FrameType::kPoll, id, 0, {});
  const auto last = last_frame(client);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.error, ErrorCode::kProtocol);
  EXPECT_THAT(last->text(), HasSubstr("at most 16 frames"));
}

TEST(Session, ResultsThatNobodyFetchesEndItBeforeTheyFillTheMemory) {
  BusOptions options = patient();
  options.max_held_bytes = 4096;
  const ServedBoards boards(1, options);
  RawClient client = boards.open();
  std::uint32_t id = 100;
  for (int i = 0; i < 10; ++i) {  // fetched as they come: no end to them
    client.send(FrameType::kCommand, ++id, wire::kPosted, word(99));
    client.send(FrameType::kWait, 1, 0, word(id));
    const auto completion = client.receive_answer();
    EXPECT_EQ(completion->header.id, id);
    EXPECT_EQ(client.receive_answer()->header.id, 1u);
    FrameHeader taken;
    taken.type = FrameType::kCredit;
    taken.flags = wire::kPosted;
    taken.credit_slots = 2;
    taken.credit_bytes = completion->payload.size();
    client.send(taken);
  }
  for (int i = 0; i < 4; ++i) client.send(FrameType::kCommand, ++id, wire::kPosted, word(99));
  expect_ended(client, ErrorCode::kTooLarge, id, "at most 4096 bytes of results");
}

TEST(Session, ACommandThatTakesTooLongEndsIt) {
  Audit audit;
  BusOptions options = patient();
  options.max_command_time = std::chrono::milliseconds(20);
  options.audit = &audit;
  const ServedBoards boards(1, options);
  {
    RawClient client = boards.open();
    post_long_command(client, 7);
    client.send(FrameType::kWait, 1, 0, word(7));
    std::optional<reference::RawFrame> last;
    do last = client.receive_answer();
    while (last && last->header.type != FrameType::kVersion);
    ASSERT_TRUE(last.has_value());
    EXPECT_EQ(last->header.error, ErrorCode::kTooLarge);
    EXPECT_THAT(last->text(), testing::HasSubstr("a command that takes at most 0.02 s of this machine's time"));
  }
  EXPECT_TRUE(serves_afresh(boards));
  EXPECT_EQ(audit.counts().back().count, 1u);
}

TEST(Session, IsAuditedByWhoHasItAndOnWhichBoard) {
  const reference::TemporaryDirectory folder;
  Audit::Options to_file;
  to_file.file = folder.file("audit");
  {
    Audit audit(to_file);
    BusOptions options = patient();
    options.audit = &audit;
    const ServedBoards boards(2, options);
    EXPECT_EQ(boards.open({}, 1).read_register(wire::reg::kId), wire::kIdValue);
  }
  std::ifstream file(to_file.file);
  const std::string lines(std::istreambuf_iterator<char>(file), {});
  const std::string me = fmt::format("process {}: board 1: ", ::getpid());
  EXPECT_THAT(lines, HasSubstr("opened: " + me + "a session begins"));
  EXPECT_THAT(lines, HasSubstr("closed: " + me + "the session has ended"));
}

TEST(Session, OneTicketForAllCommandsEndsItAtTheSecond) {
  const ServedBoards boards;
  RawClient client = boards.open();
  for (int i = 0; i < 3; ++i) client.send(FrameType::kCommand, 7, wire::kPosted, word(99));
  expect_ended(client, ErrorCode::kProtocol, 7, "ticket: expected one that no command in progress has, got 7");
}

TEST(Session, ATicketMayComeAgainOnceItsCompletionHasCome) {
  const ServedBoards boards;
  RawClient client = boards.open();
  for (int i = 0; i < 3; ++i) {
    client.send(FrameType::kCommand, 7, wire::kPosted, word(99));
    client.send(FrameType::kWait, 8, 0, word(7));
    EXPECT_EQ(client.receive_answer()->header.type, FrameType::kCompletion);
    EXPECT_EQ(client.receive_answer()->header.id, 8u);
  }
}

// 512 blocks: 2 KiB of checksums for a command of 16 bytes.
TEST(Session, ResultsCountByWhatTheyTakeAndNotByWhatWasSentForThem) {
  BusOptions options = patient();
  options.max_held_bytes = 32 << 10;
  const ServedBoards boards(1, options);
  RawClient client = boards.open();
  for (const std::uint32_t axis : {wire::reg::kVolumeX, wire::reg::kVolumeY, wire::reg::kVolumeZ}) {
    client.write_register(axis, 256);
  }
  std::vector<std::uint8_t> verify(wire::kVerifyCommandBytes);
  wire::store(std::span(verify), 0, static_cast<std::uint32_t>(wire::Opcode::kVerify));
  wire::store(std::span(verify), 8, std::uint32_t{512});
  for (std::uint32_t id = 1; id <= 20; ++id) client.send(FrameType::kCommand, id, wire::kPosted, verify);
  const auto last = last_frame(client);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.error, ErrorCode::kTooLarge);
  EXPECT_GE(last->header.id, 10u);  // of 3 KiB each, bookkeeping included
  EXPECT_LE(last->header.id, 16u);
}

TEST(Session, AnswersThatTheClientNeverTakesEndItHoweverLargeItsWindowIs) {
  BusOptions options = patient();
  options.max_held_bytes = 1 << 20;
  const ServedBoards boards(1, options);
  wire::VersionInfo greedy;
  greedy.window_slots = ~0u;
  greedy.window_bytes = ~std::uint64_t{0};
  RawClient client = boards.open(greedy);
  constexpr std::uint64_t kTable = wire::kSegmentationLut.bytes;  // 192 KiB
  for (std::uint32_t id = 1; id <= 8; ++id) {
    client.send(FrameType::kMemoryRead, id, 0, memory_request(wire::kSegmentationLut.base, kTable));
  }
  expect_ended(client, ErrorCode::kTooLarge, 7, "at most 1048576 bytes of results");
}

// More than the socket holds, so that one write waits while the next answers come.
TEST(Session, AnswersThatAClientTakesLateComeWholeAndInOrder) {
  const ServedBoards boards;
  wire::VersionInfo greedy;
  greedy.window_slots = ~0u;
  greedy.window_bytes = ~std::uint64_t{0};
  RawClient client = boards.open(greedy);
  constexpr std::uint32_t kAnswers = 40;
  const auto table = [](std::uint32_t i) { return wire::kSegmentationLut.bytes - 16 * i; };
  for (std::uint32_t i = 1; i <= kAnswers; ++i) {
    client.send(FrameType::kMemoryRead, i, 0, memory_request(wire::kSegmentationLut.base, table(i)));
  }
  while (boards.server.quotas().at(1).used < kAnswers * std::uint64_t{table(kAnswers)}) std::this_thread::yield();
  for (std::uint32_t i = 1; i <= kAnswers; ++i) {
    const auto answer = client.receive();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->header.id, i);
    EXPECT_EQ(answer->header.error, ErrorCode::kNone);
    EXPECT_EQ(answer->payload, std::vector<std::uint8_t>(table(i)));
  }
}

TEST(Session, SmallAnswersThatTheClientNeverTakesCountWithTheirFrames) {
  BusOptions options = patient();
  options.max_held_bytes = 64 << 10;
  const ServedBoards boards(1, options);
  wire::VersionInfo greedy;
  greedy.window_slots = ~0u;
  RawClient client = boards.open(greedy);
  std::uint32_t answers = 0;
  std::optional<reference::RawFrame> last;
  while (answers < 1000 && (!last || last->header.error == ErrorCode::kNone)) {
    last = client.call(FrameType::kRegisterRead, ++answers, word(wire::reg::kId));
    ASSERT_TRUE(last.has_value());
  }
  EXPECT_EQ(last->header.error, ErrorCode::kTooLarge);
  EXPECT_GT(answers, 128u);
  EXPECT_LT(answers, 260u);
}

TEST(Session, CreditThatWasNeverTakenEndsIt) {
  const ServedBoards boards;
  RawClient client = boards.open();
  FrameHeader header;
  header.type = FrameType::kCredit;
  header.flags = wire::kPosted;
  header.id = 6;
  header.credit_slots = 1;
  client.send(header);
  expect_ended(client, ErrorCode::kProtocol, 6, "expected credit for at most 0 frames");
}

// Two answers of four bytes are under way to the client.
TEST(Session, CreditIsForWholeFramesThatWereSent) {
  const ServedBoards boards;
  for (const auto& [slots, bytes, words] : {std::tuple{1u, 100u, "at most 2 frames and 4 bytes, got 1 and 100"},
                                            {3u, 0u, "2 frames and 8 bytes, got 3 and 0"}}) {
    RawClient client = boards.open();
    for (std::uint32_t id = 1; id <= 2; ++id) client.call(FrameType::kRegisterRead, id, word(wire::reg::kId));
    FrameHeader header;
    header.type = FrameType::kCredit;
    header.flags = wire::kPosted;
    header.id = 6;
    header.credit_slots = static_cast<decltype(header.credit_slots)>(slots);
    header.credit_bytes = bytes;
    client.send(header);
    expect_ended(client, ErrorCode::kProtocol, 6, words);
  }
}

TEST(Session, TheBoardKeepsToTheClientsWindowUntilCreditReturns) {
  const ServedBoards boards;
  wire::VersionInfo mine;
  mine.window_slots = 2;
  RawClient client = boards.open(mine);
  for (std::uint32_t id = 1; id <= 3; ++id) client.send(FrameType::kRegisterRead, id, 0, word(wire::reg::kId));
  EXPECT_EQ(client.receive_answer()->header.id, 1u);
  EXPECT_EQ(client.receive_answer()->header.id, 2u);
  // The third answer waits. The board says so by handing back what it has consumed; then nothing more can come.
  FrameHeader credit;
  credit.type = FrameType::kCredit;
  credit.flags = wire::kPosted;
  credit.credit_slots = 1;
  credit.credit_bytes = 4;
  client.send(credit);
  EXPECT_EQ(client.receive_answer()->header.id, 3u);
}

TEST(Session, TheClientsCreditComesBackInFull) {
  const ServedBoards boards;
  RawClient client = boards.open();
  const wire::VersionInfo board = board_version();
  std::vector<std::uint8_t> block(std::size_t{1} << 20);
  wire::store(std::span(block), 0, wire::kVolume.base);
  wire::SendCredits credits({board.window_slots, board.window_bytes});
  // Three windows' worth of bytes: it ends only if the board hands credit back.
  for (int i = 0; i < 48; ++i) {
    while (!credits.can_send(block.size())) {
      const auto frame = client.receive();
      ASSERT_TRUE(frame.has_value());
      EXPECT_EQ(frame->header.type, FrameType::kCredit);
      credits.give_back({frame->header.credit_slots, frame->header.credit_bytes});
    }
    credits.take(block.size());
    client.send(FrameType::kMemoryWrite, 0, wire::kPosted, block);
  }
  EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
}

}  // namespace
}  // namespace gicube::emu
