#include "board_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <utility>

extern char** environ;

namespace gicube::system_test {
namespace {

std::array<int, 2> make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  return ends;
}

std::string read_all(int fd) {
  std::string text;
  std::array<char, 4096> bytes{};
  for (ssize_t size = 0; (size = ::read(fd, bytes.data(), bytes.size())) > 0;) {
    text.append(bytes.data(), static_cast<std::size_t>(size));
  }
  return text;
}

}  // namespace

BoardProcess::BoardProcess(const std::vector<std::string>& arguments, int inherited_fd, const std::string& program) {
  std::vector<std::string> texts{program};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  const std::array<int, 2> output = make_pipe(), errors = make_pipe();
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, errors[1], STDERR_FILENO);
  // A duplicate onto itself clears close-on-exec.
  if (inherited_fd >= 0) ::posix_spawn_file_actions_adddup2(&actions, inherited_fd, inherited_fd);
  const int error = ::posix_spawn(&pid_, program.c_str(), &actions, nullptr, pointers.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(output[1]);
  ::close(errors[1]);
  output_ = output[0];
  errors_ = errors[0];
  if (error != 0) throw std::runtime_error(program + ": " + std::strerror(error));
}

BoardProcess::~BoardProcess() {
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  stop_reading();
}

void BoardProcess::stop_reading() {
  for (int* const end : {&output_, &errors_}) {
    if (*end >= 0) ::close(std::exchange(*end, -1));
  }
}

std::string BoardProcess::read_line() {
  std::string line;
  char c = 0;
  while (::read(output_, &c, 1) == 1 && c != '\n') line += c;
  return line;
}

std::string BoardProcess::read_output() { return read_all(output_); }

std::string BoardProcess::read_errors() { return read_all(errors_); }

void BoardProcess::send_signal(int signal) const { ::kill(pid_, signal); }

void BoardProcess::limit_memory(std::uint64_t bytes) const {
  const rlimit limit{bytes, bytes};
  if (::prlimit(pid_, RLIMIT_AS, &limit, nullptr) != 0) throw std::runtime_error("prlimit");
}

std::uint64_t BoardProcess::peak_memory() const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  for (std::string word; status >> word;) {
    std::uint64_t kib = 0;
    if (word == "VmHWM:" && status >> kib) return kib << 10;
  }
  throw std::runtime_error("/proc/PID/status: expected VmHWM");
}

bool BoardProcess::reap(int options) {
  if (pid_ > 0 && ::waitpid(pid_, &status_, options) == pid_) pid_ = -1;
  return pid_ < 0;
}

int BoardProcess::exit_code() {
  reap(0);
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
}

bool BoardProcess::has_ended() { return reap(WNOHANG); }

}  // namespace gicube::system_test
