#include "observe/observer_process.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "read_trace.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

const std::string kObserver = GICUBE_TEST_OBSERVER;

// Sends so many events to the observer of tests; returns what the board would say of it.
std::string send(unsigned count, const std::string& file, const char* behaviour) {
  ::setenv("GICUBE_TEST_OBSERVED", file.c_str(), 1);
  ::setenv("GICUBE_TEST_OBSERVER", behaviour, 1);
  ObserverProcess process(kObserver, true);
  for (unsigned i = 0; i < count; ++i) {
    gicube_event event{};
    event.size = sizeof event;
    event.ray = i;
    process.add(event);
  }
  process.flush();
  return process.fault();
}

TEST(ObserverProcess, HasAllEventsInTheirOrderAndMayWriteToFilesThatItOpenedBefore) {
  const reference::TemporaryDirectory folder;
  EXPECT_EQ(send(10'001, folder.file("seen"), "counts"), "");
  // "boxed" or "free": where the kernel has no Landlock, or a build has sanitizers, there is no box.
  EXPECT_THAT(read_text(folder.file("seen")), StartsWith("10001 50005000 in order "));
}

TEST(ObserverProcess, ThatEndsByItselfGetsNoMoreAndHoldsNothingUp) {
  const reference::TemporaryDirectory folder;
  EXPECT_THAT(send(100'000, folder.file("seen"), "leaves"), HasSubstr("it has ended, or took no events for 30 s"));
}

// A board in a process of its own, which is killed; its observer is then this process's.
TEST(ObserverProcess, ThatNeverReturnsEndsSoonAfterItsBoard) {
  const reference::TemporaryDirectory folder;
  while (::waitpid(-1, nullptr, WNOHANG) > 0) continue;  // those of other tests
  ::prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0);
  const pid_t board = ::fork();
  if (board == 0) {
    ::setenv("GICUBE_TEST_OBSERVED", folder.file("seen").c_str(), 1);
    ::setenv("GICUBE_TEST_OBSERVER", "loops", 1);
    ObserverProcess process(kObserver, true);
    process.add({});
    process.flush();
    ::kill(::getpid(), SIGKILL);
  }
  ASSERT_EQ(::waitpid(board, nullptr, 0), board);
  const auto begin = std::chrono::steady_clock::now();
  pid_t observer = 0;
  while (observer == 0 && std::chrono::steady_clock::now() < begin + std::chrono::seconds(10)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    observer = ::waitpid(-1, nullptr, WNOHANG);
  }
  EXPECT_GT(observer, 0) << "it runs on without a board";
}

TEST(ObserverProcess, SaysWhatIsWrongWithAnObject) {
  const auto fault = [](const std::string& file) {
    try {
      ObserverProcess process(file, true);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(fault("/no/such/observer.so"), HasSubstr("/no/such/observer.so: cannot open shared object file"));
  EXPECT_THAT(fault(GICUBE_TEST_NO_OBSERVER), HasSubstr(": expected a function gicube_observer_describe, got none"));
}

}  // namespace
}  // namespace gicube::emu
