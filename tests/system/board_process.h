// The real gicube-board, or another program, as a child process.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace gicube::system_test {

class BoardProcess {
 public:
  // Starts gicube-board, or `program`, with these arguments; `inherited_fd` stays open in it.
  explicit BoardProcess(const std::vector<std::string>& arguments, int inherited_fd = -1,
                        const std::string& program = GICUBE_BIN_DIR "/gicube-board");
  // Kills it if it still runs.
  ~BoardProcess();
  BoardProcess(const BoardProcess&) = delete;
  BoardProcess& operator=(const BoardProcess&) = delete;

  // The next line of its stdout, without the line end; empty at the end.
  std::string read_line();
  // The rest of its stdout and of its stderr.
  std::string read_output();
  std::string read_errors();
  // Closes both.
  void stop_reading();

  pid_t id() const { return pid_; }
  void send_signal(int signal) const;
  // From now on it has at most so much address space.
  void limit_memory(std::uint64_t bytes) const;
  // The most that it has had in main memory so far.
  std::uint64_t peak_memory() const;
  // Waits for its end; 128 + signal if one ended it.
  int exit_code();
  bool has_ended();

 private:
  bool reap(int options);

  pid_t pid_ = -1;  // -1: it has ended
  int status_ = 0;
  int output_ = -1;
  int errors_ = -1;
};

}  // namespace gicube::system_test
