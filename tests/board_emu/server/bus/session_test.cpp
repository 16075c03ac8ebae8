// A client that owns the board: transactions, credits, faults, and how its session ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/socket.h>

#include <tuple>

#include "gicube/wire/checksum.h"
#include "served_boards.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using testing::HasSubstr;
using wire::ErrorCode;
using wire::FrameHeader;
using wire::FrameType;

std::vector<std::uint8_t> word(std::uint32_t value) {
  std::vector<std::uint8_t> bytes(4);
  wire::store(std::span(bytes), 0, value);
  return bytes;
}

std::vector<std::uint8_t> memory_request(std::uint64_t address, std::uint64_t length) {
  std::vector<std::uint8_t> bytes(16);
  wire::store(std::span(bytes), 0, address);
  wire::store(std::span(bytes), 8, length);
  return bytes;
}

// Every frame until the session's end; the last one is the last word.
std::optional<reference::RawFrame> last_frame(RawClient& client) {
  std::optional<reference::RawFrame> last;
  while (auto frame = client.receive()) last = std::move(frame);
  return last;
}

void expect_ended(RawClient& client, ErrorCode error, std::uint32_t id, const char* words) {
  const auto last = last_frame(client);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.type, FrameType::kVersion);
  EXPECT_EQ(last->header.flags, wire::kResponse);
  EXPECT_EQ(last->header.error, error);
  EXPECT_EQ(last->header.id, id);
  EXPECT_THAT(last->text(), HasSubstr(words));
}

wire::VersionInfo with_progress() {
  wire::VersionInfo mine;
  mine.capabilities = wire::kProgressFrames;
  return mine;
}

std::optional<reference::RawFrame> first_progress(RawClient& client) {
  for (;;) {
    auto frame = client.receive();
    if (!frame || frame->header.type == FrameType::kProgress) return frame;
  }
}

TEST(Session, ARequestGetsAResponseWithItsIdTypeAndTime) {
  const ServedBoards boards;
  RawClient client = boards.open();
  FrameHeader header;
  header.type = FrameType::kRegisterRead;
  header.id = 4711;
  header.time_ps = 1'000'000;
  client.send(header, word(wire::reg::kId));
  const auto answer = client.receive_answer();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->header.type, FrameType::kRegisterRead);
  EXPECT_EQ(answer->header.flags, wire::kResponse);
  EXPECT_EQ(answer->header.id, 4711u);
  EXPECT_GT(answer->header.time_ps, 1'000'000u);
  EXPECT_EQ(answer->payload, word(wire::kIdValue));
}

TEST(Session, ARefusedRequestCarriesTextAndTheSessionGoesOn) {
  const ServedBoards boards;
  RawClient client = boards.open();
  const auto answer = client.call(FrameType::kMemoryRead, 5, memory_request(0xFFFF'FFFF'0000, 16));
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->header.type, FrameType::kMemoryRead);
  EXPECT_EQ(answer->header.error, ErrorCode::kBadAddress);
  EXPECT_FALSE(answer->text().empty());
  EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
}

TEST(Session, PipelinedFramesAreAnsweredInOrder) {
  const ServedBoards boards;
  RawClient client = boards.open();
  for (std::uint32_t i = 1; i <= 20; ++i) {
    client.write_register(wire::reg::kStep, wire::kStepOne + i);
    client.send(FrameType::kRegisterRead, i, 0, word(wire::reg::kStep));
  }
  for (std::uint32_t i = 1; i <= 20; ++i) {
    const auto answer = client.receive_answer();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->header.id, i);
    EXPECT_EQ(answer->payload, word(wire::kStepOne + i));
  }
}

TEST(Session, FramesMayComeByteByByte) {
  const ServedBoards boards;
  RawClient client = boards.open();
  FrameHeader header;
  header.type = FrameType::kRegisterRead;
  header.size = 4;
  header.sequence = 1;
  std::vector<std::uint8_t> bytes(wire::kFrameHeaderBytes);
  wire::encode_sealed(header, word(wire::reg::kId), std::span(bytes).first<wire::kFrameHeaderBytes>());
  for (const std::uint8_t byte : word(wire::reg::kId)) bytes.push_back(byte);
  for (const std::uint8_t& byte : bytes) client.send_bytes({&byte, 1});
  EXPECT_EQ(client.receive_answer()->payload, word(wire::kIdValue));
}

TEST(Session, ACompletionComesBeforeTheReplyThatWaitedForIt) {
  const ServedBoards boards;
  RawClient client = boards.open();
  client.send(FrameType::kCommand, 31, wire::kPosted, word(99));  // no such opcode
  client.send(FrameType::kWait, 32, 0, word(31));
  const auto completion = client.receive_answer(), reply = client.receive_answer();
  ASSERT_TRUE(completion && reply);
  EXPECT_EQ(completion->header.type, FrameType::kCompletion);
  EXPECT_EQ(completion->header.id, 31u);
  EXPECT_EQ(completion->header.error, ErrorCode::kBadValue);
  EXPECT_THAT(completion->text(), HasSubstr("opcode"));
  EXPECT_EQ(reply->header.type, FrameType::kWait);
  EXPECT_EQ(reply->header.id, 32u);
}

TEST(Session, GarbageEndsItWithAWordAndTheBoardServesTheNextClient) {
  const ServedBoards boards;
  {
    RawClient client = boards.open();
    client.send_bytes(std::vector<std::uint8_t>(1000, 0xAB));
    expect_ended(client, ErrorCode::kCorrupted, 0, "got 0xabababab");
  }
  EXPECT_TRUE(serves_afresh(boards));
}

TEST(Session, AFrameOfFourGigabytesIsRefusedByItsHeader) {
  const ServedBoards boards;
  {
    RawClient client = boards.open();
    FrameHeader header;
    header.type = FrameType::kMemoryWrite;
    header.flags = wire::kPosted;
    header.id = 8;
    header.size = 0xFFFF'FFFF;
    std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
    wire::encode(header, bytes);
    client.send_bytes(bytes);
    expect_ended(client, ErrorCode::kTooLarge, 8, "at most 4194304 payload bytes, got 4294967295");
  }
  EXPECT_TRUE(serves_afresh(boards));
}

TEST(Session, TheSmallerPayloadLimitHolds) {
  const ServedBoards boards;
  wire::VersionInfo mine;
  mine.max_payload_bytes = 4096;
  RawClient client = boards.open(mine);
  client.send(FrameType::kMemoryWrite, 8, wire::kPosted, std::vector<std::uint8_t>(4097));
  expect_ended(client, ErrorCode::kTooLarge, 8, "at most 4096");
}

TEST(Session, AReadBeyondThePayloadLimitIsRefusedBeforeMemoryIsTaken) {
  const ServedBoards boards;
  RawClient client = boards.open();
  client.send(FrameType::kMemoryRead, 9, 0, memory_request(wire::kFramebuffer.base, std::uint64_t{1} << 40));
  expect_ended(client, ErrorCode::kTooLarge, 9, "a read of at most 4194304 bytes");
}

TEST(Session, FramesThatAHostMustNotSendEndIt) {
  const ServedBoards boards;
  for (const FrameType type : {FrameType::kCompletion, FrameType::kProgress, FrameType::kVersion}) {
    RawClient client = boards.open();
    client.send(type, 3, 0, {});
    expect_ended(client, ErrorCode::kProtocol, 3, "expected a request");
  }
  RawClient responder = boards.open();
  responder.send(FrameType::kRegisterRead, 4, wire::kResponse, word(0));
  expect_ended(responder, ErrorCode::kProtocol, 4, "expected flags 0");
  responder.close();
  RawClient unposted = boards.open();
  unposted.send(FrameType::kCommand, 5, 0, word(1));
  expect_ended(unposted, ErrorCode::kProtocol, 5, "expected flags 2");
}

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

TEST(Session, OneTicketForAllCommandsEndsItAtTheSecond) {
  const ServedBoards boards;
  RawClient client = boards.open();
  for (int i = 0; i < 3; ++i) client.send(FrameType::kCommand, 7, wire::kPosted, word(99));
  expect_ended(client, ErrorCode::kProtocol, 7, "ticket: expected one that no command under way has, got 7");
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

TEST(Session, AClientThatVanishesInTheMiddleOfALoadLeavesAFreshBoard) {
  const ServedBoards boards;
  {
    RawClient client = boards.open();
    client.write_register(wire::reg::kVolumeX, 64);
    FrameHeader header;
    header.type = FrameType::kMemoryWrite;
    header.flags = wire::kPosted;
    header.size = 1 << 20;
    std::vector<std::uint8_t> bytes(wire::kFrameHeaderBytes + 1000);
    wire::encode(header, bytes);
    client.send_bytes(bytes);
  }
  EXPECT_TRUE(serves_afresh(boards));
}

TEST(Session, LongWorkShowsItsProgress) {
  const ServedBoards boards;
  RawClient client = boards.open(with_progress());
  post_long_command(client, 12);
  const auto frame = first_progress(client);
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(frame->header.id, 12u);
  ASSERT_EQ(frame->payload.size(), 8u);
  const auto done = wire::load<std::uint32_t>(frame->payload, 0), all = wire::load<std::uint32_t>(frame->payload, 4);
  EXPECT_LT(done, all);
}

TEST(Session, AClientThatVanishesDuringLongWorkFreesTheBoard) {
  const ServedBoards boards;
  {
    RawClient client = boards.open(with_progress());
    post_long_command(client, 1);
    ASSERT_TRUE(first_progress(client).has_value());
  }
  EXPECT_TRUE(serves_afresh(boards));
}

TEST(Session, StoppingTheServerCancelsTheWorkAndTellsTheClient) {
  ServedBoards boards;
  RawClient client = boards.open();
  post_long_command(client, 1);
  boards.stop();
  expect_ended(client, ErrorCode::kCancelled, 0, "shuts down");
}

TEST(Session, APrivateServerEndsWithItsOnlySession) {
  int pair[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, pair), 0);
  BoardSlot slot(0, {});
  BusServer server(patient());
  server.adopt(slot, pair[0], true);
  std::thread host([fd = pair[1]] {
    RawClient client(fd);
    client.handshake();
    EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
  });
  server.run();  // returns
  host.join();
}

TEST(Session, WorksOverTcp) {
  BoardSlot slot(0, {});
  BusServer server(patient());
  const Endpoint endpoint = server.listen(slot, parse_endpoint("tcp:127.0.0.1:0"));
  ASSERT_NE(endpoint.port, 0);
  std::thread thread([&server] { server.run(); });
  {
    RawClient client = RawClient::connect_tcp(endpoint.port);
    client.handshake();
    EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
  }
  server.stop();
  thread.join();
}

}  // namespace
}  // namespace gicube::emu
