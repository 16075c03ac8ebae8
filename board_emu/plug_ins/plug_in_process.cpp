#include "plug_ins/plug_in_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

#include "words/scope_exit.h"

namespace gicube::emu {

namespace {

// Path relative to the folder of the program, so that an installed tree can be moved.
constexpr const char* kProgram = "../libexec/gicube/gicube-plug-in-host";

[[noreturn]] void fail(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

// Moves a descriptor above those that the new process inherits, so that copying one does not overwrite another.
int high(int fd) {
  const int copy = ::fcntl(fd, F_DUPFD_CLOEXEC, kMemoryDescriptor + 1);
  const int error = errno;
  ::close(fd);
  if (copy < 0) fail(error, "a descriptor");
  return copy;
}

// Only the variables that configure the dynamic linker and sanitizers, because others may hold secrets.
std::vector<char*> environment_of_routine() {
  std::vector<char*> out;
  for (char** each = environ; *each != nullptr; ++each) {
    const std::string name(*each, ::strcspn(*each, "="));
    if (name == "LD_LIBRARY_PATH" || name.ends_with("SAN_OPTIONS")) out.push_back(*each);
  }
  out.push_back(nullptr);
  return out;
}

// The process starts with default signal handling, and in its own process group, because a terminal's signals are for
// the board. An observer gets the board's environment and standard error.
pid_t start(bool is_observer, const std::string& file, bool is_boxed, int socket, int memory) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawnattr_init(&attributes);
  const ScopeExit freed{[&] {
    ::posix_spawn_file_actions_destroy(&actions);
    ::posix_spawnattr_destroy(&attributes);
  }};
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDWR, 0);
  if (!is_observer) ::posix_spawn_file_actions_adddup2(&actions, STDIN_FILENO, STDERR_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, socket, kSocketDescriptor);
  ::posix_spawn_file_actions_adddup2(&actions, memory, kMemoryDescriptor);
  ::posix_spawn_file_actions_addclosefrom_np(&actions, kMemoryDescriptor + 1);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setsigdefault(&attributes, &all);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  const std::string program = (std::filesystem::read_symlink("/proc/self/exe").parent_path() / kProgram).string();
  // dlopen() would search a name without a slash in the system's library folders.
  std::string name = "gicube-plug-in-host", argument = std::filesystem::absolute(file).string();
  std::string kind = is_observer ? kObserverWord : kRoutineWord, box = is_boxed ? kBoxedWord : kUnboxedWord;
  char* const arguments[]{name.data(), argument.data(), kind.data(), box.data(), nullptr};
  pid_t process = 0;
  const int error = ::posix_spawn(&process, program.c_str(), &actions, &attributes, arguments,
                                  is_observer ? environ : environment_of_routine().data());
  if (error != 0) fail(error, program);
  return process;
}

// Processor time of all threads of a process; 0 after its end.
std::chrono::nanoseconds cpu_time(pid_t process) {
  clockid_t clock{};
  timespec used{};
  if (process <= 0 || ::clock_getcpuclockid(process, &clock) != 0 || ::clock_gettime(clock, &used) != 0) return {};
  return std::chrono::seconds(used.tv_sec) + std::chrono::nanoseconds(used.tv_nsec);
}

}  // namespace

std::string end_of(int status) {
  if (status == CallSlot::kNoProcess) return "no process could be started for its call";
  if (WIFSIGNALED(status)) {
    const char* const name = ::sigdescr_np(WTERMSIG(status));
    return "its process was ended by signal " + std::to_string(WTERMSIG(status)) +
           (name != nullptr ? " (" + std::string(name) + ')' : std::string());
  }
  return "it ended its process, with exit code " + std::to_string(WEXITSTATUS(status));
}

std::string stuck() { return "did not return within " + std::to_string(kCpuLimit.count()) + " ms of processor time"; }

std::string printable(const char* text, std::size_t max_length) {
  std::string out(text, ::strnlen(text, max_length));
  std::replace_if(
      out.begin(), out.end(), [](char c) { return c < 0x20 || c > 0x7E; }, '?');
  return out;
}

PlugInProcess::PlugInProcess(Kind kind, const std::string& file, bool is_boxed)
    : patience_(kind == Kind::kObserver ? kPatience : kRoutinePatience) {
  try {
    load(kind, file, is_boxed);
  } catch (const std::system_error& error) {
    stop();
    throw PlugInFault(file + ": its process could not be started: " + error.what());
  } catch (...) {
    stop();
    throw;
  }
}

PlugInProcess::~PlugInProcess() { stop(); }

void PlugInProcess::load(Kind kind, const std::string& file, bool is_boxed) {
  const bool is_observer = kind == Kind::kObserver;
  // The size is sealed. Otherwise the plug-in could shrink the memory, and reading it would end this process.
  const int memory = high(::memfd_create("gicube-plug-in", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  const ScopeExit closed{[memory] { ::close(memory); }};
  if (::ftruncate(memory, sizeof(CallMemory)) != 0 ||
      ::fcntl(memory, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    fail(errno, "memory");
  }
  void* const mapped = ::mmap(nullptr, sizeof(CallMemory), PROT_READ | PROT_WRITE, MAP_SHARED, memory, 0);
  if (mapped == MAP_FAILED) fail(errno, "memory");
  memory_ = static_cast<CallMemory*>(mapped);

  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) fail(errno, "socket");
  socket_ = ends[0];
  Loading& loading = memory_->loading;
  loading.turn.give(Party::kPlugIn);
  {
    const int its = high(ends[1]);
    const ScopeExit its_closed{[its] { ::close(its); }};  // so that this end detects the end of the process
    process_ = start(is_observer, file, is_boxed, its, memory);
  }
  const std::int32_t limited = is_observer ? 0 : process_;  // an observer may compute as long as the board waits
  Patience patience;
  const Waited waited = wait(loading.turn, limited, 0, patience);
  if (waited == Waited::kStuck) {
    throw PlugInFault(file + (is_observer ? ": its loading or gicube_observer_describe() did not return in time"
                                          : ": its loading or gicube_bsdf_describe() " + stuck()));
  }
  if (waited != Waited::kAnswered) {
    int status = CallSlot::kNoProcess;
    ::kill(process_, SIGKILL);  // if it has not ended yet
    ::waitpid(process_, &status, 0);
    process_ = 0;
    throw PlugInFault(file + ": loading it: " + end_of(status));
  }
  const std::string fault = printable(loading.fault, kMaxText);
  if (!fault.empty()) throw PlugInFault(fault);
}

// In the box, the board process may neither kill nor wait for others. Then the closed socket ends the process.
void PlugInProcess::stop() {
  if (process_ != 0) {
    ::shutdown(socket_, SHUT_WR);
    pollfd gone{socket_, 0, 0};
    int has_ended = -1;
    if (memory_->loading.turn.now() == Party::kBoard) {
      while ((has_ended = ::poll(&gone, 1, static_cast<int>(patience_.count()))) < 0 && errno == EINTR) continue;
    }
    if (has_ended <= 0) ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  if (socket_ >= 0) ::close(socket_);
  if (memory_ != nullptr) ::munmap(memory_, sizeof(CallMemory));
}

bool PlugInProcess::has_gone() const {
  pollfd events{socket_, 0, 0};
  return ::poll(&events, 1, 0) > 0 && (events.revents & (POLLHUP | POLLERR)) != 0;
}

bool PlugInProcess::send(const void* message, std::size_t bytes, std::chrono::milliseconds patience) const {
  while (::send(socket_, message, bytes, MSG_NOSIGNAL | MSG_DONTWAIT) < 0) {
    pollfd ready{socket_, POLLOUT, 0};
    if ((errno != EAGAIN && errno != EINTR) || ::poll(&ready, 1, static_cast<int>(patience.count())) <= 0) return false;
  }
  return true;
}

PlugInProcess::Waited PlugInProcess::wait(Turn& turn, const std::int32_t& process, unsigned max_spins,
                                          Patience& patience, std::uint32_t steps) const {
  using std::chrono::steady_clock;
  std::optional<std::chrono::nanoseconds> used;  // processor time at the first tick
  int ticks = 0;
  std::uint32_t at_step = 0;
  for (auto tick = steady_clock::now() + kTick; !turn.wait_for(Party::kPlugIn, max_spins, patience, kTick);) {
    if (has_gone() && turn.now() == Party::kPlugIn) return Waited::kLost;
    if (steady_clock::now() < tick) continue;  // spurious wakeup
    tick += kTick;
    const auto now = cpu_time(process);
    if (!used || (steps > 0 && turn.steps() != at_step)) {
      used = now;
      ticks = 0;
      at_step = turn.steps();
      --steps;
    }
    if (++ticks > kTicksLimit || now - *used >= kCpuLimit) return Waited::kStuck;
  }
  return turn.now() == Party::kBoard ? Waited::kAnswered : Waited::kEnded;
}

}  // namespace gicube::emu
