// Connections that own no board: whoever is silent, waits or uses force keeps nobody else out.
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <iomanip>

#include "served_boards.h"
#include "test.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using reference::RawFrame;
using wire::ErrorCode;

constexpr const char* kToken = "token_of_these_guests";

wire::VersionInfo version_of(const std::optional<RawFrame>& answer) {
  if (!answer || answer->header.error != ErrorCode::kNone) throw std::runtime_error("the board refused us");
  return wire::decode<wire::VersionInfo>(answer->payload);
}

wire::VersionInfo waiting(std::uint32_t wait_ms) {
  wire::VersionInfo mine;
  mine.wait_ms = wait_ms;
  return mine;
}

void expect_busy(const std::optional<RawFrame>& answer, const std::string& words) {
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->header.error, ErrorCode::kBusy);
  EXPECT_THAT(answer->text(), HasSubstr(words));
}

// Sends its version and does not wait for the answer.
void enqueue_client(RawClient& client) {
  std::array<std::uint8_t, wire::kVersionBytes> payload{};
  wire::encode(waiting(60'000), payload);
  client.send(wire::FrameType::kVersion, 0, 0, payload);
}

TEST(Guests, FortySilentConnectionsKeepOutNeitherTheOwnerWhoComesBackNorANewClient) {
  const ServedBoards boards;
  wire::VersionInfo again;
  std::vector<RawClient> silent;
  {
    RawClient owner = boards.connect();
    again.session = version_of(owner.handshake()).session;
    for (int i = 0; i < 40; ++i) silent.push_back(boards.connect());
    EXPECT_EQ(owner.read_register(wire::reg::kId), wire::kIdValue);
  }
  again.taken = again.consumed = 1;
  {
    RawClient owner = boards.connect();
    EXPECT_EQ(version_of(owner.handshake(again)).session, again.session);
    owner.send(wire::FrameType::kVersion, 0, wire::kPosted, {});
  }
  // Of one process 16 may be silent; 40 and one that resumed make 25 too many.
  for (std::size_t i = 0; i < 25; ++i)
    expect_busy(silent[i].receive(), "got none before another client needed its place");
  RawClient next = boards.connect();
  version_of(next.handshake(waiting(60'000)));
  EXPECT_EQ(next.read_register(wire::reg::kId), wire::kIdValue);
}

TEST(Guests, AreCountedAsLongAsTheyAreThere) {
  const ServedBoards boards;
  const auto connections = [&boards] { return boards.server.quotas().front().used; };
  {
    const RawClient first = boards.connect(), second = boards.connect();
    while (connections() < 2) std::this_thread::yield();
  }
  while (connections() > 0) std::this_thread::yield();
}

TEST(Guests, TheHostWithMostSilentConnectionsMakesWay) {
  BusOptions options = patient();
  options.max_unowned = 4;
  options.tokens = {{Right::kUse, kToken}};
  BoardSlot slot(0, {});
  BusServer server(options);
  const Endpoint endpoint = server.listen(slot, parse_endpoint("tcp:127.0.0.1:0"));
  std::thread thread([&server] { server.run(); });
  {
    RawClient shy = RawClient::connect_tcp(endpoint.port, "127.0.0.2");
    std::vector<RawClient> crowd;
    for (int i = 0; i < 5; ++i) crowd.push_back(RawClient::connect_tcp(endpoint.port, "127.0.0.3"));
    for (std::size_t i = 0; i < 2; ++i) expect_busy(crowd[i].receive(), "needed its place");
    version_of(shy.handshake({}, kToken));
    EXPECT_EQ(shy.read_register(wire::reg::kId), wire::kIdValue);
  }
  server.stop();
  thread.join();
}

TEST(Guests, AFullLineLeavesAPlaceForTheOwnerWhoComesBack) {
  BusOptions options = patient();
  options.max_unowned = 4;
  const ServedBoards boards(1, options);
  RawClient owner = boards.connect();
  wire::VersionInfo again;
  again.session = version_of(owner.handshake()).session;
  std::vector<RawClient> line;
  for (int i = 0; i < 3; ++i) {
    line.push_back(boards.connect());
    enqueue_client(line.back());
  }
  expect_busy(boards.connect().handshake(waiting(60'000)), "3 connections wait for a board already");
  RawClient back = boards.connect();
  EXPECT_EQ(version_of(back.handshake(again)).session, again.session);
  EXPECT_EQ(back.read_register(wire::reg::kId), wire::kIdValue);
}

TEST(Guests, OfOneProcessOnlySomeMayWait) {
  BusOptions options = patient();
  options.max_unowned_of_peer = 3;
  const ServedBoards boards(1, options);
  const RawClient owner = boards.open();
  RawClient first = boards.connect(), second = boards.connect();
  enqueue_client(first);
  enqueue_client(second);
  expect_busy(boards.connect().handshake(waiting(60'000)),
              "2 connections of process " + std::to_string(::getpid()) + " wait for a board already");
}

TEST(Guests, AnEighthOfThePlacesIsNotForTheLine) {
  BusOptions options = patient();
  options.max_unowned = 16;
  options.max_unowned_of_peer = 32;
  const ServedBoards boards(1, options);
  const RawClient owner = boards.open();
  std::vector<RawClient> line;
  for (int i = 0; i < 14; ++i) {
    line.push_back(boards.connect());
    enqueue_client(line.back());
  }
  wire::VersionInfo briefly = waiting(1000);
  expect_busy(boards.connect().handshake(briefly), "14 connections wait for a board already");
}

TEST(Guests, NobodyWaitsLongerThanTheBoardAllows) {
  BusOptions options = patient();
  options.max_wait = std::chrono::milliseconds(1);
  const ServedBoards boards(1, options);
  const RawClient owner = boards.open();
  expect_busy(boards.connect().handshake(waiting(0xFFFF'FFFF)), "board 0 has an owner");
}

TEST(Guests, ForceInALoopIsHeldBack) {
  BusOptions options = patient();
  options.force_pause = options.longest_force_pause = std::chrono::hours(1);
  const ServedBoards boards(2, options);
  wire::VersionInfo forcing;
  forcing.flags = wire::kForce;
  RawClient owner = boards.open();
  RawClient thief = boards.open(forcing);
  EXPECT_EQ(owner.receive()->header.error, ErrorCode::kTaken);
  for (int i = 0; i < 3; ++i) {
    expect_busy(boards.connect().handshake(forcing), "; it was recently taken by force, and can be taken again in 3");
  }
  EXPECT_EQ(thief.read_register(wire::reg::kId), wire::kIdValue);
  const RawClient other_owner = boards.open({}, 1);
  RawClient other_thief = boards.open(forcing, 1);
  EXPECT_EQ(other_thief.read_register(wire::reg::kId), wire::kIdValue) << "each board by itself";
}

// What does not come by force stands in line behind others.
TEST(Guests, ForceThatIsHeldBackDoesNotOvertake) {
  BusOptions options = patient();
  options.force_pause = options.longest_force_pause = std::chrono::hours(1);
  const ServedBoards boards(1, options);
  wire::VersionInfo forcing = waiting(60'000);
  forcing.flags = wire::kForce;
  const RawClient owner = boards.open();
  RawClient thief = boards.open(forcing);
  RawClient first = boards.connect();
  enqueue_client(first);
  RawClient again = boards.connect();
  std::array<std::uint8_t, wire::kVersionBytes> payload{};
  wire::encode(forcing, payload);
  // The server reads the two in the order of their connections, which it accepted in that order.
  again.send(wire::FrameType::kVersion, 0, 0, payload);
  thief.send(wire::FrameType::kVersion, 0, wire::kPosted, {});
  version_of(first.receive());
  EXPECT_EQ(first.read_register(wire::reg::kId), wire::kIdValue);
}

// The server's end of a connection to this port, which is a socket of this process too; -1: there is none.
int accepted_at(std::uint16_t port) {
  for (int fd = 0; fd < 1024; ++fd) {
    sockaddr_in ours{}, theirs{};
    socklen_t size = sizeof ours;
    if (::getpeername(fd, reinterpret_cast<sockaddr*>(&theirs), &size) != 0) continue;
    size = sizeof ours;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&ours), &size) != 0) continue;
    if (ours.sin_family == AF_INET && ntohs(ours.sin_port) == port) return fd;
  }
  return -1;
}

// The timer in the system's list of connections: 2 is that of keepalive.
TEST(Guests, ATcpClientThatHasGoneWithoutAWordIsNoticed) {
  BoardSlot slot(0, {});
  BusOptions options = patient();
  options.tokens = {{Right::kUse, kToken}};
  BusServer server(options);
  const Endpoint endpoint = server.listen(slot, parse_endpoint("tcp:127.0.0.1:0"));
  std::thread thread([&server] { server.run(); });
  {
    RawClient client = RawClient::connect_tcp(endpoint.port);
    version_of(client.handshake({}, kToken));
    std::ostringstream ours;
    ours << "0100007F:" << std::hex << std::uppercase << std::setw(4) << std::setfill('0') << endpoint.port;
    std::ifstream list("/proc/net/tcp");
    std::string timer;
    for (std::string line; std::getline(list, line);) {
      std::istringstream fields(line);
      std::string slot_number, local, remote, state, queues, when;
      fields >> slot_number >> local >> remote >> state >> queues >> when;
      if (local == ours.str() && state == "01") timer = when.substr(0, 2);
    }
    EXPECT_EQ(timer, "02");
    const int accepted = accepted_at(endpoint.port);
    const auto option = [accepted](int name) {
      int value = -1;
      socklen_t size = sizeof value;
      EXPECT_EQ(::getsockopt(accepted, IPPROTO_TCP, name, &value, &size), 0);
      return value;
    };
    EXPECT_EQ(option(TCP_KEEPIDLE), 30);   // s
    EXPECT_EQ(option(TCP_KEEPINTVL), 10);  // s
    EXPECT_EQ(option(TCP_KEEPCNT), 3);
    EXPECT_NE(option(TCP_NODELAY), 0);
  }
  server.stop();
  thread.join();
}

}  // namespace
}  // namespace gicube::emu
