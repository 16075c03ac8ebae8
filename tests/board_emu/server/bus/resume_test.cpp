// Sessions that outlive their connections, frame by frame.
#include <unistd.h>

#include "gicube/wire/registers.h"
#include "served_boards.h"
#include "test.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using reference::RawFrame;
using wire::ErrorCode;
using wire::FrameType;
namespace reg = wire::reg;

std::vector<std::uint8_t> word(std::uint32_t value) {
  std::vector<std::uint8_t> bytes(4);
  wire::store(std::span(bytes), 0, value);
  return bytes;
}

wire::VersionInfo version_in(const RawFrame& answer) { return wire::decode<wire::VersionInfo>(answer.payload); }

struct Opened {
  RawClient client;
  wire::VersionInfo board;
};

Opened open(const ServedBoards& boards, const wire::VersionInfo& mine = {}) {
  RawClient client = boards.connect();
  const auto answer = client.handshake(mine);
  if (!answer || answer->header.error != ErrorCode::kNone) throw std::runtime_error("the board refused us");
  return {std::move(client), version_in(*answer)};
}

TEST(Resume, TheStateStaysAndWhatWasTakenIsKnown) {
  const ServedBoards boards;
  wire::VersionInfo mine;
  {
    Opened first = open(boards);
    mine.session = first.board.session;
    first.client.write_register(reg::kVolumeX, 64);
    EXPECT_EQ(first.client.read_register(reg::kVolumeX), 64u);
  }
  mine.taken = mine.consumed = 1;
  Opened second = open(boards, mine);
  EXPECT_EQ(second.board.session, mine.session);
  EXPECT_EQ(second.board.taken, 2u);
  EXPECT_EQ(second.board.consumed, 2u);
  second.client.continue_from(2);
  EXPECT_EQ(second.client.read_register(reg::kVolumeX), 64u);
}

TEST(Resume, AnswersThatWereNotTakenComeAgainInTheirOrder) {
  const ServedBoards boards;
  wire::VersionInfo mine;
  {
    Opened first = open(boards);
    mine.session = first.board.session;
    for (std::uint32_t id = 1; id <= 3; ++id) first.client.send(FrameType::kRegisterRead, id, 0, word(reg::kId));
    for (std::uint32_t id = 1; id <= 3; ++id) ASSERT_EQ(first.client.receive_answer()->header.sequence, id);
  }
  mine.taken = mine.consumed = 1;  // as if two had been lost
  Opened second = open(boards, mine);
  for (std::uint32_t id = 2; id <= 3; ++id) {
    const auto again = second.client.receive_answer();
    ASSERT_TRUE(again.has_value());
    EXPECT_EQ(again->header.id, id);
    EXPECT_EQ(again->header.sequence, id);
    EXPECT_EQ(again->payload, word(wire::kIdValue));
  }
}

TEST(Resume, AFrameThatIsSentAgainIsCarriedOutOnce) {
  const ServedBoards boards;
  wire::VersionInfo mine;
  {
    Opened first = open(boards);
    mine.session = first.board.session;
    first.client.write_register(reg::kStatusClear, 0);
    first.client.write_register(reg::kVolumeX, 32);
    EXPECT_EQ(first.client.read_register(reg::kVolumeX), 32u);
  }
  mine.taken = mine.consumed = 1;
  Opened second = open(boards, mine);
  second.client.continue_from(1);
  second.client.write_register(reg::kVolumeX, 48);  // number 2 was taken: this one is not looked at
  second.client.continue_from(3);
  EXPECT_EQ(second.client.read_register(reg::kVolumeX), 32u);
}

TEST(Resume, IsRefusedWithoutASessionAndWithNumbersThatCannotBe) {
  const ServedBoards boards;
  wire::VersionInfo mine;
  mine.session = 12345;
  EXPECT_EQ(boards.connect().handshake(mine)->header.error, ErrorCode::kNoSession);
  Opened first = open(boards);
  mine.session = first.board.session;
  mine.taken = 7;
  const auto answer = boards.connect().handshake(mine);
  EXPECT_EQ(answer->header.error, ErrorCode::kProtocol);
  EXPECT_THAT(answer->text(), HasSubstr("expected 0 <= consumed <= taken <= 0, got 0 and 7"));
  EXPECT_EQ(first.client.read_register(reg::kId), wire::kIdValue) << "the session goes on";
}

TEST(Resume, SaysWhichNumbersFit) {
  const ServedBoards boards;
  Opened first = open(boards);
  const auto read_id = [&first](std::uint32_t id) {
    return first.client.call(FrameType::kRegisterRead, id, word(reg::kId));
  };
  for (std::uint32_t id = 1; id <= 3; ++id) ASSERT_TRUE(read_id(id).has_value());
  wire::FrameHeader credit;
  credit.type = FrameType::kCredit;
  credit.flags = wire::kPosted;
  credit.credit_slots = 1;
  credit.credit_bytes = 4;
  first.client.send(credit);
  ASSERT_TRUE(read_id(4).has_value());
  wire::VersionInfo mine;
  mine.session = first.board.session;
  mine.consumed = 9;
  mine.taken = 6;
  EXPECT_THAT(boards.connect().handshake(mine)->text(), HasSubstr("expected 1 <= consumed <= taken <= 4, got 9 and 6"));
}

TEST(Resume, IsAtItsOwnBoardOnly) {
  const ServedBoards boards(2);
  Opened first = open(boards);
  wire::VersionInfo mine;
  mine.session = first.board.session;
  EXPECT_EQ(boards.connect(1).handshake(mine)->header.error, ErrorCode::kNoSession);
  EXPECT_EQ(first.client.read_register(reg::kId), wire::kIdValue);
}

// So that no client can guess another one's: of eight tokens some use the high half, and some the low one.
TEST(Resume, TokensHave64Bits) {
  const ServedBoards boards;
  std::uint64_t bits = 0;
  for (int i = 0; i < 8; ++i) bits |= open(boards).board.session;
  EXPECT_NE(bits >> 32, 0u);
  EXPECT_NE(bits & 0xFFFF'FFFF, 0u);
}

TEST(Resume, ANewConnectionReplacesOneThatSeemsAlive) {
  const ServedBoards boards;
  Opened first = open(boards);
  wire::VersionInfo mine;
  mine.session = first.board.session;
  Opened second = open(boards, mine);
  EXPECT_FALSE(first.client.receive().has_value());
  EXPECT_EQ(second.client.read_register(reg::kId), wire::kIdValue);
}

TEST(Resume, AClientThatIsBackHasItsBoardForItselfAgain) {
  const ServedBoards boards;
  const auto in_use = [&boards] { return boards.slots[0]->info().in_use; };
  wire::VersionInfo mine;
  {
    const Opened first = open(boards);
    mine.session = first.board.session;
    EXPECT_TRUE(in_use());
  }
  while (in_use()) std::this_thread::yield();  // until the server has seen that it went
  const Opened again = open(boards, mine);
  EXPECT_TRUE(in_use());
  EXPECT_EQ(boards.connect().handshake()->header.error, ErrorCode::kBusy);
}

TEST(Resume, ASessionWhoseClientIsAwayMakesWayForTheNext) {
  const ServedBoards boards;
  wire::VersionInfo mine;
  {
    Opened first = open(boards);
    mine.session = first.board.session;
    first.client.write_register(reg::kVolumeX, 64);
  }
  EXPECT_TRUE(serves_afresh(boards));
  EXPECT_EQ(boards.connect().handshake(mine)->header.error, ErrorCode::kNoSession);
}

TEST(Resume, AGoodbyeEndsTheSession) {
  const ServedBoards boards;
  wire::VersionInfo mine;
  {
    Opened first = open(boards);
    mine.session = first.board.session;
    first.client.send(FrameType::kVersion, 0, wire::kPosted, {});
    EXPECT_FALSE(first.client.receive().has_value());
  }
  EXPECT_EQ(boards.connect().handshake(mine)->header.error, ErrorCode::kNoSession);
}

TEST(Resume, TheLimitEndsASessionWhoseClientStaysAway) {
  BusOptions options = patient();
  options.resume_limit = std::chrono::milliseconds(30);
  const ServedBoards boards(1, options);
  wire::VersionInfo mine;
  {
    Opened first = open(boards);
    mine.session = first.board.session;
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(boards.connect().handshake(mine)->header.error, ErrorCode::kNoSession);
}

TEST(Resume, AProbeFindsALostLastFrame) {
  const ServedBoards boards;
  Opened first = open(boards);
  first.client.send(FrameType::kCredit, 0, 0, {});
  const auto known = first.client.receive();
  ASSERT_TRUE(known.has_value());
  EXPECT_EQ(known->header.type, FrameType::kCredit);
  EXPECT_EQ(known->header.id, 0u) << "nothing was sent yet";
  first.client.send(FrameType::kCredit, 1, 0, {});  // number 1 was sent, says the client
  const auto last = first.client.receive();
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.error, ErrorCode::kCorrupted);
}

TEST(Resume, ForceEndsTheOwnersSession) {
  const ServedBoards boards;
  Opened owner = open(boards);
  wire::VersionInfo mine;
  mine.flags = wire::kForce;
  Opened thief = open(boards, mine);
  const auto last = owner.client.receive();
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.error, ErrorCode::kTaken);
  EXPECT_EQ(thief.client.read_register(reg::kId), wire::kIdValue);
}

TEST(Resume, ABusyBoardSaysWhoOwnsIt) {
  const ServedBoards boards;
  const Opened owner = open(boards);
  const auto refused = boards.connect().handshake();
  ASSERT_TRUE(refused.has_value());
  EXPECT_EQ(refused->header.error, ErrorCode::kBusy);
  EXPECT_THAT(refused->text(), HasSubstr("board 0 has an owner: process " + std::to_string(::getpid()) + " since "));
}

}  // namespace
}  // namespace gicube::emu
