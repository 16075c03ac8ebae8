// gicube-smi doctor: each reason why a board can't be opened is told from the others.
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "board_process.h"
#include "gicube/board.h"
#include "run_program.h"
#include "temporary_directory.h"
#include "test.h"
#include "unix_socket.h"

namespace gicube::tools_test {
namespace {

using reference::TemporaryDirectory;
using system_test::BoardProcess;

Finished doctor(const std::string& uri, const std::vector<std::string>& variables = {}) {
  return run_program("gicube-smi", {"doctor", uri}, variables);
}

// A Unix socket that nobody listens on, or that takes connections and is silent.
class DeafSocket {
 public:
  DeafSocket(const std::string& path, bool listens) : fd_(reference::bound_socket(path, listens ? 4 : 0)) {}
  ~DeafSocket() { ::close(fd_); }

 private:
  int fd_;
};

TEST(Doctor, FindsNothingWrongWithAPrivateBoard) {
  const Finished run = doctor("emu:");
  EXPECT_EQ(run.code, 0) << run.out;
  EXPECT_THAT(run.out, HasSubstr("gicube-board (gicube-board 0."));
  EXPECT_THAT(run.out, HasSubstr("can it be opened? yes: protocol"));
}

TEST(Doctor, SaysThatTheProgramIsNotThere) {
  const Finished run = doctor("emu:", {"GICUBE_BOARD=/no/such/program"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr("GICUBE_BOARD names /no/such/program, which does not exist"));
}

TEST(Doctor, SaysThatTheProgramMayNotBeRun) {
  const TemporaryDirectory folder;
  const std::string program = folder.file("gicube-board");
  std::ofstream(program) << "text";
  const Finished run = doctor("emu:", {"GICUBE_BOARD=" + program});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr("is not a program that"));
  EXPECT_THAT(run.out, HasSubstr("-> chmod +x " + program));
}

TEST(Doctor, SaysThatAConfigurationIsRefused) {
  const Finished run = doctor("emu:?set=asic.processors=99");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr("asic.processors: expected 1 to 16 processors, got 99"));
  EXPECT_THAT(run.out, HasSubstr("-> correct the URI"));
}

TEST(Doctor, TellsAMissingSocketFromADeadOne) {
  const TemporaryDirectory folder;
  const Finished missing = doctor("unix:" + folder.file("none"));
  EXPECT_EQ(missing.code, 1);
  EXPECT_THAT(missing.out, HasSubstr("No such file or directory"));
  EXPECT_THAT(missing.out, HasSubstr("-> start a board: gicube-board --listen unix:" + folder.file("none")));
  const DeafSocket dead(folder.file("dead"), false);
  const Finished run = doctor("unix:" + folder.file("dead"));
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr("the socket is left from a board that has ended"));
  std::ofstream(folder.file("text")) << "text";
  EXPECT_THAT(doctor("unix:" + folder.file("text")).out, HasSubstr("is something else"));
}

TEST(Doctor, SaysWhoMayOpenASocket) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may open every socket";
  const TemporaryDirectory folder;
  const DeafSocket socket(folder.file("closed"), true);
  ::chmod(folder.file("closed").c_str(), 0);
  EXPECT_THAT(doctor("unix:" + folder.file("closed")).out, HasSubstr("may it be opened? not by"));
}

TEST(Doctor, SaysThatSomethingElseListensThere) {
  const TemporaryDirectory folder;
  const DeafSocket silent(folder.file("silent"), true);
  const Finished run = doctor("unix:" + folder.file("silent"));
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr("is it a gicube-board?"));
}

TEST(Doctor, SaysThatABoardHasAnOwner) {
  const TemporaryDirectory folder;
  BoardProcess process({"--listen", "unix:" + folder.file("bus"), "--quiet"});
  process.read_line();
  const Board owner = Board::open("unix:" + folder.file("bus"));
  const Finished run = doctor("unix:" + folder.file("bus"));
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr("owner"));
  EXPECT_THAT(run.out, HasSubstr("gicube-smi reset"));
}

TEST(Doctor, SaysThatAPortOrAHostIsNot) {
  const Finished port = doctor("tcp:127.0.0.1:1");
  EXPECT_EQ(port.code, 1);
  EXPECT_THAT(port.out, HasSubstr("port 1: Connection refused"));
  EXPECT_THAT(doctor("tls:127.0.0.1:1").out,
              HasSubstr("gicube-board --listen tcp:127.0.0.1:1 --tls-cert FILE --tls-key FILE"));
  const Finished host = doctor("tcp:no-such-host.invalid:4711");
  EXPECT_EQ(host.code, 1);
  EXPECT_THAT(host.out, HasSubstr("is the host known? no-such-host.invalid:"));
}

TEST(Doctor, SpeaksJson) {
  const auto result =
      nlohmann::json::parse(run_program("gicube-smi", {"doctor", "unix:/no/such/socket", "--json"}).out);
  EXPECT_FALSE(result["healthy"]);
  EXPECT_FALSE(result["steps"].back()["good"]);
}

TEST(Doctor, SaysWhatIsWrongWithAUri) {
  const Finished run = doctor("usb:3");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr("expected emu:, unix:PATH, tcp:HOST:PORT, tls:HOST:PORT or pci:ADDRESS"));
}

}  // namespace
}  // namespace gicube::tools_test
