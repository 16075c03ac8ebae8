// The server around its sessions: which sockets it takes, and how it stops.
#include "server/bus/bus_server.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/post.hpp>

#include "served_boards.h"
#include "test.h"
#include "unix_socket.h"

namespace gicube::emu {
namespace {

using reference::RawClient;
using wire::ErrorCode;

void expect_shutdown(const std::optional<reference::RawFrame>& last) {
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.error, ErrorCode::kCancelled);
  EXPECT_EQ(last->header.id, 0u) << "it answers no frame";
  EXPECT_THAT(last->text(), HasSubstr("shuts down"));
}

TEST(BusServer, ListensAtASocketFileOfItsUserAloneAndRemovesIt) {
  namespace fs = std::filesystem;
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("board");
  BoardSlot slot(0, {});
  {
    BusServer server(patient());
    server.listen(slot, {EndpointKind::kUnix, path, "", 0, -1});
    EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_EQ(slot.info().endpoint, "unix:" + path);
  }
  EXPECT_FALSE(fs::exists(path)) << "it never ran";
}

TEST(BusServer, AdoptsConnectedStreamSocketsOnly) {
  const reference::TemporaryDirectory folder;
  BoardSlot slot(0, {});
  BusServer server(patient());
  std::array<int, 2> stream{}, datagram{}, pipe{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, stream.data()), 0);
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_DGRAM, 0, datagram.data()), 0);
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const int listening = ::socket(AF_INET, SOCK_STREAM, 0), alone = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::listen(listening, 1), 0);
  for (const int fd : {datagram[0], pipe[0], listening, alone}) {
    try {
      server.adopt(slot, fd, false);
      FAIL() << fd;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()),
                "fd:" + std::to_string(fd) + ": expected a connected stream socket or a listening Unix socket");
    }
  }
  server.adopt(slot, stream[0], true);
  EXPECT_EQ(slot.info().endpoint, "fd:" + std::to_string(stream[0]));
  EXPECT_NE(::fcntl(stream[0], F_GETFD) & FD_CLOEXEC, 0) << "programs that the board starts do not get it";
  for (const int fd : {datagram[0], datagram[1], pipe[0], pipe[1], listening, alone, stream[1]}) ::close(fd);
  server.run();  // the private session has ended
}

TEST(BusServer, ListensAtASocketThatItWasGivenAndLeavesItsFile) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("board");
  const int fd = reference::bound_socket(path, 8, 0);
  BoardSlot slot(0, {});
  BusServer server(patient());
  const Endpoint endpoint = server.listen(slot, {EndpointKind::kFd, "", "", 0, fd});
  EXPECT_EQ(to_string(endpoint), "unix:" + path);
  EXPECT_EQ(slot.info().endpoint, "unix:" + path);
  EXPECT_NE(::fcntl(fd, F_GETFD) & FD_CLOEXEC, 0) << "programs that the board starts do not get it";
  std::thread thread([&server] { server.run(); });
  for (int client = 0; client < 2; ++client) {
    RawClient one = RawClient::connect_unix(path);
    EXPECT_TRUE(one.handshake().has_value()) << client;
    EXPECT_EQ(one.read_register(wire::reg::kId), wire::kIdValue);
  }
  server.stop();
  thread.join();
  EXPECT_TRUE(std::filesystem::exists(path)) << "it belongs to who made the socket";
}

TEST(BusServer, ListensAtListeningUnixStreamSocketsOnly) {
  const int of_network = ::socket(AF_INET, SOCK_STREAM, 0), idle = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::listen(of_network, 1), 0);
  BoardSlot slot(0, {});
  BusServer server(patient());
  for (const int fd : {of_network, idle, 9999}) {
    EXPECT_FALSE(is_listening(fd));
    EXPECT_THAT(
        [&] {
          server.listen(slot, {EndpointKind::kFd, "", "", 0, fd});
        },
        ThrowsMessage<std::runtime_error>("fd:" + std::to_string(fd) + ": expected a listening Unix socket"));
  }
  ::close(of_network);
  ::close(idle);
}

TEST(BusServer, SaysWhereItCouldNotListenAndWhy) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("none/board");
  BoardSlot slot(0, {});
  BusServer server(patient());
  EXPECT_THAT(
      [&] {
        server.listen(slot, {EndpointKind::kUnix, path, "", 0, -1});
      },
      ThrowsMessage<std::runtime_error>("unix:" + path + ": No such file or directory"));
}

TEST(BusServer, ReturnsOnlyWhenTheBoardOfASocketThatItAdoptedHasNoMoreWork) {
  BoardSlot slot(0, {});
  BusServer server(patient());
  std::array<int, 2> stream{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, stream.data()), 0);
  server.adopt(slot, stream[0], true);
  ::close(stream[1]);
  std::atomic<bool> has_ended{false};
  boost::asio::post(slot.compute(), [&has_ended] {
    std::this_thread::sleep_for(std::chrono::seconds(1));  // longer than anything else keeps the server
    has_ended = true;
  });
  server.run();
  EXPECT_TRUE(has_ended);
  slot.settle();
}

TEST(BusServer, AConnectionThatWasClosedIsNotOpen) {
  std::array<int, 2> stream{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, stream.data()), 0);
  asio::io_context io;
  Connection::Socket socket(io);
  socket.assign(asio::generic::stream_protocol(AF_UNIX, 0), stream[0]);
  const auto connection = std::make_shared<Connection>(std::move(socket));
  EXPECT_TRUE(connection->is_open());
  connection->close();
  EXPECT_FALSE(connection->is_open());
  ::close(stream[1]);
}

TEST(BusServer, TellsClientsWithoutABoardThatItShutsDown) {
  ServedBoards boards;
  RawClient silent = boards.connect();
  EXPECT_TRUE(serves_afresh(boards));  // so the earlier connection was accepted too
  boards.server.stop();
  expect_shutdown(silent.receive());
  silent.close();
}

TEST(BusServer, LeavesWhatAClientInLineHasSentForItsSession) {
  const ServedBoards boards;
  wire::VersionInfo patient_client;
  patient_client.wait_ms = 60'000;
  std::array<std::uint8_t, wire::kVersionBytes> version{};
  wire::encode(patient_client, version);
  std::array<std::uint8_t, 4> payload{};
  wire::store(std::span<std::uint8_t>(payload), 0, wire::reg::kId);
  RawClient owner = boards.open(), next = boards.connect();
  next.send(wire::FrameType::kVersion, 3, 0, version);
  next.send(wire::FrameType::kRegisterRead, 4, 0, payload);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // it is looked at whether the client is still there
  owner.close();
  const auto welcome = next.receive(), answer = next.receive_answer();
  ASSERT_TRUE(welcome && answer);
  EXPECT_EQ(welcome->header.id, 3u);
  EXPECT_EQ(welcome->header.error, ErrorCode::kNone);
  EXPECT_EQ(answer->header.id, 4u);
  EXPECT_EQ(wire::load<std::uint32_t>(answer->payload, 0), wire::kIdValue);
}

}  // namespace
}  // namespace gicube::emu
