// The process of its own in which the code of an observer runs: gicube-observer-host. It gets events through a socket, has nothing else of
// the board, and gives no answer: what it does changes nothing on the board but how long a command takes on this machine.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "gicube/observer.h"

namespace gicube::emu {

class ObserverProcess {
 public:
  // Starts it and has it load `file`; is_boxed: it is in a box from then on (box/box.h). Throws std::runtime_error that names the file.
  ObserverProcess(const std::string& file, bool is_boxed);
  // It has had all events, and has ended, or was ended for not taking them.
  ~ObserverProcess();
  ObserverProcess(const ObserverProcess&) = delete;
  ObserverProcess& operator=(const ObserverProcess&) = delete;

  void add(const gicube_event& event) {
    events_.push_back(event);
    if (events_.size() >= kEvents) flush();
  }
  void flush();
  // Why it gets no more events; empty: it does.
  const std::string& fault() const { return fault_; }

 private:
  static constexpr std::size_t kEvents = 256;  // chosen: some ten kilobytes at once

  std::string file_;
  pid_t process_ = 0;
  int socket_ = -1;
  std::vector<gicube_event> events_;
  std::string fault_;
};

}  // namespace gicube::emu
