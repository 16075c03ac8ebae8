// Before a client owns the board: what it may send, and what it is told.
#include "gicube/wire/checksum.h"
#include "served_boards.h"
#include "test.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using reference::RawFrame;
using wire::ErrorCode;
using wire::FrameType;

// The answer carries the error and a text with `words`, and is the last thing that comes.
void expect_last_word(RawClient& client, const std::optional<RawFrame>& answer, ErrorCode error, const char* words) {
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->header.type, FrameType::kVersion);
  EXPECT_EQ(answer->header.flags, wire::kResponse);
  EXPECT_EQ(answer->header.error, error);
  EXPECT_THAT(answer->text(), HasSubstr(words));
  EXPECT_FALSE(client.receive().has_value());
}

TEST(Handshake, TheBoardAnswersWithItsOwnVersionAndLimits) {
  const ServedBoards boards;
  RawClient client = boards.connect();
  wire::FrameHeader header;
  header.type = FrameType::kVersion;
  header.id = 42;
  std::array<std::uint8_t, wire::kVersionBytes> payload{};
  wire::encode(wire::VersionInfo{}, payload);
  client.send(header, payload);
  const auto answer = client.receive();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->header.type, FrameType::kVersion);
  EXPECT_EQ(answer->header.flags, wire::kResponse);
  EXPECT_EQ(answer->header.id, 42u);
  EXPECT_EQ(answer->header.error, ErrorCode::kNone);
  ASSERT_EQ(answer->payload.size(), wire::kVersionBytes);
  const auto theirs = wire::decode<wire::VersionInfo>(answer->payload);
  EXPECT_NE(theirs.session, 0u);
  wire::VersionInfo expected = board_version();
  expected.session = theirs.session;
  EXPECT_EQ(theirs, expected);
  EXPECT_NE(theirs.capabilities & wire::kFunctionalLevel, 0u);
}

TEST(Handshake, AcceptsALaterMinorVersionWithALongerPayload) {
  const ServedBoards boards;
  RawClient client = boards.connect();
  wire::VersionInfo mine;
  mine.minor = 9;
  std::vector<std::uint8_t> payload(wire::kVersionBytes + 8);
  wire::encode(mine, payload);
  client.send(FrameType::kVersion, 0, 0, payload);
  EXPECT_EQ(client.receive()->header.error, ErrorCode::kNone);
  EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
}

TEST(Handshake, AnotherMajorVersionIsRefusedByNumber) {
  const ServedBoards boards;
  RawClient client = boards.connect();
  wire::VersionInfo mine;
  mine.major = 7;
  expect_last_word(client, client.handshake(mine), ErrorCode::kVersion, "expected major version 2, got 7");
}

TEST(Handshake, LimitsThatNoFrameFitsAreRefused) {
  const ServedBoards boards;
  wire::VersionInfo no_window;
  no_window.window_slots = 0;
  wire::VersionInfo tiny;
  tiny.max_payload_bytes = 16;
  wire::VersionInfo narrow;
  narrow.window_bytes = narrow.max_payload_bytes - 1;
  for (const wire::VersionInfo& mine : {no_window, tiny, narrow}) {
    RawClient client = boards.connect();
    expect_last_word(client, client.handshake(mine), ErrorCode::kProtocol,
                     ("expected max_payload_bytes of at least 4096, window_slots of at least 1 and window_bytes of at "
                      "least twice the "
                      "payload limit, got " +
                      std::to_string(mine.max_payload_bytes) + ", " + std::to_string(mine.window_slots) + " and " +
                      std::to_string(mine.window_bytes))
                         .c_str());
  }
  EXPECT_TRUE(serves_afresh(boards));
}

TEST(Handshake, AnythingButAVersionFrameIsRefused) {
  const ServedBoards boards;
  RawClient eager = boards.connect();
  expect_last_word(eager, eager.call(FrameType::kCounters, 1, {}), ErrorCode::kProtocol, "version frame first");
  RawClient stranger = boards.connect();
  const std::string http = "GET / HTTP/1.1\r\nHost: board\r\nAccept: everything\r\n\r\n";
  stranger.send_bytes({reinterpret_cast<const std::uint8_t*>(http.data()), http.size()});
  expect_last_word(stranger, stranger.receive(), ErrorCode::kProtocol, "version frame first");
  EXPECT_TRUE(serves_afresh(boards));
}

TEST(Handshake, APayloadBeyondTheHandshakeLimitIsRefusedByItsHeader) {
  const ServedBoards boards;
  RawClient client = boards.connect();
  wire::FrameHeader header;
  header.type = FrameType::kVersion;
  header.size = 0xFFFF'FFFF;
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  wire::encode(header, bytes);
  client.send_bytes(bytes);
  expect_last_word(client, client.receive(), ErrorCode::kTooLarge, "at most 4096 payload bytes");
}

TEST(Handshake, AShortVersionPayloadIsRefused) {
  const ServedBoards boards;
  RawClient client = boards.connect();
  const std::array<std::uint8_t, 8> payload{};
  expect_last_word(client, client.call(FrameType::kVersion, 3, payload), ErrorCode::kProtocol,
                   "expected 56 bytes of version payload, got 8");
}

TEST(Handshake, WorksByteByByte) {
  const ServedBoards boards;
  RawClient client = boards.connect();
  std::vector<std::uint8_t> bytes(wire::kFrameHeaderBytes + wire::kVersionBytes);
  wire::FrameHeader header;
  header.type = FrameType::kVersion;
  header.size = wire::kVersionBytes;
  wire::encode(wire::VersionInfo{}, std::span(bytes).last<wire::kVersionBytes>());
  wire::encode_sealed(header, std::span(bytes).subspan(wire::kFrameHeaderBytes),
                      std::span(bytes).first<wire::kFrameHeaderBytes>());
  for (const std::uint8_t& byte : bytes) client.send_bytes({&byte, 1});
  EXPECT_EQ(client.receive()->header.error, ErrorCode::kNone);
}

TEST(Handshake, ASilentClientIsToldAndDropped) {
  BusOptions options = patient();
  options.handshake_deadline = std::chrono::milliseconds(20);
  const ServedBoards boards(1, options);
  RawClient client = boards.connect();
  expect_last_word(client, client.receive(), ErrorCode::kProtocol, "version frame within 0.02 s");
}

TEST(Handshake, ASecondClientIsToldThatTheBoardHasAnOwner) {
  const ServedBoards boards;
  RawClient owner = boards.open();
  RawClient second = boards.connect();
  expect_last_word(second, second.handshake(), ErrorCode::kBusy, "board 0 has an owner");
  EXPECT_EQ(owner.read_register(wire::reg::kId), wire::kIdValue);
}

TEST(Handshake, EveryBoardHasItsOwnOwnerAndState) {
  const ServedBoards boards(3);
  RawClient first = boards.open({}, 0), last = boards.open({}, 2);
  first.write_register(wire::reg::kStep, wire::kStepOne / 2);
  EXPECT_EQ(first.read_register(wire::reg::kStep), wire::kStepOne / 2);
  EXPECT_EQ(last.read_register(wire::reg::kStep), wire::kStepOne);
  EXPECT_TRUE(serves_afresh(boards, 1));
}

}  // namespace
}  // namespace gicube::emu
