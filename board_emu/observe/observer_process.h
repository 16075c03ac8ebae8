// Runs the code of an observer in its own process (plug_ins/plug_in_process.h). The process receives events through a
// socket and sends no reply, so it affects only the host time of a command.
#pragma once

#include <string>
#include <vector>

#include "gicube/observer.h"
#include "plug_ins/plug_in_process.h"

namespace gicube::emu {

class ObserverProcess {
 public:
  // Throws PlugInFault.
  ObserverProcess(const std::string& file, bool is_boxed)
      : process_(PlugInProcess::Kind::kObserver, file, is_boxed), file_(file) {}
  // Sends the remaining events, then ends the process.
  ~ObserverProcess() { flush(); }
  ObserverProcess(const ObserverProcess&) = delete;
  ObserverProcess& operator=(const ObserverProcess&) = delete;

  void add(const gicube_event& event) {
    events_.push_back(event);
    if (events_.size() == kMaxObserved) flush();
  }
  void flush() {
    const std::size_t bytes = events_.size() * sizeof(gicube_event);
    if (fault_.empty() && bytes > 0 && !process_.send(events_.data(), bytes, PlugInProcess::kPatience)) {
      process_.give_up();
      fault_ = "observer " + file_ + ": it has ended, or took no events for 30 s; it gets no further events";
    }
    events_.clear();
  }
  // Why no more events are sent; empty: they are sent.
  const std::string& fault() const { return fault_; }

 private:
  PlugInProcess process_;
  const std::string file_;
  std::vector<gicube_event> events_;
  std::string fault_;
};

}  // namespace gicube::emu
