// gicube-board as its user starts it.
#include "board_process.h"

#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "gicube/access.h"
#include "gicube/wire/register_markdown.h"
#include "gicube/wire/registers.h"
#include "raw_client.h"
#include "temporary_directory.h"
#include "test.h"
#include "unix_socket.h"

namespace gicube::system_test {
namespace {

using reference::RawClient;
using reference::TemporaryDirectory;

bool is_owner_only(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode) && (status.st_mode & 077) == 0;
}

TEST(BoardProcess, SaysWhenItIsReadyServesAndEndsCleanlyOnSignals) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const TemporaryDirectory folder;
    const std::string path = folder.file("board"), management = folder.file("management");
    BoardProcess board({"--listen", "unix:" + path, "--management", "unix:" + management, "--quiet"});
    EXPECT_EQ(board.read_line(), "gicube-board: board 0 ready on unix:" + path);
    EXPECT_EQ(board.read_line(), "gicube-board: management ready on unix:" + management);
    EXPECT_TRUE(is_owner_only(path));
    EXPECT_TRUE(is_owner_only(management));
    {
      RawClient client = RawClient::connect_unix(path);
      ASSERT_TRUE(client.handshake().has_value());
      EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
    }
    board.send_signal(signal);
    EXPECT_EQ(board.exit_code(), 0);
    EXPECT_FALSE(std::filesystem::exists(path));
    EXPECT_FALSE(std::filesystem::exists(management));
    EXPECT_EQ(board.read_errors(), "");
  }
}

TEST(BoardProcess, ASignalEndsItUnderAnOpenSession) {
  const TemporaryDirectory folder;
  const std::string path = folder.file("board");
  BoardProcess board({"--listen", "unix:" + path, "--quiet"});
  board.read_line();
  RawClient client = RawClient::connect_unix(path);
  ASSERT_TRUE(client.handshake().has_value());
  board.send_signal(SIGTERM);
  const auto last = client.receive();
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.error, wire::ErrorCode::kCancelled);
  client.close();
  EXPECT_EQ(board.exit_code(), 0);
}

TEST(BoardProcess, SeveralBoardsListenSideBySide) {
  const TemporaryDirectory folder;
  const std::string path = folder.file("board");
  BoardProcess board({"--listen", "unix:" + path, "--boards", "3", "--set", "asic.processors=2", "--quiet"});
  for (const std::string suffix : {"", ".1", ".2"}) {
    EXPECT_THAT(board.read_line(), EndsWith("ready on unix:" + path + suffix));
  }
  std::vector<RawClient> clients;
  for (const std::string suffix : {"", ".1", ".2"}) {
    clients.push_back(RawClient::connect_unix(path + suffix));
    ASSERT_TRUE(clients.back().handshake().has_value());
    EXPECT_EQ(clients.back().read_register(wire::reg::kProcessors), 2u);
  }
}

TEST(BoardProcess, ATcpPortOfItsChoiceIsPrinted) {
  BoardProcess board({"--listen", "tcp:localhost:0", "--quiet"});
  const std::string line = board.read_line();
  ASSERT_THAT(line, HasSubstr("ready on tcp:127.0.0.1:"));
  const int port = std::stoi(line.substr(line.rfind(':') + 1));
  ASSERT_GT(port, 0);
  RawClient client = RawClient::connect_tcp(static_cast<std::uint16_t>(port));
  const std::string token = local_token("127.0.0.1", static_cast<std::uint16_t>(port));
  ASSERT_TRUE(client.handshake({}, token).has_value());
  EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
  board.send_signal(SIGTERM);
  EXPECT_EQ(board.exit_code(), 0);
  EXPECT_EQ(local_token("127.0.0.1", static_cast<std::uint16_t>(port)), "") << "it has taken its token away";
}

// In the audit log, and without one in its log on standard error.
TEST(BoardProcess, EachTokenThatIsGuessedLeavesALine) {
  const TemporaryDirectory folder;
  const std::string audit = folder.file("audit");
  for (const bool to_file : {true, false}) {
    std::vector<std::string> arguments{"--listen", "tcp:127.0.0.1:0"};
    if (to_file) arguments.insert(arguments.end(), {"--audit-log", audit});
    BoardProcess board(arguments);
    const std::string line = board.read_line();
    const auto port = static_cast<std::uint16_t>(std::stoi(line.substr(line.rfind(':') + 1)));
    for (const char* guess : {"a_guess_of_a_token_1", "a_guess_of_a_token_2"}) {
      const auto answer = RawClient::connect_tcp(port).handshake({}, guess);
      ASSERT_TRUE(answer.has_value());
      EXPECT_EQ(answer->header.error, wire::ErrorCode::kForbidden);
    }
    board.send_signal(SIGTERM);
    EXPECT_EQ(board.exit_code(), 0);
    const std::string log = to_file ? text_of(audit) : board.read_errors();
    const std::string guess = "unknown: 127\\.0\\.0\\.1:[0-9]+: its token is wrong\n";
    EXPECT_THAT(log, ContainsRegex(guess + "(.*\n)*.*" + guess));
    EXPECT_THAT(log, testing::Not(HasSubstr("a_guess"))) << "what was nearly right is not to be read there";
  }
}

TEST(BoardProcess, GoesOnIfNobodyReadsItsLogAnyMore) {
  BoardProcess board({"--listen", "tcp:127.0.0.1:0"});
  const std::string line = board.read_line();
  const auto port = static_cast<std::uint16_t>(std::stoi(line.substr(line.rfind(':') + 1)));
  board.stop_reading();
  for (const char* guess : {"a_guess_of_a_token_1", "a_guess_of_a_token_2"}) {
    const auto answer = RawClient::connect_tcp(port).handshake({}, guess);  // which it has to log
    ASSERT_TRUE(answer.has_value()) << "it has ended";
    EXPECT_EQ(answer->header.error, wire::ErrorCode::kForbidden);
  }
  EXPECT_TRUE(RawClient::connect_tcp(port).handshake({}, local_token("127.0.0.1", port)).has_value());
  board.send_signal(SIGTERM);
  EXPECT_EQ(board.exit_code(), 0);
}

TEST(BoardProcess, APrivateOneEndsWithItsSession) {
  int pair[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair), 0);
  BoardProcess board({"--listen", "fd:" + std::to_string(pair[1]), "--private", "--quiet"}, pair[1]);
  ::close(pair[1]);
  {
    RawClient client(pair[0]);
    ASSERT_TRUE(client.handshake().has_value());
    EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
  }
  EXPECT_EQ(board.exit_code(), 0);
  EXPECT_EQ(board.read_output(), "");
}

// What systemd does for a socket unit: clients can connect before the board runs, and while it is started anew.
TEST(BoardProcess, ServesClientsOfASocketThatListensBeforeItRuns) {
  const TemporaryDirectory folder;
  const std::string path = folder.file("board");
  const int socket = reference::bound_socket(path);
  const std::string fd = "fd:" + std::to_string(socket);
  for (int start = 0; start < 2; ++start) {
    RawClient client = RawClient::connect_unix(path);
    BoardProcess board({"--listen", fd, "--quiet"}, socket);
    EXPECT_EQ(board.read_line(), "gicube-board: board 0 ready on unix:" + path);
    ASSERT_TRUE(client.handshake().has_value());
    EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
    client.close();
    board.send_signal(SIGTERM);
    EXPECT_EQ(board.exit_code(), 0);
    EXPECT_TRUE(std::filesystem::exists(path));
  }
  BoardProcess refused({"--listen", fd, "--private", "--quiet"}, socket);
  EXPECT_EQ(refused.exit_code(), 1);
  EXPECT_THAT(refused.read_errors(), HasSubstr(fd + ": expected a connected stream socket\n"));
  ::close(socket);
}

TEST(BoardProcess, TakesOverAStaleSocketButNotALiveOne) {
  const TemporaryDirectory folder;
  const std::string path = folder.file("board");
  {
    BoardProcess killed({"--listen", "unix:" + path, "--quiet"});
    killed.read_line();
  }
  ASSERT_TRUE(std::filesystem::exists(path));
  BoardProcess board({"--listen", "unix:" + path, "--quiet"});
  EXPECT_THAT(board.read_line(), HasSubstr("ready on"));
  BoardProcess second({"--listen", "unix:" + path, "--quiet"});
  EXPECT_EQ(second.exit_code(), 1);
  EXPECT_THAT(second.read_errors(), HasSubstr("another process is listening there"));
  EXPECT_NO_THROW(RawClient::connect_unix(path));
}

TEST(BoardProcess, EveryConfigurationFaultIsOnStderrAndTheCodeIsTwo) {
  const TemporaryDirectory folder;
  const std::string file = folder.file("board.textproto");
  std::ofstream(file) << "asic {\n  processors: 99\n  colour: 3\n}\nfidelity: FIDELITY_UNSPECIFIED\n";
  BoardProcess board({"--listen", "unix:" + folder.file("board"), "--config", file, "--set", "bus.speed=1"});
  EXPECT_EQ(board.exit_code(), 2);
  EXPECT_EQ(board.read_output(), "");
  const std::string errors = board.read_errors();
  EXPECT_THAT(errors, HasSubstr("line 2: asic.processors: expected 1 to 16 processors, got 99"));
  EXPECT_THAT(errors, HasSubstr("line 3: asic.colour: expected one of processors"));
  EXPECT_THAT(errors, HasSubstr("line 5: fidelity: expected one of functional, cycle"));
  EXPECT_THAT(errors, HasSubstr("bus.speed: expected one of model"));
}

TEST(BoardProcess, OfThousandsOfConfigurationFaultsItPrintsFiftyAndTheNumberOfTheOthers) {
  const TemporaryDirectory folder;
  const std::string file = folder.file("board.textproto");
  {
    std::ofstream stream(file);
    for (int i = 0; i < 3000; ++i) stream << "colour: 3\n";
  }
  BoardProcess board({"--listen", "unix:" + folder.file("board"), "--config", file});
  EXPECT_EQ(board.exit_code(), 2);
  const std::string errors = board.read_errors();
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 51);
  EXPECT_THAT(errors, EndsWith("gicube-board: and 2950 more\n"));
}

TEST(BoardProcess, AHangUpEndsItAsItsTerminalWouldUnlessThatIsIgnored) {
  const TemporaryDirectory folder;
  const std::string path = folder.file("board");
  {
    BoardProcess board({"--listen", "unix:" + path, "--quiet"});
    board.read_line();
    board.send_signal(SIGHUP);
    EXPECT_EQ(board.exit_code(), 0);
    EXPECT_FALSE(std::filesystem::exists(path));
  }
  const auto before = std::signal(SIGHUP, SIG_IGN);  // as by nohup
  BoardProcess board({"--listen", "unix:" + path, "--quiet"});
  std::signal(SIGHUP, before);
  board.read_line();
  board.send_signal(SIGHUP);
  EXPECT_TRUE(RawClient::connect_unix(path).handshake().has_value());
  board.send_signal(SIGTERM);
  EXPECT_EQ(board.exit_code(), 0);
}

TEST(BoardProcess, PrintsAConfigurationThatItTakesBack) {
  BoardProcess printed({"--print-config", "--set", "asic.processors=8"});
  const std::string text = printed.read_output();
  EXPECT_EQ(printed.exit_code(), 0);
  EXPECT_THAT(text, HasSubstr("processors: 8"));
  EXPECT_THAT(text, HasSubstr("# config_hash: "));
  const TemporaryDirectory folder;
  std::ofstream(folder.file("board.textproto")) << text;
  BoardProcess again({"--print-config", "--config", folder.file("board.textproto")});
  EXPECT_EQ(again.read_output(), text);
}

TEST(BoardProcess, FailsIfWhatItPrintsGetsNowhere) {
  const TemporaryDirectory folder;
  for (const std::string flag :
       {"--print-config", "--explain-config", "--registers", "--hardware-cost", "--help", "--version"}) {
    const std::string command = GICUBE_BIN_DIR "/gicube-board " + flag + " >/dev/full 2>" + folder.file("errors");
    const int status = std::system(command.c_str());
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 1) << flag;
    std::string text;
    std::getline(std::ifstream(folder.file("errors")), text);
    EXPECT_THAT(text, AllOf(StartsWith("gicube-board: "), HasSubstr("No space left on device"))) << flag;
  }
}

TEST(BoardProcess, PrintsTheSharedRegisterTableAndMemoryMap) {
  BoardProcess board({"--registers"});
  EXPECT_EQ(board.read_output(), wire::register_markdown() + "\n" + wire::memory_markdown());
}

TEST(BoardProcess, SaysWhichScatteringRoutinesItHas) {
  const TemporaryDirectory folder;
  BoardProcess board({"--listen", "unix:" + folder.file("board"), "--bsdf", GICUBE_BIN_DIR "/brushed_metal.so"});
  board.read_line();
  board.send_signal(SIGTERM);
  EXPECT_EQ(board.exit_code(), 0);
  EXPECT_THAT(board.read_errors(), HasSubstr("scattering routine 8: \"brushed metal\" of " GICUBE_BIN_DIR));
}

TEST(BoardProcess, DoesNotStartWithARoutineThatItCannotLoad) {
  const TemporaryDirectory folder;
  const std::string text = folder.file("text.so");
  std::ofstream(text) << "no object\n";
  for (const std::string& file : {folder.file("none.so"), text}) {
    BoardProcess board({"--listen", "unix:" + folder.file("board"), "--bsdf", file});
    EXPECT_EQ(board.exit_code(), 2);
    EXPECT_THAT(board.read_errors(), AllOf(HasSubstr("gicube-board: --bsdf: "), HasSubstr(file)));
  }
}

}  // namespace
}  // namespace gicube::system_test
