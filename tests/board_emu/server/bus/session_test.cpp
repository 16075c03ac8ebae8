// A client that owns the board: transactions, faults, and how its session ends.
#include <sys/socket.h>

#include "gicube/wire/checksum.h"
#include "served_boards.h"
#include "session_frames.h"
#include "test.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using wire::ErrorCode;
using wire::FrameHeader;
using wire::FrameType;

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
  BusOptions options = patient();
  options.tokens = {{Right::kUse, "0123456789abcdef"}};
  BusServer server(options);
  const Endpoint endpoint = server.listen(slot, parse_endpoint("tcp:127.0.0.1:0"));
  ASSERT_NE(endpoint.port, 0);
  std::thread thread([&server] { server.run(); });
  {
    RawClient client = RawClient::connect_tcp(endpoint.port);
    client.handshake({}, "0123456789abcdef");
    EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
  }
  server.stop();
  thread.join();
}

}  // namespace
}  // namespace gicube::emu
