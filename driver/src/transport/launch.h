// Starts a private gicube-board as a child process and ends it again.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "fd.h"

namespace gicube {

// The value of the environment variable GICUBE_BOARD, or null.
const char* named_board_program();
// Where gicube-board may be: the place that GICUBE_BOARD names or, without it, beside the running program, where the
// SDK was installed, and on the PATH.
std::vector<std::filesystem::path> board_program_places();
// The first of them that can be run. Throws OpenFailed that names every place looked at.
std::string find_board_program();

// A child process that serves one socket, inherits no other file of this process, and lives as long as this object.
// Destroy what uses the socket first: the child then ends by itself. One that does not is terminated after some
// seconds.
class ChildProcess {
 public:
  // Runs `program arguments... --listen fd:3 --private --quiet`, where file 3 is its end of a socket pair. Throws
  // OpenFailed. If a listening socket is given, the child serves that one to any number of clients, and is terminated
  // with this object.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments, Fd listener = {});
  ~ChildProcess();

  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // This process' end of the socket pair. Can be taken once.
  Fd take_socket() { return std::move(socket_); }

  // True if the child has ended, after waiting for it at most so long.
  bool ended(std::chrono::milliseconds wait);

  // Its output if it ended because it rejected its arguments: exit code 2.
  std::optional<std::string> usage_fault();

  // How it ended and the last lines that it wrote to its standard error, or an empty text while it runs.
  std::string last_words();

 private:
  std::string last_lines() const;

  Fd socket_;
  Fd stderr_;  // a file in memory: nobody has to read it for the child to continue
  pid_t pid_ = -1;
  bool listens_ = false;
  bool reaped_ = false;
  int status_ = 0;
};

}  // namespace gicube
