#include "transport/connect.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "full_disk.h"
#include "gicube/access.h"
#include "gicube/error.h"
#include "gicube/wire/capture.h"
#include "temporary_directory.h"
#include "test.h"
#include "transport/frame_stream.h"
#include "transport/link.h"
#include "transport/tls_stream.h"

namespace gicube {
namespace {

namespace fs = std::filesystem;
constexpr std::chrono::seconds kLong{20};

// A TCP socket that listens on a free port of this machine.
struct Listener {
  Listener() : socket(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(socket.get(), 1), 0);
    EXPECT_EQ(::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
    port = ntohs(address.sin_port);
  }
  Uri uri() const {
    Uri out;
    out.scheme = UriScheme::kTcp;
    out.host = "127.0.0.1";
    out.port = port;
    return out;
  }
  Fd socket;
  std::uint16_t port = 0;
};

TEST(Connect, ToATcpPortWithoutDelayOfSmallFrames) {
  const Listener listener;
  for (const std::chrono::milliseconds watchdog : {std::chrono::milliseconds(0), std::chrono::milliseconds(kLong)}) {
    const Fd socket = connect(listener.uri(), watchdog);
    int no_delay = 0;
    socklen_t size = sizeof no_delay;
    EXPECT_EQ(::getsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &no_delay, &size), 0);
    EXPECT_NE(no_delay, 0);
    int keep_alive = 0;
    EXPECT_EQ(::getsockopt(socket.get(), SOL_SOCKET, SO_KEEPALIVE, &keep_alive, &size), 0);
    EXPECT_NE(keep_alive, 0) << "a board whose machine has gone is noticed";
    EXPECT_EQ(::fcntl(socket.get(), F_GETFD), FD_CLOEXEC);
  }
}

TEST(Connect, WhereNobodyListensFailsWithThePlace) {
  Uri nobody;
  {
    const Listener listener;
    nobody = listener.uri();
  }
  const std::string where = "cannot connect to tcp:127.0.0.1:" + std::to_string(nobody.port) + ": ";
  EXPECT_THROWS(OpenFailed, where, connect(nobody, kLong));
  Uri path;
  path.scheme = UriScheme::kUnix;
  path.path = "/nowhere/board";
  EXPECT_THROWS(OpenFailed, "cannot connect to unix:/nowhere/board: ", connect(path, kLong));
  path.path = std::string(108, 'a');
  EXPECT_THAT([&] { connect(path, kLong); },
              ThrowsMessage<BadArgument>("URI path: expected at most 107 bytes, got 108"));
  path.path = std::string(107, 'a');
  EXPECT_THROW(connect(path, kLong), OpenFailed);
}

// A queue of one that is full: the next connection waits.
TEST(Connect, ThatIsNotTakenRunsIntoTheWatchdog) {
  const Listener listener;
  std::vector<Fd> waiting;
  std::string text;
  for (int i = 0; i < 8 && text.empty(); ++i) {
    try {
      waiting.push_back(connect(listener.uri(), std::chrono::milliseconds(100)));
    } catch (const TimedOut& error) {
      text = error.what();
    }
  }
  EXPECT_EQ(text, "no connection to tcp:127.0.0.1:" + std::to_string(listener.port) + " within 100 ms");
}

TEST(AccessToken, IsTheFirstOfTheNamedFileAndGoesToTcpAlone) {
  const reference::TemporaryDirectory folder;
  write_token(folder.file("token"), "0123456789abcdef");
  const Listener listener;
  const Fd socket = connect(listener.uri(), kLong);
  ::setenv("GICUBE_TOKEN_FILE", folder.file("token").c_str(), 1);
  EXPECT_EQ(access_token(socket.get(), false, {}), "0123456789abcdef");
  write_token(folder.file("other"), "fedcba9876543210");
  EXPECT_EQ(access_token(socket.get(), false, folder.file("other")), "fedcba9876543210") << "the option goes before";
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
  const Fd one(ends[0]), other(ends[1]);
  EXPECT_EQ(access_token(one.get(), true, {}), "");
  ::setenv("GICUBE_TOKEN_FILE", "/nowhere/token", 1);
  EXPECT_THAT([&] { access_token(socket.get(), false, {}); },
              ThrowsMessage<BadArgument>(
                  "GICUBE_TOKEN_FILE: expected a file with a token, got /nowhere/token: No such file or directory"));
  ::unsetenv("GICUBE_TOKEN_FILE");
  EXPECT_THAT([&] { access_token(socket.get(), false, "/nowhere/token"); },
              ThrowsMessage<BadArgument>(
                  "token_file: expected a file with a token, got /nowhere/token: No such file or directory"));
}

TEST(TlsClient, NamesTheHostThatItWantsInItsFirstMessage) {
  ::unsetenv("GICUBE_CA_FILE");
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
  Fd driver_end(ends[0]);
  std::string hello(4096, '\0');
  std::thread board([&hello, socket = Fd(ends[1])] {
    const ssize_t got = ::recv(socket.get(), hello.data(), hello.size(), 0);
    hello.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    ::shutdown(socket.get(), SHUT_RDWR);
  });
  LinkOptions options;
  options.tls = make_tls("board.example", {});
  EXPECT_THAT([&] { const Link link(std::move(driver_end), options); },
              ThrowsMessage<OpenFailed>(HasSubstr("no connection by TLS: ")));
  board.join();
  EXPECT_THAT(hello, HasSubstr("board.example"));
}

TEST(TlsClient, SpeaksNoVersionBefore12) {
  ::setenv("GICUBE_CA_FILE", "", 1);  // as without it
  const auto tls = make_tls("localhost", {});
  ::unsetenv("GICUBE_CA_FILE");
  const auto refused = ::SSL_CTX_get_options(tls->context.native_handle());
  EXPECT_NE(refused & SSL_OP_NO_TLSv1, 0u);
  EXPECT_NE(refused & SSL_OP_NO_TLSv1_1, 0u);
}

class CaptureFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "gicube-capture-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
  }
  void TearDown() override {
    ::unsetenv("GICUBE_CAPTURE");
    fs::remove_all(folder);
  }
  fs::path folder;
};

TEST_F(CaptureFile, HoldsAHeaderTheFramesAndTheEnd) {
  const fs::path file = folder / "session";
  std::array<std::uint8_t, wire::kFrameHeaderBytes> header{};
  const std::vector<std::uint8_t> payload{1, 2, 3};
  {
    const FrameTap tap = capture_session(file.string(), 0);
    tap(true, header, payload);
    tap(false, header, {});
  }
  // 16 bytes of the file, 16 of each record, their frames.
  EXPECT_EQ(fs::file_size(file), 16u + (16 + 48 + 3) + (16 + 48) + 16);
  capture_session(file.string(), 2);
  EXPECT_TRUE(fs::exists(folder / "session.2"));
  EXPECT_THROW(capture_session("/nowhere/session", 0), OpenFailed);
}

TEST_F(CaptureFile, CanBeReadByItsOwnerAlone) {
  std::ofstream(folder / "session") << "before";
  fs::permissions(folder / "session", fs::perms(0644));
  capture_session((folder / "session").string(), 0);
  EXPECT_EQ(fs::status(folder / "session").permissions(), fs::perms(0600));
}

TEST_F(CaptureFile, AFullDiskIsToldAndLeavesWhatWasThere) {
  const std::array<std::uint8_t, wire::kFrameHeaderBytes> header{};
  const std::vector<std::uint8_t> payload(3000);
  reference::expect_full_disk_leaves_nothing("session", 0, [](const std::string& file) { capture_session(file, 0); });
  reference::expect_full_disk_leaves_nothing("session", reference::kDiskBlock, [&](const std::string& file) {
    const FrameTap tap = capture_session(file, 0);
    tap(true, header, payload);
    tap(true, header, payload);
  });
  // The end of the last record lies on the end of the disk: there is nobody left to throw to.
  const std::vector<std::uint8_t> rest(reference::kDiskBlock - 16 - 16 - header.size());
  reference::on_full_disks("session", reference::kDiskBlock, [&](const std::string& at, const std::string& reason) {
    testing::internal::CaptureStderr();
    capture_session(at + "/session", 0)(true, header, rest);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "gicube: capture: " + at + "/session: " + reason + "\n");
    EXPECT_EQ(reference::files_in(at).at("session"), "before");
    EXPECT_EQ(reference::files_in(at).size(), 1u);
  });
}

TEST_F(CaptureFile, ThatHasFailedGivesTheDiskBackAtOnceAndIsWrittenNoMore) {
  const std::array<std::uint8_t, wire::kFrameHeaderBytes> header{};
  const std::vector<std::uint8_t> payload(2 * reference::kDiskBlock);
  reference::on_full_disks("session", reference::kDiskBlock, [&](const std::string& at, const std::string& reason) {
    const FrameTap tap = capture_session(at + "/session", 0);
    EXPECT_THROWS(std::runtime_error, reason, tap(true, header, payload));
    EXPECT_EQ(reference::files_in(at).size(), 1u) << "while the tap is still there";
    EXPECT_THAT([&] { tap(true, header, {}); }, ThrowsMessage<std::runtime_error>("capture: an earlier write failed"));
  });
}

TEST_F(CaptureFile, IsNamedByTheEnvironmentIfNotByTheUri) {
  ::unsetenv("GICUBE_CAPTURE");
  EXPECT_FALSE(capture_session("", 0));
  ::setenv("GICUBE_CAPTURE", "", 1);
  EXPECT_FALSE(capture_session("", 0));
  ::setenv("GICUBE_CAPTURE", (folder / "all").c_str(), 1);
  EXPECT_TRUE(capture_session("", 5));
  EXPECT_TRUE(capture_session("", 5));
  EXPECT_TRUE(fs::exists(folder / "all"));
  EXPECT_TRUE(fs::exists(folder / "all.1"));
}

}  // namespace
}  // namespace gicube
