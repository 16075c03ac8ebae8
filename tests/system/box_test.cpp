// gicube-board in its box: as the kernel sees it, and as the code of a scattering routine sees its own.
#include <signal.h>
#include <sys/resource.h>

#include <cerrno>

#include "board_process.h"
#include "gicube/board.h"
#include "temporary_directory.h"
#include "test.h"
#include "test_board.h"

namespace gicube::system_test {
namespace {

using reference::TemporaryDirectory;
using testing::Each;
using testing::Not;

// A line of /proc/PID/status of each thread, as "Seccomp:\t2".
std::vector<std::string> of_threads(pid_t process, const std::string& name) {
  std::vector<std::string> found;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
    std::ifstream file(thread.path() / "status");
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with(name + ":")) found.push_back(line);
    }
  }
  return found;
}

class BoxedBoard : public testing::Test {
 protected:
  // By what a board says.
  void SetUp() override {
    BoardProcess board({"--listen", "unix:" + folder_.file("first")});
    board.read_line();
    board.send_signal(SIGTERM);
    const std::string log = board.read_errors();
    if (log.find("no box") != std::string::npos || log.find("no limit") != std::string::npos) GTEST_SKIP() << log;
    EXPECT_THAT(log, ContainsRegex("box: files by Landlock [0-9]+; system calls by a filter\n"));
  }

  const TemporaryDirectory folder_;
};

TEST_F(BoxedBoard, HoldsAllThreadsOfAServingProcess) {
  const std::string path = folder_.file("board");
  BoardProcess process({"--listen", "unix:" + path, "--boards", "2", "--management", "tcp:127.0.0.1:0", "--audit-log",
                        folder_.file("audit"), "--quiet"});
  for (int line = 0; line < 3; ++line) process.read_line();
  Board board = Board::open("unix:" + path);
  const std::vector<std::byte> samples(8 * 8 * 8, std::byte{9});
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {8, 8, 8}});
  EXPECT_GT(of_threads(process.id(), "Seccomp").size(), 3u);
  EXPECT_THAT(of_threads(process.id(), "Seccomp"), Each("Seccomp:\t2"));
  EXPECT_THAT(of_threads(process.id(), "NoNewPrivs"), Each("NoNewPrivs:\t1"));
}

TEST_F(BoxedBoard, HoldsTheBoardThatAnApplicationStarts) {
  const auto opened = open_board_process();
  EXPECT_THAT(of_threads(opened.id, "Seccomp"), Each("Seccomp:\t2"));
  EXPECT_THAT(of_threads(opened.id, "NoNewPrivs"), Each("NoNewPrivs:\t1"));
}

TEST_F(BoxedBoard, LeavesItOutIfAskedTo) {
  BoardProcess process({"--listen", "unix:" + folder_.file("board"), "--box", "off"});
  process.read_line();
  EXPECT_THAT(of_threads(process.id(), "Seccomp"), Each("Seccomp:\t0"));
  process.send_signal(SIGTERM);
  EXPECT_THAT(process.read_errors(), Not(HasSubstr("box")));
}

class Trespasser : public BoxedBoard {
 protected:
  // Has the routine's parameters checked. What comes of it is the caller's.
  static void check_parameters(Board& board, std::vector<float> parameters) {
    const BoxVolume volume(8, 2, 5);
    board.load_volume(volume.view());
    board.set_transfer_function(step_function(0.5));
    board.set_material({.scattering = 1, .bsdf = Bsdf::kTrap, .routine = 8, .parameters = std::move(parameters)});
    const std::vector<Light> lights{PointLight{{4, 4, 0}}};
    board.illuminate(lights, {});
  }

  const std::vector<std::string> arguments_{"--listen", "unix:" + folder_.file("board"), "--bsdf",
                                            (GICUBE_TEST_DIR "/trespassing_bsdf.so"), "--quiet"};
};

TEST_F(Trespasser, ReadsAndMakesNoFileAndReachesNobody) {
  BoardProcess process(arguments_);
  process.read_line();
  Board board = Board::open("unix:" + folder_.file("board"));
  const std::string eperm = std::to_string(EPERM);
  const std::string refused = "read " + eperm + ", make " + eperm + ", reach " + eperm + ", signal " + eperm;
  EXPECT_THROWS(Rejected, refused, check_parameters(board, {}));
}

TEST_F(Trespasser, LosesItsProcessIfItStartsAProgram) {
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  BoardProcess process(arguments_);
  process.read_line();
  Board board = Board::open("unix:" + folder_.file("board"));
  EXPECT_THROWS(Rejected, "its process was ended by signal " + std::to_string(SIGSYS), check_parameters(board, {1}));
  EXPECT_TRUE(board.counters().has("bus.down.bytes")) << "the board goes on";
}

TEST_F(Trespasser, MayReadAndSignalWithoutABox) {
  std::vector<std::string> arguments = arguments_;
  arguments.insert(arguments.end(), {"--box", "off"});
  BoardProcess process(arguments);
  process.read_line();
  Board board = Board::open("unix:" + folder_.file("board"));
  EXPECT_THAT([&] { check_parameters(board, {}); },
              ThrowsMessage<Rejected>(AllOf(HasSubstr("read 0, "), HasSubstr("signal 0"))));
}

}  // namespace
}  // namespace gicube::system_test
