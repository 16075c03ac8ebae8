#include "transport/launch.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <cerrno>
#include <exception>

#include "gicube/error.h"
#include "test.h"
#include "transport/event.h"

namespace gicube {
namespace {

namespace fs = std::filesystem;

// A folder with shell scripts that stand in for gicube-board; the environment is as before afterwards.
class Launch : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "gicube-launch-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    keep("GICUBE_BOARD");
    keep("PATH");
  }
  void TearDown() override {
    fs::remove_all(folder_);
    for (const auto& [name, value] : kept_) {
      if (value) {
        ::setenv(name.c_str(), value->c_str(), 1);
      } else {
        ::unsetenv(name.c_str());
      }
    }
  }

  std::string script(const std::string& body) {
    const fs::path path = folder_ / "gicube-board";
    std::ofstream(path) << "#!/bin/sh\n" << body << "\n";
    ::chmod(path.c_str(), 0700);
    return path.string();
  }

  static std::string receive_all(const Fd& socket) {
    std::string text;
    std::array<char, 256> bytes{};
    for (ssize_t got = 1; got > 0;) {
      got = ::recv(socket.get(), bytes.data(), bytes.size(), 0);
      if (got > 0) text.append(bytes.data(), static_cast<std::size_t>(got));
    }
    return text;
  }

  fs::path folder_;

 private:
  void keep(const std::string& name) {
    const char* value = std::getenv(name.c_str());
    kept_.emplace_back(name, value == nullptr ? std::nullopt : std::optional<std::string>(value));
  }
  std::vector<std::pair<std::string, std::optional<std::string>>> kept_;
};

TEST_F(Launch, TheEnvironmentVariableNamesTheProgram) {
  const std::string program = script("exit 0");
  ::setenv("GICUBE_BOARD", program.c_str(), 1);
  EXPECT_EQ(find_board_program(), program);
}

TEST_F(Launch, AnEnvironmentVariableThatNamesNothingIsAFaultAndNotPassedOver) {
  ::setenv("GICUBE_BOARD", "/nowhere/gicube-board", 1);
  EXPECT_THROWS(OpenFailed, "/nowhere/gicube-board", find_board_program());
}

TEST_F(Launch, ThePathIsSearched) {
  const std::string program = script("exit 0");
  ::unsetenv("GICUBE_BOARD");
  ::setenv("PATH", ("/nowhere::" + folder_.string()).c_str(), 1);
  EXPECT_EQ(find_board_program(), program);
}

TEST_F(Launch, AMissingProgramNamesEveryPlaceLookedAt) {
  ::unsetenv("GICUBE_BOARD");
  ::setenv("PATH", ("/nowhere:" + folder_.string()).c_str(), 1);
  const fs::path self = fs::read_symlink("/proc/self/exe").parent_path();
  EXPECT_THAT([] { find_board_program(); },
              ThrowsMessage<OpenFailed>(AllOf(HasSubstr("GICUBE_BOARD"), HasSubstr((self / "gicube-board").string()),
                                              HasSubstr("/nowhere/gicube-board"),
                                              HasSubstr((folder_ / "gicube-board").string()))));
}

TEST_F(Launch, TheChildGetsItsArgumentsAndTheSocketAsFileThree) {
  ChildProcess child(script("echo \"$@\" >&3"), {"--set", "threads=2"});
  const Fd socket = child.take_socket();
  EXPECT_EQ(receive_all(socket), "--set threads=2 --listen fd:3 --quiet --private\n");
}

TEST_F(Launch, TheChildInheritsNoOtherFile) {
  const Fd leak(::fcntl(0, F_DUPFD, 50));  // not closed on exec, as a careless application's files
  ChildProcess child(script("ls /proc/$$/fd | tr '\\n' ' ' >&3"), {});
  const Fd socket = child.take_socket();
  const std::string files = receive_all(socket);
  EXPECT_THAT(files, HasSubstr("0 1 "));
  EXPECT_THAT(files, ::testing::Not(HasSubstr("50")));
}

TEST_F(Launch, AChildThatFailsLeavesItsExitCodeAndLastLines) {
  ChildProcess child(script("echo 'asic.processors: expected 1..16, got 99' >&2; exit 2"), {});
  ASSERT_TRUE(child.ended(std::chrono::seconds(20)));
  EXPECT_EQ(child.last_words(), "gicube-board ended with exit code 2:\nasic.processors: expected 1..16, got 99");
  EXPECT_EQ(child.usage_fault(), "asic.processors: expected 1..16, got 99");
  ChildProcess other(script("echo 'out of memory' >&2; exit 1"), {});
  ASSERT_TRUE(other.ended(std::chrono::seconds(20)));
  EXPECT_EQ(other.usage_fault(), std::nullopt);
  ChildProcess third(script("exit 42"), {});
  ASSERT_TRUE(third.ended(std::chrono::seconds(20)));
  EXPECT_EQ(third.last_words(), "gicube-board ended with exit code 42");
}

TEST_F(Launch, LongLastWordsAreCutToTheirLastLines) {
  ChildProcess child(script("i=0; while [ $i -lt 3000 ]; do echo line $i >&2; i=$((i+1)); done; exit 1"), {});
  ASSERT_TRUE(child.ended(std::chrono::seconds(20)));
  const std::string text = child.last_words();
  EXPECT_THAT(text, HasSubstr("line 2999"));
  EXPECT_LT(text.size(), 4200u);
  EXPECT_GT(text.size(), 4000u) << "four KiB, but for the line that is cut";
  EXPECT_THAT(text, StartsWith("gicube-board ended with exit code 1:\nline ")) << "whole lines";
}

TEST_F(Launch, AChildThatWasKilledSaysByWhichSignal) {
  ChildProcess child(script("kill -9 $$"), {});
  ASSERT_TRUE(child.ended(std::chrono::seconds(20)));
  EXPECT_THAT(child.last_words(), HasSubstr("by signal 9"));
}

TEST_F(Launch, ARunningChildHasNoLastWords) {
  ChildProcess child(script("read line <&3"), {});
  EXPECT_EQ(child.last_words(), "");
}

TEST_F(Launch, AProgramThatCannotRunIsAnOpenFailure) {
  EXPECT_THROW(ChildProcess((folder_ / "missing").string(), {}), OpenFailed);
}

// What the application ignores is not the board's affair, and Ctrl-C is not either.
TEST_F(Launch, TheChildHasAProcessGroupOfItsOwnAndIgnoresNoSignal) {
  const auto before = ::signal(SIGUSR2, SIG_IGN);
  ChildProcess child(script("read -r id name state parent group rest </proc/$$/stat; echo $id $group >&3\n"
                            "grep SigIgn /proc/$$/status >&3"),
                     {});
  ::signal(SIGUSR2, before);
  std::istringstream said(receive_all(child.take_socket()));
  int id = 0, group = -1;
  std::string word, ignored;
  said >> id >> group >> word >> ignored;
  EXPECT_GT(id, 0);
  EXPECT_EQ(group, id);
  EXPECT_EQ(std::stoull(ignored, nullptr, 16) & (1ULL << (SIGUSR2 - 1)), 0u);
}

// It is told by the socket that closes, then by SIGTERM.
TEST_F(Launch, AChildThatDoesNotHearTheSocketIsTerminated) {
  const fs::path told = folder_ / "told";
  std::string id;
  {
    ChildProcess child(script("trap 'touch \"$1\"; exit' TERM; echo $$ >&3; exec 3>&-; while :; do sleep 0.1; done"),
                       {told.string()});
    id = receive_all(child.take_socket());
  }
  EXPECT_EQ(::kill(std::stoi(id), 0), -1);
  EXPECT_TRUE(fs::exists(told)) << "it could end in its own way";
}

TEST(Fd, HasNothingLeftAfterItsRelease) {
  Fd owner(::dup(2));
  const int number = owner.release();
  EXPECT_GE(number, 3);
  EXPECT_EQ(owner.get(), -1);
  Fd other(number), third(std::move(other));
  EXPECT_EQ(other.get(), -1);
  EXPECT_EQ(third.get(), number);
  third.reset();
  EXPECT_EQ(third.get(), -1);
  EXPECT_EQ(::fcntl(number, F_GETFD), -1) << "closed";
}

TEST(Event, MakesItsDescriptorReadableWhichNoChildInheritsAndWhichOutlivesIt) {
  auto event = std::make_unique<Event>();
  const Fd early = event->descriptor();
  EXPECT_EQ(::fcntl(early.get(), F_GETFD), FD_CLOEXEC);
  pollfd item{early.get(), POLLIN, 0};
  EXPECT_EQ(::poll(&item, 1, 0), 0);
  event->happen();
  EXPECT_EQ(::poll(&item, 1, 0), 1);
  event = std::make_unique<Event>();
  item.fd = event->descriptor().release();
  const Fd late(item.fd);
  event.reset();
  EXPECT_EQ(::poll(&item, 1, 0), 1) << "nobody else can say it any more";
}

TEST(Event, WithoutADescriptorIsAnErrorWithItsReason) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  std::exception_ptr thrown;
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  try {
    const Event event;
  } catch (...) {
    thrown = std::current_exception();
  }
  EXPECT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  // Only now: UndefinedBehaviorSanitizer needs a descriptor to look at an object.
  ASSERT_NE(thrown, nullptr);
  EXPECT_THAT([&thrown] { std::rethrow_exception(thrown); },
              ThrowsMessage<Error>(std::string("cannot make a descriptor for an event: ") + std::strerror(EMFILE)));
}

TEST_F(Launch, TheChildIsGoneWhenItsObjectIs) {
  std::string id;
  {
    ChildProcess child(script("echo $$ >&3; read line <&3"), {});
    Fd socket = child.take_socket();
    std::array<char, 32> bytes{};
    const ssize_t got = ::recv(socket.get(), bytes.data(), bytes.size(), 0);
    ASSERT_GT(got, 0);
    id.assign(bytes.data(), static_cast<std::size_t>(got));
    socket.reset();
  }
  EXPECT_EQ(::kill(std::stoi(id), 0), -1);
  EXPECT_EQ(errno, ESRCH);
}

}  // namespace
}  // namespace gicube
