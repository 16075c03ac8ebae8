// Boards as PCI functions of a guest (script/guest): what an application there sees is what it sees over a socket, and
// whatever happens to a function, its bridge or its board, the guest goes on.
//
// The tests share one guest with two functions. They run in this order, each also alone; the last two end what they
// share.
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "board_process.h"
#include "good_client.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::system_test {
namespace {

namespace fs = std::filesystem;
using testing::MatchesRegex;
using testing::Not;

constexpr const char* kProbe = GICUBE_TESTS_DIR "/gicube-guest-probe";
constexpr std::chrono::seconds kPatience{120};  // a guest boots in 3 s, and in 40 on a machine with ten times the work

// A shell in the guest: commands go in by its serial line, and come out with their output.
class Guest {
 public:
  explicit Guest(const std::vector<std::string>& boards) {
    std::vector<std::string> words{GICUBE_SOURCE_DIR "/script/guest", "--add", kProbe};
    for (const std::string& board : boards) words.insert(words.end(), {"--board", board});
    words.insert(words.end(), {"--", "sh", "-c", "echo booted; exec sh /dev/ttyS0"});
    std::array<int, 2> in{}, out{};
    if (::pipe2(in.data(), O_CLOEXEC) != 0 || ::pipe2(out.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    process_ = ::fork();
    if (process_ == 0) {
      std::vector<char*> argv;
      for (std::string& word : words) argv.push_back(word.data());
      argv.push_back(nullptr);
      ::setpgid(0, 0);
      ::prctl(PR_SET_PDEATHSIG, SIGTERM);
      ::dup2(in[0], STDIN_FILENO);
      ::dup2(out[1], STDOUT_FILENO);
      ::execv(argv[0], argv.data());
      ::_exit(126);
    }
    ::close(in[0]);
    ::close(out[1]);
    in_ = in[1];
    out_ = out[0];
  }
  ~Guest() {
    if (process_ > 0) ::kill(-process_, SIGKILL);
    ::close(in_);
    ::close(out_);
    exit_code();
  }
  Guest(const Guest&) = delete;
  Guest& operator=(const Guest&) = delete;

  // All output up to a line that is `end`, without it; nothing if the output ends before it, or nothing comes for a
  // long time.
  std::optional<std::string> read_until(const std::string& end) {
    for (const auto limit = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < limit;) {
      if (const std::size_t at = ("\n" + read_).find("\n" + end + "\n"); at != std::string::npos) {
        const std::string text = read_.substr(0, at);
        read_.erase(0, at + end.size() + 1);
        return text;
      }
      std::array<char, 4096> bytes{};
      pollfd waits{out_, POLLIN, 0};
      if (::poll(&waits, 1, 1000) == 0) {
        send("");  // the interrupt of what came last may be lost
        continue;
      }
      const ssize_t count = ::read(out_, bytes.data(), bytes.size());
      if (count <= 0) return std::nullopt;
      read_.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return std::nullopt;
  }
  void send(const std::string& line) {
    const std::string text = line + "\n";
    // If the guest has ended, read_until() reports it.
    [[maybe_unused]] const auto written = ::write(in_, text.data(), text.size());
  }
  // The output of a command, and "code N" behind it.
  std::string run(const std::string& command) {
    if (!answers_) return "the guest has not answered before";
    send("{ " + command + "\n} 2>&1; echo \"code $?\"; echo '---'");
    const auto text = read_until("---");
    answers_ = text.has_value();
    return text.value_or("the guest does not answer: " + read_);
  }
  int exit_code() {
    int status = 0;
    if (process_ < 0 || ::waitpid(std::exchange(process_, -1), &status, 0) < 0) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  bool has_ended() const {
    siginfo_t info{};
    return ::waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOWAIT | WNOHANG) == 0 && info.si_pid != 0;
  }
  // To the script alone.
  void send_signal(int signal) const { ::kill(process_, signal); }
  // The output of a guest with one function, once it has been started; nothing if the script has ended before.
  std::optional<pid_t> qemu() const {
    for (const auto limit = std::chrono::steady_clock::now() + kPatience;
         !has_ended() && std::chrono::steady_clock::now() < limit; ::usleep(10'000)) {
      try {
        return child_of(bridge(0), "qemu-system-x86");
      } catch (const std::runtime_error&) {  // not yet
      }
    }
    return std::nullopt;
  }
  // The gicube-pci of the function: the first is the outermost.
  pid_t bridge(int function) const {
    pid_t found = process_;
    for (int i = 0; i <= function; ++i) found = child_of(found, "gicube-pci");
    return found;
  }

 private:
  static pid_t child_of(pid_t parent, const std::string& name) {
    const std::string tasks = "/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children";
    std::ifstream children(tasks);
    for (pid_t each = 0; children >> each;) {
      std::string called;
      std::getline(std::ifstream("/proc/" + std::to_string(each) + "/comm"), called);
      if (called == name) return each;
    }
    throw std::runtime_error("no " + name);
  }

  pid_t process_ = -1;
  int in_ = -1, out_ = -1;
  std::string read_;
  bool answers_ = true;
};

class InGuest : public testing::Test {
 protected:
  static constexpr const char *kFirst = "pci:0000:00:04.0", *kSecond = "pci:0000:00:05.0";
  static constexpr const char* kFolder = "/sys/bus/pci/devices/0000:00:04.0";

  static void SetUpTestSuite() {
    ::signal(SIGPIPE, SIG_IGN);
    shared_ = std::make_unique<Shared>();
    start_board(0);
    start_board(1);
    shared_->expected = on_host("unix:" + socket(0));
    ASSERT_THAT(shared_->expected, MatchesRegex("pictures .* rays .* ps\n"));
    auto guest = std::make_unique<Guest>(std::vector<std::string>{"unix:" + socket(0), "unix:" + socket(1)});
    if (guest->read_until("booted")) {
      shared_->guest = std::move(guest);
      return;
    }
    constexpr int kCannot = 77;  // it has said why
    if (!guest->has_ended()) FAIL() << "the guest does not boot";
    if (const int code = guest->exit_code(); code != kCannot) FAIL() << "script/guest ended with " << code;
  }
  static void TearDownTestSuite() { shared_.reset(); }
  void SetUp() override {
    if (!shared_->guest) GTEST_SKIP() << "QEMU or the guest's kernel cannot be had";
  }

  static Guest& guest() { return *shared_->guest; }
  static std::string socket(int board) { return shared_->folder.file("board" + std::to_string(board)); }
  static void start_board(int board, const std::string& plan = "") {
    std::vector<std::string> arguments{
        "--listen", "unix:" + socket(board), "--quiet", "--set", "asic.max_volume_voxels=64", "--set", "threads=1"};
    if (!plan.empty()) {
      std::ofstream(shared_->folder.file("plan")) << plan;
      arguments.insert(arguments.end(), {"--faults", shared_->folder.file("plan")});
    }
    shared_->boards[static_cast<std::size_t>(board)].reset();
    shared_->boards[static_cast<std::size_t>(board)] = std::make_unique<BoardProcess>(arguments);
    ASSERT_THAT(board_process(board).read_line(), HasSubstr("ready"));
  }
  static BoardProcess& board_process(int board) { return *shared_->boards[static_cast<std::size_t>(board)]; }
  static std::string on_host(const std::string& uri) {
    BoardProcess probe({"work", uri}, -1, kProbe);
    return probe.read_output();
  }
  // A round of work in the guest has the bits and times of one over the socket.
  static void expect_work(const std::string& uri) {
    EXPECT_EQ(guest().run(std::string("gicube-guest-probe work ") + uri), shared_->expected + "code 0\n");
  }
  static bool wait_for(const std::string& command, const std::string& text) {
    for (int i = 0; i < 100; ++i) {
      if (guest().run(command).find(text) != std::string::npos) return true;
      guest().run("sleep 0.1");
    }
    return false;
  }

  struct Shared {
    reference::TemporaryDirectory folder;
    std::array<std::unique_ptr<BoardProcess>, 2> boards;
    std::string expected;  // of a round over the socket
    std::unique_ptr<Guest> guest;
  };
  static std::unique_ptr<Shared> shared_;
};
std::unique_ptr<InGuest::Shared> InGuest::shared_;

TEST_F(InGuest, FindsTwoFunctions) {
  const std::string seen = guest().run("lspci -vv -s 00:04.0");
  for (const char* part :
       {"4749:0c5b", "Region 0: Memory at", "[size=4K]", "Interrupt: pin A", "[40] Power Management version 2",
        "[48] PCI Advanced Features", "AFCap: TP+ FLR+", "Kernel driver in use: uio_pci_generic"}) {
    EXPECT_THAT(seen, HasSubstr(part));
  }
  EXPECT_THAT(seen, Not(HasSubstr("Region 2")));
  EXPECT_EQ(guest().run("gicube-guest-probe found"),
            "pci:0000:00:04.0: GI-Cube (PCI function), free\npci:0000:00:05.0: GI-Cube (PCI function), free\ncode 0\n");
  EXPECT_THAT(guest().run("gicube-smi list"), MatchesRegex("(.|\n)*pci:0000:00:05.0 [^\n]* free *\ncode 0\n"));
  EXPECT_THAT(guest().run("gicube-smi"), HasSubstr("pci:0000:00:04.0"));
}

TEST_F(InGuest, PassesValidate) {
  EXPECT_THAT(guest().run("gicube-smi validate pci:00:04.0"), HasSubstr("8 of 8 tests passed\ncode 0"));
}

TEST_F(InGuest, SaysWhatIsMissing) {
  EXPECT_THAT(guest().run("gicube-smi doctor pci:00:04.0"), HasSubstr("can it be opened? yes"));
  EXPECT_THAT(guest().run("gicube-smi doctor pci:00:09.0"), HasSubstr("BAD   is there a PCI function? 0000:00:09.0"));
  EXPECT_THAT(guest().run("gicube-smi doctor pci:00:01.0"), HasSubstr("BAD   is it a GI-Cube board? 8086:7000"));
  EXPECT_THAT(guest().run("echo 0 > /proc/sys/vm/nr_hugepages; gicube-smi doctor pci:00:04.0"),
              HasSubstr("BAD   is there a huge page for its rings? 0 free pages of 2 MiB\n        -> echo 4 >"));
  EXPECT_THAT(guest().run("gicube-guest-probe work pci:00:04.0"),
              HasSubstr("echo 4 > /proc/sys/vm/nr_hugepages\ncode 1"));
  EXPECT_THAT(
      guest().run(
          "echo 8 > /proc/sys/vm/nr_hugepages; chmod 755 /tmp; mkdir -p /etc; echo 'u:x:7:7::/:/bin/sh' > /etc/passwd; "
          "su u -c 'gicube-smi doctor pci:00:04.0'"),
      HasSubstr("resource0: Permission denied\n        -> run as root"));
}

TEST_F(InGuest, HasTheBitsAndTimesOfTheSocket) {
  // Both functions at once.
  EXPECT_EQ(guest().run("gicube-guest-probe work pci:00:05.0 > /tmp/second & gicube-guest-probe work pci:00:04.0; "
                        "wait; cat /tmp/second"),
            shared_->expected + shared_->expected + "code 0\n");
}

TEST_F(InGuest, ResumesThroughPlannedFaults) {
  start_board(
      1,
      "fault { direction: down message: 10 kind: drop } fault { direction: up message: 5 kind: corrupt bit: 100 }\n"
      "fault { direction: down message: 30 kind: duplicate } fault { direction: up message: 12 kind: link_loss }\n");
  expect_work(kSecond);
  start_board(1);
}

TEST_F(InGuest, IsFreeWhenItsOwnerIsKilled) {
  guest().run("gicube-guest-probe hold pci:00:04.0 > /tmp/held & echo $! > /tmp/id");
  ASSERT_TRUE(wait_for("cat /tmp/held", "holding"));
  EXPECT_THAT(guest().run("gicube-guest-probe work pci:00:04.0"),
              HasSubstr("another process has opened the PCI function 0000:00:04.0"));
  guest().run("kill -9 $(cat /tmp/id)");
  EXPECT_TRUE(wait_for("gicube-guest-probe found", "04.0: GI-Cube (PCI function), free"));
  expect_work(kFirst);
}

TEST_F(InGuest, LosesItsSessionByAResetAndWorksAfterAHundred) {
  guest().run("gicube-guest-probe hold pci:00:04.0 > /tmp/held &");
  ASSERT_TRUE(wait_for("cat /tmp/held", "holding"));
  EXPECT_THAT(guest().run(std::string("cd ") + kFolder +
                          "; echo af_flr > reset_method; echo 1 > reset; wait; cat /tmp/held; cd /tmp"),
              HasSubstr("lost ("));
  EXPECT_THAT(guest().run(std::string("cd ") + kFolder +
                          "; echo pm > reset_method; for i in $(seq 95); do echo 1 > reset || exit; done; "
                          "echo af_flr > reset_method; for i in $(seq 5); do echo 1 > reset || exit; done; cd /tmp"),
              HasSubstr("code 0"));
  expect_work(kFirst);
}

TEST_F(InGuest, EnduresAHostileProgram) {
  for (int seed = 1; seed <= 2; ++seed) {
    EXPECT_EQ(guest().run("gicube-guest-probe hostile 0000:00:04.0 " + std::to_string(seed) + " 4000"),
              "did 4000 things, and the function answers\ncode 0\n");
  }
  expect_work(kFirst);
  EXPECT_FALSE(board_process(0).has_ended());
}

TEST_F(InGuest, LosesAKilledBoardAndFindsTheNext) {
  guest().run("gicube-guest-probe hold pci:00:04.0 > /tmp/held &");
  ASSERT_TRUE(wait_for("cat /tmp/held", "holding"));
  board_process(0).send_signal(SIGKILL);
  EXPECT_THAT(guest().run("wait; cat /tmp/held"), HasSubstr("lost (0): "));
  EXPECT_THAT(guest().run("gicube-guest-probe work pci:00:04.0"), HasSubstr("its board cannot be connected\ncode 1"));
  start_board(0);
  expect_work(kFirst);
}

TEST_F(InGuest, WorksAfterTheGuestHasBootedAgain) {
  guest().send("reboot -f");
  ASSERT_TRUE(guest().read_until("booted"));
  expect_work(kFirst);
}

TEST_F(InGuest, GoesOnWithoutABridgeThatWasKilled) {
  guest().run("gicube-guest-probe hold pci:00:05.0 > /tmp/held &");
  ASSERT_TRUE(wait_for("cat /tmp/held", "holding"));
  ASSERT_EQ(::kill(guest().bridge(1), SIGKILL), 0);
  EXPECT_THAT(guest().run("wait; cat /tmp/held"), HasSubstr("lost (0): "));
  EXPECT_THAT(guest().run("gicube-guest-probe work pci:00:05.0"), HasSubstr("was it removed?\ncode 1"));
  expect_work(kFirst);
}

TEST_F(InGuest, EndsWithTheCommandsExitCode) {
  guest().send("exit 42");
  EXPECT_FALSE(guest().read_until("anything more"));
  EXPECT_EQ(guest().exit_code(), 42);
}

TEST(GuestScript, TakesQemuWithIt) {
  Guest guest({});
  const auto qemu = guest.qemu();
  constexpr int kCannot = 77;
  if (!qemu && guest.exit_code() == kCannot) GTEST_SKIP() << "QEMU or the guest's kernel cannot be had";
  ASSERT_TRUE(qemu);
  guest.send_signal(SIGTERM);
  EXPECT_EQ(guest.exit_code(), 128 + SIGTERM);
  // Gone, or a zombie that nobody has waited for yet.
  const auto runs = [&qemu] {
    std::string line;
    return static_cast<bool>(std::getline(std::ifstream("/proc/" + std::to_string(*qemu) + "/cmdline"), line));
  };
  const auto limit = std::chrono::steady_clock::now() + kPatience;
  while (runs() && std::chrono::steady_clock::now() < limit) ::usleep(10'000);
  EXPECT_FALSE(runs());
}

}  // namespace
}  // namespace gicube::system_test
