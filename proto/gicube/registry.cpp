#include "gicube/registry.h"

#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace gicube {
namespace {

namespace fs = std::filesystem;

// Returns the process id of a socket's name, "PID" or ".PID", or 0 for other names.
pid_t process_of(std::string_view name) {
  if (name.starts_with('.')) name.remove_prefix(1);
  pid_t process = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), process);
  return error == std::errc{} && end == name.data() + name.size() && process > 0 ? process : 0;
}

// Returns the folder that an environment variable names, or an empty string if it is not a folder of this user. So root
// with another user's environment does not touch that user's folder.
std::string own_folder(const char* variable) {
  const char* const path = std::getenv(variable);
  struct stat status {};
  const bool is_mine = path != nullptr && *path == '/' && ::stat(path, &status) == 0 && S_ISDIR(status.st_mode) &&
                       status.st_uid == ::geteuid();
  return is_mine ? path : "";
}

}  // namespace

std::string registry_folder() {
  if (const std::string runtime = own_folder("XDG_RUNTIME_DIR"); !runtime.empty()) return runtime + "/gicube";
  const std::string shared = "/tmp/gicube-" + std::to_string(::geteuid());
  struct stat status {};
  const bool is_taken = ::lstat(shared.c_str(), &status) == 0 && status.st_uid != ::geteuid();
  const std::string home = is_taken ? own_folder("HOME") : "";
  std::array<char, HOST_NAME_MAX + 1> host{};
  if (home.empty() || ::gethostname(host.data(), host.size()) != 0) return shared;
  return home + "/.gicube-" + host.data();
}

std::string mode_text(unsigned mode) {
  std::string digits;
  for (const int shift : {6, 3, 0}) digits += static_cast<char>('0' + (mode >> shift & 7));
  return digits;
}

std::string registry_fault(const std::string& folder) {
  struct stat status {};
  const std::string expected =
      folder + ": expected a folder of user " + std::to_string(::geteuid()) + ", mode 700, got ";
  if (::lstat(folder.c_str(), &status) != 0) return expected + std::generic_category().message(errno);
  if (!S_ISDIR(status.st_mode)) return expected + "a file";
  if (status.st_uid != ::geteuid()) return expected + "one of user " + std::to_string(status.st_uid);
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) == 0) return {};
  return expected + "mode " + mode_text(status.st_mode);
}

std::string open_registry() {
  const std::string folder = registry_folder();
  ::mkdir(folder.c_str(), S_IRWXU);  // registry_fault() reports an error
  if (const std::string fault = registry_fault(folder); !fault.empty()) throw std::runtime_error(fault);
  return folder;
}

bool listens(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return true;
  path.copy(address.sun_path, path.size());
  const int caller = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (caller < 0) return true;
  const bool refused = ::connect(caller, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 &&
                       errno == ECONNREFUSED;  // EAGAIN: its backlog is full
  ::close(caller);
  return !refused;
}

void remove_dead_sockets(const std::string& folder) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const pid_t process = process_of(entry.path().filename().string());
    // A running process may be about to listen. A process that is not visible here, in another container, counts as
    // running if it listens.
    const bool is_gone = process > 0 && ::kill(process, 0) != 0 && errno == ESRCH;
    if (is_gone && entry.is_socket(ignored) && !listens(entry.path())) fs::remove(entry.path(), ignored);
  }
}

}  // namespace gicube
