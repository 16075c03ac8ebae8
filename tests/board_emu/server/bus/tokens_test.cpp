// Tokens of the data plane: asked of everyone who comes over TCP.
#include "served_boards.h"
#include "test.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using reference::RawFrame;
using wire::ErrorCode;

constexpr const char* kReader = "token_of_who_may_read";
constexpr const char* kUser = "token_of_who_may_use";
constexpr const char* kController = "token_of_who_may_control";

BusOptions with_tokens() {
  BusOptions options = patient();
  options.tokens = {{Right::kRead, kReader}, {Right::kUse, kUser}, {Right::kControl, kController}};
  options.token_pause = options.longest_token_pause = std::chrono::milliseconds(1);
  return options;
}

// A board that is reached over TCP.
class TcpBoard {
 public:
  explicit TcpBoard(const BusOptions& options = with_tokens())
      : server_(options), endpoint_(server_.listen(slot_, parse_endpoint("tcp:127.0.0.1:0"))) {
    thread_ = std::thread([this] { server_.run(); });
  }
  ~TcpBoard() { stop(); }
  TcpBoard(const TcpBoard&) = delete;
  TcpBoard& operator=(const TcpBoard&) = delete;

  RawClient connect() const { return RawClient::connect_tcp(endpoint_.port); }
  void stop() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }

 private:
  BoardSlot slot_{0, {}};
  BusServer server_;
  const Endpoint endpoint_;
  std::thread thread_;
};

wire::VersionInfo with_force() {
  wire::VersionInfo mine;
  mine.flags = wire::kForce;
  return mine;
}

void expect_forbidden(const std::optional<RawFrame>& answer, const char* words) {
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->header.error, ErrorCode::kForbidden);
  EXPECT_THAT(answer->text(), HasSubstr(words));
}

TEST(Tokens, OpenABoardOverTcp) {
  const TcpBoard board;
  for (const char* token : {kUser, kController}) {
    RawClient client = board.connect();
    wire::VersionInfo mine;
    mine.wait_ms = 60'000;
    ASSERT_EQ(client.handshake(mine, token)->header.error, ErrorCode::kNone) << token;
    EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
  }
}

TEST(Tokens, WhoHasNoneOrAWrongOneIsRefusedOverTcp) {
  const TcpBoard board;
  expect_forbidden(board.connect().handshake(), "expected a token of this board, got none");
  for (const std::string& wrong :
       {std::string(kUser) + "x", std::string("token_of_who_may_usf"), std::string(1, '\0')}) {
    expect_forbidden(board.connect().handshake({}, wrong), "expected a token of this board, got another one");
  }
  expect_forbidden(board.connect().handshake({}, kReader),
                   "expected a token with the right to use, got one with the right to read");
}

TEST(Tokens, ForceNeedsTheRightToControl) {
  const TcpBoard board;
  RawClient owner = board.connect();
  ASSERT_EQ(owner.handshake({}, kUser)->header.error, ErrorCode::kNone);
  expect_forbidden(board.connect().handshake(with_force(), kUser),
                   "expected a token with the right to control, got one with the right to use");
  EXPECT_EQ(owner.read_register(wire::reg::kId), wire::kIdValue);
  RawClient thief = board.connect();
  EXPECT_EQ(thief.handshake(with_force(), kController)->header.error, ErrorCode::kNone);
}

// Whoever has seen a session's number, as in a capture, can't take it up.
TEST(Tokens, ASessionIsResumedWithOneOnly) {
  const TcpBoard board;
  RawClient owner = board.connect();
  const auto answer = owner.handshake({}, kUser);
  ASSERT_TRUE(answer.has_value());
  wire::VersionInfo again;
  again.session = wire::decode<wire::VersionInfo>(answer->payload).session;
  expect_forbidden(board.connect().handshake(again), "got none");
  EXPECT_EQ(owner.read_register(wire::reg::kId), wire::kIdValue);
  again.taken = again.consumed = 1;
  EXPECT_EQ(board.connect().handshake(again, kUser)->header.error, ErrorCode::kNone);
}

TEST(Tokens, AtAUnixSocketNobodyIsAsked) {
  const ServedBoards boards(1, with_tokens());
  RawClient owner = boards.open();
  RawClient thief = boards.open(with_force());
  EXPECT_EQ(thief.read_register(wire::reg::kId), wire::kIdValue);
}

TEST(Tokens, WhoCameWithWhichIsNoted) {
  Audit audit;
  BusOptions options = with_tokens();
  options.audit = &audit;
  {
    const TcpBoard board(options);
    expect_forbidden(board.connect().handshake(), "none");
    expect_forbidden(board.connect().handshake({}, kReader), "use");
    RawClient owner = board.connect();
    ASSERT_EQ(owner.handshake({}, kUser)->header.error, ErrorCode::kNone);
    EXPECT_EQ(board.connect().handshake({}, kUser)->header.error, ErrorCode::kBusy);
    RawClient thief = board.connect();
    ASSERT_EQ(thief.handshake(with_force(), kController)->header.error, ErrorCode::kNone);
  }
  std::string counted;
  for (const auto& [event, count] : audit.counts()) {
    if (count > 0) counted += fmt::format("{} {} ", event, count);
  }
  EXPECT_EQ(counted, "connected 5 refused 1 unknown 1 forbidden 1 opened 2 forced 1 closed 2 ");
}

TEST(Tokens, WhoWaitsForHisRefusalHoldsUpNoOneAndNotTheEnd) {
  BusOptions options = with_tokens();
  options.token_pause = options.longest_token_pause = std::chrono::hours(1);
  TcpBoard board(options);
  RawClient guessing = board.connect();
  std::array<std::uint8_t, wire::kVersionBytes> payload{};
  wire::encode(wire::VersionInfo{}, payload);
  guessing.send(wire::FrameType::kVersion, 0, 0, payload);
  {
    RawClient user = board.connect();
    ASSERT_EQ(user.handshake({}, kUser)->header.error, ErrorCode::kNone);
    EXPECT_EQ(user.read_register(wire::reg::kId), wire::kIdValue);
  }
  board.stop();  // returns
}

}  // namespace
}  // namespace gicube::emu
