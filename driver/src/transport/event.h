// Something that happens once, which an event loop can wait for by a file descriptor.
#pragma once

#include <fcntl.h>
#include <sys/eventfd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>

#include "fd.h"
#include "gicube/error.h"

namespace gicube {

inline int checked_event(int fd) {
  if (fd < 0) throw Error(std::string("cannot make a descriptor for an event: ") + std::strerror(errno));
  return fd;
}

inline Fd duplicate(const Fd& of) { return Fd(checked_event(::fcntl(of.get(), F_DUPFD_CLOEXEC, 0))); }

class Event {
 public:
  Event() : fd_(checked_event(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK))) {}
  // Afterwards nobody can report it any more: whoever waits must not wait forever.
  ~Event() { happen(); }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;

  // Any thread, any number of times.
  void happen() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(fd_.get(), &one, sizeof one);  // fails only after almost 2^64 calls
  }

  // Becomes readable when it happens. A duplicate, which the caller closes; it outlives the event.
  Fd descriptor() const { return duplicate(fd_); }

 private:
  Fd fd_;
};

}  // namespace gicube
