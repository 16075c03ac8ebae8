#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <pwd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>

#include "diagnosis.h"

namespace gicube::smi {
namespace {

namespace fs = std::filesystem;

constexpr int kConnectPatienceMs = 3000;  // chosen

std::string user_name(uid_t user) {
  const passwd* entry = ::getpwuid(user);
  return entry != nullptr ? entry->pw_name : std::to_string(user);
}

class Socket {
 public:
  Socket(int family, int type) : fd_(::socket(family, type | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  // 0, or the errno.
  int connect(const sockaddr* address, socklen_t size) const {
    if (fd_ < 0 || (::connect(fd_, address, size) != 0 && errno != EINPROGRESS)) return errno;
    pollfd ready{fd_, POLLOUT, 0};
    if (::poll(&ready, 1, kConnectPatienceMs) != 1) return ETIMEDOUT;
    int error = 0;
    socklen_t bytes = sizeof error;
    ::getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &bytes);
    return error;
  }

 private:
  int fd_;
};

// What the program says to --version; empty if it can't be run.
std::string version_of(const fs::path& program) {
  std::string quoted = "'";
  for (const char c : program.string()) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen((quoted + "' --version 2>&1").c_str(), "r"),
                                                             &::pclose);
  std::array<char, 200> line{};
  if (!pipe || std::fgets(line.data(), line.size(), pipe.get()) == nullptr) return {};
  std::string text(line.data());
  text.erase(text.find_last_not_of('\n') + 1);
  return text;
}

// Where the driver looks, in its order (gicube/board.h).
std::vector<fs::path> program_places() {
  std::vector<fs::path> places;
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (!error) places.push_back(self.parent_path() / "gicube-board");
  const char* path = std::getenv("PATH");
  for (std::string rest = path != nullptr ? path : ""; !rest.empty();) {
    const std::string folder = rest.substr(0, rest.find(':'));
    rest.erase(0, std::min(folder.size() + 1, rest.size()));
    if (!folder.empty()) places.push_back(fs::path(folder) / "gicube-board");
  }
  return places;
}

}  // namespace

bool look_for_program(Diagnosis& diagnosis) {
  const std::string question = "is gicube-board there?";
  const char* named = std::getenv("GICUBE_BOARD");
  std::vector<fs::path> places = program_places();
  if (named != nullptr && *named != '\0') places = {named};
  for (const fs::path& place : places) {
    std::error_code error;
    if (!fs::exists(place, error)) continue;
    if (!fs::is_regular_file(place, error) || ::access(place.c_str(), X_OK) != 0) {
      diagnosis.bad(question, fmt::format("{} is no program that {} may run", place.string(), user_name(::geteuid())),
                    fmt::format("chmod +x {}", place.string()));
      return false;
    }
    const std::string version = version_of(place);
    if (version.find("gicube-board") == std::string::npos) {
      diagnosis.bad(question,
                    fmt::format("{} does not run: {}", place.string(), version.empty() ? "no answer" : version),
                    "build or install it again");
      return false;
    }
    diagnosis.good(question, fmt::format("{} ({})", place.string(), version));
    return true;
  }
  if (named != nullptr && *named != '\0') {
    diagnosis.bad(question, fmt::format("GICUBE_BOARD names {}, which is not there", named),
                  "set GICUBE_BOARD to the program, or unset it");
    return false;
  }
  // The driver also looks where the SDK was installed: it has the last word.
  diagnosis.note(question, "not beside this program, not on the PATH; perhaps where the SDK was installed");
  return true;
}

bool look_at_socket(const std::string& path, Diagnosis& diagnosis) {
  const std::string start = "start a board: gicube-board --listen unix:" + path;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    diagnosis.bad("can the path be a socket's?",
                  fmt::format("it has {} bytes, {} are possible", path.size(), sizeof address.sun_path - 1),
                  "use a shorter path");
    return false;
  }
  path.copy(address.sun_path, path.size());
  struct stat info {};
  const std::string question = "is there a socket?";
  if (::stat(path.c_str(), &info) != 0) {
    const int error = errno;
    if (error == EACCES) {
      diagnosis.bad(question, fmt::format("a folder of {} is closed to {}", path, user_name(::geteuid())),
                    "ask its owner for the right to search it");
    } else {
      diagnosis.bad(question, fmt::format("{}: {}", path, std::strerror(error)), start);
    }
    return false;
  }
  if (!S_ISSOCK(info.st_mode)) {
    diagnosis.bad(question, fmt::format("{} is something else", path), "name the path that gicube-board listens on");
    return false;
  }
  diagnosis.good(question, fmt::format("{}, of {}, mode {:o}", path, user_name(info.st_uid), info.st_mode & 0777));
  const int error = Socket(AF_UNIX, SOCK_STREAM).connect(reinterpret_cast<const sockaddr*>(&address), sizeof address);
  if (error == 0) {
    diagnosis.good("does somebody listen?", "yes");
    return true;
  }
  if (error == EACCES) {
    diagnosis.bad("may it be opened?", fmt::format("not by {}", user_name(::geteuid())),
                  fmt::format("run as {}, or have the socket's mode changed: a board lets nobody but its owner in",
                              user_name(info.st_uid)));
  } else if (error == ECONNREFUSED) {
    diagnosis.bad("does somebody listen?", "nobody: the socket is left from a board that has ended", start);
  } else {
    diagnosis.bad("does somebody listen?", std::strerror(error), start);
  }
  return false;
}

bool look_at_port(const std::string& host_port, Diagnosis& diagnosis) {
  const std::size_t colon = host_port.rfind(':');
  std::string host = host_port.substr(0, colon);
  const std::string port = colon == std::string::npos ? "" : host_port.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int fault = ::getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, [](addrinfo* list) {
    if (list != nullptr) ::freeaddrinfo(list);
  });
  if (fault != 0) {
    diagnosis.bad("is the host known?", fmt::format("{}: {}", host, ::gai_strerror(fault)), "check its name");
    return false;
  }
  diagnosis.good("is the host known?", host);
  int error = 0;
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    error = Socket(each->ai_family, each->ai_socktype | SOCK_NONBLOCK).connect(each->ai_addr, each->ai_addrlen);
    if (error == 0) {
      diagnosis.good("does somebody listen?", "yes, on port " + port);
      return true;
    }
  }
  diagnosis.bad("does somebody listen?", fmt::format("port {}: {}", port, std::strerror(error)),
                error == ECONNREFUSED ? "start a board there: gicube-board --listen tcp:" + host_port
                                      : "is the host up, and does a firewall let the port through?");
  return false;
}

}  // namespace gicube::smi
