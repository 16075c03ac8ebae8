// gicube-pci: a board as a PCI function of a guest. It serves QEMU's x-pci-proxy-dev, and is a client of the board.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>

#include "bridge.h"
#include "gicube/error.h"
#include "gicube/unknown_options.h"
#include "transport/connect.h"
#include "transport/launch.h"
#include "transport/uri.h"

namespace gicube::pci {
namespace {

constexpr std::chrono::seconds kConnectPatience{
    5};  // chosen: the guest's processor waits, and its kernel for 20 s at most

Connection connect_board(const Uri& uri) {
  if (uri.scheme != UriScheme::kEmu) return {connect(uri, kConnectPatience), {}};
  const auto child = std::make_shared<ChildProcess>(find_board_program(), uri.board_arguments);
  return {child->take_socket(), child};
}

// Starts the command with `theirs` as file `number`.
pid_t start(char** command, const Fd& theirs, int number) {
  const pid_t process = ::fork();
  if (process != 0) return process;
  ::dup2(theirs.get(), number);
  ::fcntl(number, F_SETFD, 0);
  ::execvp(command[0], command);
  fmt::print(stderr, "gicube-pci: cannot start {}: {}\n", command[0], std::strerror(errno));
  ::_exit(127);
}

int run(const std::string& board, int number, char** command) {
  const Uri uri = parse_uri(board);
  if (uri.is_secure || uri.scheme == UriScheme::kPci) {
    throw BadArgument("URI", "emu:, unix:PATH or tcp:HOST:PORT", "\"" + board + "\"");
  }
  pid_t process = -1;
  Fd qemu(*command == nullptr ? number : -1);
  if (*command != nullptr) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) throw std::runtime_error("no sockets");
    qemu = Fd(ends[0]);
    process = start(command, Fd(ends[1]), number);
  }
  int code = 0, status = 0;
  try {
    Bridge([uri] { return connect_board(uri); }).serve(qemu.get());
  } catch (const std::exception& error) {
    fmt::print(stderr, "gicube-pci: {}\n", error.what());
    code = 1;
  }
  qemu.reset();
  if (process >= 0) ::waitpid(process, &status, 0);
  if (code != 0) return code;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace
}  // namespace gicube::pci

int main(int argc, char** argv) {
  using namespace gicube;
  std::string board = "emu:";
  int number = 3;
  CLI::App app(
      "Gives a guest of QEMU a board as a PCI function. QEMU needs the device x-pci-proxy-dev,fd=N, memory that it "
      "shares\n"
      "(memory-backend-memfd,share=on), and one processor. gicube-pci URI -- COMMAND starts COMMAND, QEMU or another\n"
      "gicube-pci, with file N as the socket of the function, and ends with its exit code.",
      "gicube-pci");
  app.set_version_flag("--version", "gicube-pci " GICUBE_VERSION);
  app.add_option("uri", board, "the board: emu:, unix:PATH or tcp:HOST:PORT")->type_name("URI")->capture_default_str();
  app.add_option("--fd", number,
                 "the number of the socket to QEMU: of a file of the command or, without one, of this process")
      ->type_name("N")
      ->check(CLI::Range(3, 1023))
      ->capture_default_str();
  char** const dashes = std::find_if(argv, argv + argc, [](const char* word) { return std::strcmp(word, "--") == 0; });
  try {
    app.parse(static_cast<int>(dashes - argv), argv);
    return pci::run(board, number, std::min(dashes + 1, argv + argc));
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "gicube-pci: {}\n", usage_fault(app, error.what()));
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "gicube-pci: {}\n", error.what());
    return dynamic_cast<const BadArgument*>(&error) != nullptr ? 2 : 1;
  }
}
