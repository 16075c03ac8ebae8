#include "every_thread.h"

#include <semaphore.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <set>
#include <string>
#include <system_error>
#include <vector>

namespace gicube::emu {
namespace {

constexpr std::chrono::seconds kPatience{5};         // chosen: a thousand times the response time under load
constexpr std::chrono::milliseconds kLookAgain{10};  // chosen: interval for checking whether a thread has ended

// The call for one thread, and its result. One thread at a time.
struct Asked {
  int (*call)(int) = nullptr;
  int argument = 0;
  std::atomic<int> fault = 0;
  sem_t answered{};
};
Asked asked;

void answer(int) {
  const int error = errno;
  if (const int fault = asked.call(asked.argument); fault != 0) asked.fault = fault;
  ::sem_post(&asked.answered);
  errno = error;
}

[[noreturn]] void fail(int error, const char* what) { throw std::system_error(error, std::generic_category(), what); }

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

}  // namespace

// A new thread inherits the settings of the thread that starts it. So when a list made after the last answer contains
// only threads that have answered, all threads are done. After a timeout, the handler stays, because the thread may
// still receive the signal.
void on_every_thread(int (*call)(int), int argument) {
  asked.call = call;
  asked.argument = argument;
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
  if (const int fault = call(argument); fault != 0) asked.fault = fault;
  if (asked.fault != 0) fail(asked.fault, "on a thread");
}

}  // namespace gicube::emu
