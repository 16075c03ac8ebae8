#include "launch.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <ranges>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "gicube/error.h"

extern char** environ;

namespace gicube {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = "gicube-board";
constexpr std::chrono::seconds kGrace{5};  // chosen: the time a child has to end by itself, and again after SIGTERM
constexpr std::size_t kStderrTail = 4096;  // bytes, chosen: enough for an error message
constexpr int kLowestOwnFd = 10;           // above the numbers of the child's files, 0..3

bool is_program(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) && ::access(path.c_str(), X_OK) == 0;
}

OpenFailed spawn_error(const std::string& what, int error) {
  return OpenFailed("cannot start " + what + ": " + std::generic_category().message(error));
}

// Duplicates the file to a number that the child's own files do not use.
Fd raised(Fd fd) {
  Fd copy(::fcntl(fd.get(), F_DUPFD_CLOEXEC, kLowestOwnFd));
  if (copy.get() < 0) throw spawn_error(kProgram, errno);
  return copy;
}

// The folder of programs of the installation that this library belongs to, which may have been moved since it was
// built.
std::optional<fs::path> programs_of_this_library() {
  Dl_info info{};
  if (::dladdr(reinterpret_cast<const void*>(&find_board_program), &info) == 0 || info.dli_fname == nullptr) return {};
  std::error_code error;
  const fs::path library = fs::canonical(info.dli_fname, error);
  if (error) return {};
  // A library that is linked into a program has no folder of its own.
  if (library == fs::canonical("/proc/self/exe", error) || error) return {};
  return (library.parent_path() / GICUBE_LIBRARIES_TO_PROGRAMS).lexically_normal();
}

}  // namespace

const char* named_board_program() {
  const char* named = std::getenv("GICUBE_BOARD");
  return named != nullptr && *named != '\0' ? named : nullptr;
}

std::vector<fs::path> board_program_places() {
  if (const char* named = named_board_program()) return {named};
  std::vector<fs::path> places;
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (!error) places.push_back(self.parent_path() / kProgram);
  if (const auto programs = programs_of_this_library()) places.push_back(*programs / kProgram);
  places.push_back(fs::path(GICUBE_INSTALL_BINDIR) / kProgram);
  if (const char* path = std::getenv("PATH")) {
    for (const auto folder : std::string_view(path) | std::views::split(':')) {
      if (!folder.empty()) places.push_back(fs::path(folder.begin(), folder.end()) / kProgram);
    }
  }
  return places;
}

std::string find_board_program() {
  const std::vector<fs::path> places = board_program_places();
  std::string looked;
  for (const fs::path& place : places) {
    if (is_program(place)) return place.string();
    looked += "\n  " + place.string();
  }
  if (const char* named = named_board_program()) {
    throw OpenFailed(std::string("the environment variable GICUBE_BOARD: expected a program, got ") + named);
  }
  throw OpenFailed("gicube-board was not found; the environment variable GICUBE_BOARD is not set, and it is not at" +
                   looked);
}

ChildProcess::ChildProcess(const std::string& program, const std::vector<std::string>& arguments, Fd listener)
    : listens_(listener.get() >= 0) {
  if (!listens_) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) throw spawn_error(program, errno);
    socket_ = Fd(ends[0]);
    listener = Fd(ends[1]);
  }
  const Fd child_end = raised(std::move(listener));
  Fd memory(::memfd_create("gicube-board stderr", MFD_CLOEXEC));
  if (memory.get() < 0) throw spawn_error(program, errno);
  stderr_ = raised(std::move(memory));

  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.insert(words.end(), {"--listen", "fd:3", "--quiet"});
  if (!listens_) words.emplace_back("--private");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&files, stderr_.get(), 2);
  posix_spawn_file_actions_adddup2(&files, child_end.get(), 3);
  posix_spawn_file_actions_addclosefrom_np(&files, 4);
  // In its own process group, since the application handles Ctrl-C. Signals that the application ignores or blocks have
  // their defaults in the board.
  sigset_t all, none;
  sigfillset(&all);
  sigemptyset(&none);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  const int error = ::posix_spawn(&pid_, program.c_str(), &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    pid_ = -1;
    throw spawn_error(program, error);
  }
}

ChildProcess::~ChildProcess() {
  socket_.reset();
  if (!listens_ && ended(kGrace)) return;
  ::kill(pid_, SIGTERM);
  if (ended(kGrace)) return;
  ::kill(pid_, SIGKILL);
  ended(kGrace);
}

bool ChildProcess::ended(std::chrono::milliseconds wait) {
  const auto deadline = std::chrono::steady_clock::now() + wait;
  auto pause = std::chrono::microseconds(200);
  while (!reaped_ && pid_ > 0) {
    const pid_t found = ::waitpid(pid_, &status_, WNOHANG);
    // ECHILD: the application ignores SIGCHLD, so the system has reaped the child.
    if (found == pid_ || (found < 0 && errno != EINTR)) {
      reaped_ = true;
      break;
    }
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, std::chrono::microseconds(10'000));
  }
  return true;
}

std::string ChildProcess::last_words() {
  if (!ended(std::chrono::milliseconds(0))) return {};
  std::string text = "gicube-board ended";
  if (WIFSIGNALED(status_)) {
    text += " by signal " + std::to_string(WTERMSIG(status_)) + " (" + ::sigdescr_np(WTERMSIG(status_)) + ")";
  } else {
    text += " with exit code " + std::to_string(WEXITSTATUS(status_));
  }
  const std::string lines = last_lines();
  return lines.empty() ? text : text + ":\n" + lines;
}

std::optional<std::string> ChildProcess::usage_fault() {
  constexpr int kUsage = 2;  // gicube-board's exit code
  const bool is_usage = ended(std::chrono::milliseconds(0)) && WIFEXITED(status_) && WEXITSTATUS(status_) == kUsage;
  return is_usage ? std::optional(last_lines()) : std::nullopt;
}

std::string ChildProcess::last_lines() const {
  struct stat info {};
  if (::fstat(stderr_.get(), &info) != 0 || info.st_size <= 0) return {};
  const auto size = static_cast<std::size_t>(info.st_size);
  std::string tail(std::min(size, kStderrTail), '\0');
  const ssize_t got = ::pread(stderr_.get(), tail.data(), tail.size(), static_cast<off_t>(size - tail.size()));
  tail.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  if (size > kStderrTail) tail.erase(0, tail.find('\n') + 1);
  while (tail.ends_with('\n')) tail.pop_back();
  return tail;
}

}  // namespace gicube
