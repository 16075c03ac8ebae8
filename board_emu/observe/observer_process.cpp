#include "observe/observer_process.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace gicube::emu {

namespace {

constexpr const char* kObserverHost = "../libexec/gicube/gicube-observer-host";  // as seen from the board's program
constexpr int kPatienceMs = 30'000;  // chosen: a loaded machine runs its code by then

// False if the other side is gone or does not take it in time.
bool send_all(int socket, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t sent = ::send(socket, bytes, count, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) {
      bytes += sent;
      count -= static_cast<std::size_t>(sent);
      continue;
    }
    pollfd ready{socket, POLLOUT, 0};
    if ((errno != EAGAIN && errno != EINTR) || ::poll(&ready, 1, kPatienceMs) <= 0) return false;
  }
  return true;
}

// A line, without its end; nothing comes: what there is.
std::string line_from(int socket) {
  std::string out;
  for (char each = 0;;) {
    pollfd ready{socket, POLLIN, 0};
    if (::poll(&ready, 1, kPatienceMs) <= 0 || ::recv(socket, &each, 1, 0) != 1)
      return out.empty() ? "it has ended" : out;
    if (each == '\n') return out;
    out += each;
  }
}

}  // namespace

ObserverProcess::ObserverProcess(const std::string& file, bool is_boxed) : file_(file) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw std::runtime_error(fmt::format("{}: no socket for it: {}", file, std::strerror(errno)));
  }
  socket_ = ends[0];
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  ::posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  // A name without a slash would be looked for in the system's library folders.
  std::string name = "gicube-observer-host", object = std::filesystem::absolute(file).string(),
              box = is_boxed ? "boxed" : "unboxed";
  char* const arguments[]{name.data(), object.data(), box.data(), nullptr};
  const std::string program = (std::filesystem::read_symlink("/proc/self/exe").parent_path() / kObserverHost).string();
  const int error = ::posix_spawn(&process_, program.c_str(), &actions, nullptr, arguments, environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  const std::string said = error != 0 ? program + ": " + std::strerror(error) : line_from(socket_);
  if (said.empty()) return;
  if (error == 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  ::close(socket_);
  throw std::runtime_error(said.starts_with(object) ? said : fmt::format("{}: {}", file, said));
}

// In its box the board's process may not end others, and the closed socket does it.
ObserverProcess::~ObserverProcess() {
  flush();
  ::shutdown(socket_, SHUT_WR);
  pollfd gone{socket_, POLLIN, 0};
  if (fault_.empty() && ::poll(&gone, 1, kPatienceMs) > 0) ::waitpid(process_, nullptr, 0);
  ::close(socket_);
}

void ObserverProcess::flush() {
  if (fault_.empty() &&
      !send_all(socket_, reinterpret_cast<const char*>(events_.data()), events_.size() * sizeof(gicube_event))) {
    fault_ = fmt::format("observer {}: it has ended, or took no events for {} s; it gets no more", file_,
                         kPatienceMs / 1000);
  }
  events_.clear();
}

}  // namespace gicube::emu
