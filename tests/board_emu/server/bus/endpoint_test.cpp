#include "server/bus/endpoint.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "temporary_directory.h"
#include "test.h"
#include "unix_socket.h"

namespace gicube::emu {
namespace {

TEST(Endpoint, ReadsBackWhatItPrints) {
  for (const char* text :
       {"unix:/tmp/board", "unix:board", "tcp:127.0.0.1:5000", "tcp:[::1]:0", "tcp:10.1.2.3:65535", "fd:7"}) {
    EXPECT_EQ(to_string(parse_endpoint(text)), text);
  }
  EXPECT_EQ(to_string(parse_endpoint("tcp:localhost:80")), "tcp:127.0.0.1:80");
}

TEST(Endpoint, RefusesWhatItCannotRead) {
  const std::string long_path = "unix:" + std::string(108, 'x');
  for (const std::string text :
       {"", "unix:", "tcp:", "tcp:127.0.0.1", "tcp:127.0.0.1:", "tcp:127.0.0.1:65536", "tcp::1", "tcp:example.org:80",
        "tcp:127.0.0.1:-1", "fd:", "fd:-1", "fd:one", "/tmp/board", "http:8080"}) {
    EXPECT_THROW(parse_endpoint(text), std::invalid_argument) << text;
  }
  EXPECT_THROW(parse_endpoint(long_path), std::invalid_argument);
}

TEST(Endpoint, HasWhatItsKindHasAndNothingElse) {
  EXPECT_EQ(parse_endpoint("unix:b"), (Endpoint{EndpointKind::kUnix, "b", "", 0, -1}));
  EXPECT_EQ(parse_endpoint("tcp:10.1.2.3:4"), (Endpoint{EndpointKind::kTcp, "", "10.1.2.3", 4, -1}));
  EXPECT_EQ(parse_endpoint("fd:7"), (Endpoint{EndpointKind::kFd, "", "", 0, 7}));
}

TEST(Endpoint, SaysWhatWasExpectedAndWhatCame) {
  const auto said = [](const std::string& text) -> std::string {
    try {
      parse_endpoint(text);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_EQ(said("tcp:1"), "expected tcp:HOST:PORT, got \"tcp:1\"");
  EXPECT_EQ(said("tcp:127.0.0.1:65536"),
            "expected a port from 0 to 65535 in tcp:HOST:PORT, got \"tcp:127.0.0.1:65536\"");
  EXPECT_EQ(said("tcp:example.org:80"),
            "expected a numeric address or \"localhost\" in tcp:HOST:PORT, got \"tcp:example.org:80\"");
  EXPECT_EQ(said("fd:-1"), "expected fd:N with the number of an open socket, got \"fd:-1\"");
  EXPECT_EQ(said("http:8080"), "expected unix:PATH, tcp:HOST:PORT or fd:N, got \"http:8080\"");
  EXPECT_EQ(said("unix:"), "expected unix:PATH with a path of 1 to 107 bytes, got \"unix:\"");
  EXPECT_EQ(said("unix:" + std::string(107, 'x')), "nothing");
}

TEST(Endpoint, OnlyLoopbackUnixAndDescriptorsAreLocal) {
  for (const char* text :
       {"unix:/tmp/x", "fd:3", "tcp:127.0.0.1:1", "tcp:127.8.8.8:1", "tcp:[::1]:1", "tcp:localhost:1"}) {
    EXPECT_TRUE(is_local(parse_endpoint(text))) << text;
  }
  for (const char* text : {"tcp:0.0.0.0:1", "tcp:[::]:1", "tcp:192.168.0.1:1", "tcp:128.0.0.1:1"}) {
    EXPECT_FALSE(is_local(parse_endpoint(text))) << text;
  }
}

TEST(Endpoint, EachBoardHasItsOwn) {
  EXPECT_EQ(to_string(for_board(parse_endpoint("unix:/tmp/b"), 0)), "unix:/tmp/b");
  EXPECT_EQ(to_string(for_board(parse_endpoint("unix:/tmp/b"), 2)), "unix:/tmp/b.2");
  EXPECT_EQ(to_string(for_board(parse_endpoint("tcp:127.0.0.1:80"), 3)), "tcp:127.0.0.1:83");
  EXPECT_EQ(to_string(for_board(parse_endpoint("tcp:127.0.0.1:0"), 3)), "tcp:127.0.0.1:0");
  EXPECT_EQ(to_string(for_board(parse_endpoint("tcp:127.0.0.1:65534"), 1)), "tcp:127.0.0.1:65535");
  EXPECT_THAT([] { for_board(parse_endpoint("tcp:127.0.0.1:65534"), 3); },
              ThrowsMessage<std::invalid_argument>("expected ports up to 65535, got 65537 for board 3"));
  EXPECT_THROW(for_board(parse_endpoint("fd:3"), 1), std::invalid_argument);
}

class Socket {
 public:
  explicit Socket(const std::string& path) : fd_(reference::bound_socket(path, 1)) {}
  ~Socket() { ::close(fd_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

 private:
  int fd_;
};

TEST(Endpoint, ASocketFileIsRemovedOnlyIfNobodyAnswers) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("board");
  remove_stale_socket(path);  // nothing there: nothing to do
  {
    const Socket alive(path);
    EXPECT_THROW(remove_stale_socket(path), std::runtime_error);
    EXPECT_TRUE(std::filesystem::exists(path));
  }
  remove_stale_socket(path);
  EXPECT_FALSE(std::filesystem::exists(path));
}

// Its owner may be too busy to accept; one does not wait for it.
TEST(Endpoint, ASocketWhoseBacklogIsFullIsInUse) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("board");
  const Socket busy(path);
  const sockaddr_un address = reference::unix_address(path);
  std::vector<int> waiting;
  int connected = 0;
  while (connected == 0 && waiting.size() < 100) {
    waiting.push_back(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0));
    connected = ::connect(waiting.back(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  }
  EXPECT_NE(connected, 0);
  EXPECT_THROW(remove_stale_socket(path), std::runtime_error);
  EXPECT_TRUE(std::filesystem::exists(path));
  for (const int fd : waiting) ::close(fd);
}

TEST(Endpoint, AFileThatIsNoSocketIsLeftAlone) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("notes");
  std::ofstream(path) << "keep me";
  EXPECT_THROW(remove_stale_socket(path), std::runtime_error);
  EXPECT_EQ(std::filesystem::file_size(path), 7u);
}

}  // namespace
}  // namespace gicube::emu
