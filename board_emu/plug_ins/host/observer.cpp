#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <exception>
#include <thread>
#include <vector>

#include "host.h"

namespace gicube::emu {

namespace {

// Ends the process if the observer's code does not return after the board has closed its end of the socket, because it
// has ended or no longer waits for this process.
[[noreturn]] void end_with_board() {
  constexpr int kPatienceMs = 30'000;  // PlugInProcess::kPatience
  constexpr int kLeftMs = 2'000;       // chosen: the events left in the socket take milliseconds
  const auto wait_for = [](short event, int limit_ms) {
    pollfd board{kSocketDescriptor, event, 0};
    while (::poll(&board, 1, limit_ms) < 0 && errno == EINTR) continue;
  };
  wait_for(POLLRDHUP, -1);
  wait_for(0, kPatienceMs);
  ::poll(nullptr, 0, kLeftMs);
  ::_exit(1);
}

}  // namespace

int serve_events(const gicube_observer& observer, const char* file) {
  std::thread(end_with_board).detach();
  std::vector<gicube_event> events(kMaxObserved);
  try {
    for (;;) {
      const ssize_t got = ::recv(kSocketDescriptor, events.data(), events.size() * sizeof(gicube_event), 0);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      observer.take(events.data(), static_cast<std::size_t>(got) / sizeof(gicube_event));
    }
    if (observer.end != nullptr) observer.end();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gicube-plug-in-host: %s threw: %s\n", file, error.what());
    return 1;
  }
  return 0;
}

}  // namespace gicube::emu
