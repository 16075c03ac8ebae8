#include "landlock.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <semaphore.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "words/scope_exit.h"

namespace gicube::emu {
namespace {

constexpr std::chrono::seconds kPatience{5};         // chosen: a thousand times the response time under load
constexpr std::chrono::milliseconds kLookAgain{10};  // chosen: interval for checking whether a thread has ended

// Restricts the calling thread; -1: it only cannot gain privileges. Async-signal-safe. Returns errno or 0.
int restrict_thread(int ruleset) {
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return errno;
  return ruleset < 0 || ::syscall(SYS_landlock_restrict_self, ruleset, 0) == 0 ? 0 : errno;
}

// The request to a thread, and its result. One thread at a time.
struct Asked {
  int ruleset = -1;
  std::atomic<int> fault = 0;
  sem_t answered{};
};
Asked asked;

void answer(int) {
  const int error = errno;
  if (const int fault = restrict_thread(asked.ruleset); fault != 0) asked.fault = fault;
  ::sem_post(&asked.answered);
  errno = error;
}

[[noreturn]] void fail(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

std::vector<pid_t> threads() {
  std::vector<pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    const std::string name = entry.path().filename().string();
    pid_t thread = 0;
    std::from_chars(name.data(), name.data() + name.size(), thread);
    found.push_back(thread);
  }
  return found;
}

// Waits until the thread has answered or ended.
void ask(pid_t thread, int signal) {
  if (::tgkill(::getpid(), thread, signal) != 0) return;
  using std::chrono::steady_clock;
  for (const auto end = steady_clock::now() + kPatience; steady_clock::now() < end;) {
    const std::chrono::nanoseconds until = (steady_clock::now() + kLookAgain).time_since_epoch();
    const auto seconds = std::chrono::floor<std::chrono::seconds>(until);
    const timespec time{seconds.count(), (until - seconds).count()};
    if (::sem_clockwait(&asked.answered, CLOCK_MONOTONIC, &time) == 0) return;
    if (::tgkill(::getpid(), thread, 0) == 0) continue;
    ::sem_trywait(&asked.answered);  // it may have answered just before it ended
    return;
  }
  fail(ETIMEDOUT, "a thread does not answer");
}

// Restricts every thread of the process: other threads in a signal handler, the caller last. Not thread-safe. Throws
// std::system_error if that failed on a thread or a thread did not answer in time; the others are then restricted.
//
// A new thread inherits the settings of the thread that starts it. So when a list made after the last answer contains
// only threads that have answered, all threads are done. After a timeout, the handler stays, because the thread may
// still receive the signal.
void restrict_every_thread(int ruleset) {
  asked.ruleset = ruleset;
  asked.fault = 0;
  ::sem_init(&asked.answered, 0, 0);
  const int signal = SIGRTMIN + 5;  // chosen: not used by any library of the process
  struct sigaction action {};
  struct sigaction before {};
  action.sa_handler = answer;
  action.sa_flags = SA_RESTART;
  ::sigfillset(&action.sa_mask);
  if (::sigaction(signal, &action, &before) != 0) fail(errno, "sigaction");
  std::set<pid_t> done{::gettid()};
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (const pid_t thread : threads()) {
      if (!done.insert(thread).second) continue;
      is_new = true;
      ask(thread, signal);
    }
  }
  ::sigaction(signal, &before, nullptr);
  if (const int fault = restrict_thread(ruleset); fault != 0) asked.fault = fault;
  if (asked.fault != 0) fail(asked.fault, "on a thread");
}

// Constants of later versions than the header of Debian 12 (Documentation/userspace-api/landlock.rst of Linux 6.10).
constexpr std::uint64_t kTruncate = 1u << 14;       // version 3
constexpr std::uint64_t kIoctlOfDevice = 1u << 15;  // version 5
constexpr std::uint64_t kBindTcp = 1u << 0, kConnectTcp = 1u << 1;
constexpr int kVersionOfMoves = 2, kVersionOfTruncate = 3, kVersionOfTcp = 4, kVersionOfIoctl = 5;

struct RulesetAttributes {  // landlock_ruleset_attr of version 4; earlier versions have only the first field
  std::uint64_t files = 0;
  std::uint64_t tcp = 0;
};

// All rights of a version. They are refused unless a place allows them.
std::uint64_t known_rights(int version) {
  std::uint64_t rights = (std::uint64_t{LANDLOCK_ACCESS_FS_MAKE_SYM} << 1) - 1;  // all of version 1
  if (version >= kVersionOfMoves) rights |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= kVersionOfTruncate) rights |= kTruncate;
  if (version >= kVersionOfIoctl) rights |= kIoctlOfDevice;
  return rights;
}

std::uint64_t rights_of(Box::Access access) {
  switch (access) {
    case Box::Access::kRead: return LANDLOCK_ACCESS_FS_READ_FILE;
    case Box::Access::kRemove: return LANDLOCK_ACCESS_FS_REMOVE_FILE;
    case Box::Access::kWrite:
      return LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_FILE | kTruncate;
  }
  return 0;
}

void add(int ruleset, const Box::Path& allowed, std::uint64_t known) {
  const int fd = ::open(allowed.path.c_str(), O_PATH | O_CLOEXEC);
  if (fd < 0 && errno == ENOENT) return;
  if (fd < 0) fail(errno, allowed.path);
  const ScopeExit closed{[fd] { ::close(fd); }};
  landlock_path_beneath_attr rule{};
  rule.allowed_access = rights_of(allowed.access) & known;
  rule.parent_fd = fd;
  if (::syscall(SYS_landlock_add_rule, ruleset, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) != 0) fail(errno, allowed.path);
}

}  // namespace

int restrict_files(const std::vector<Box::Path>& paths) {
  const auto version =
      static_cast<int>(::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION));
  if (version < 1) {
    restrict_every_thread(-1);
    return 0;
  }
  const std::uint64_t known = known_rights(version);
  const RulesetAttributes attributes{known, kBindTcp | kConnectTcp};
  const std::size_t size = version >= kVersionOfTcp ? sizeof attributes : sizeof attributes.files;
  const auto ruleset = static_cast<int>(::syscall(SYS_landlock_create_ruleset, &attributes, size, 0));
  if (ruleset < 0) fail(errno, "Landlock");
  const ScopeExit closed{[ruleset] { ::close(ruleset); }};
  for (const Box::Path& allowed : paths) add(ruleset, allowed, known);
  restrict_every_thread(ruleset);
  return version;
}

}  // namespace gicube::emu
