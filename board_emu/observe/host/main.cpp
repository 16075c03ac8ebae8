// gicube-observer-host: the process in which the code of an observer runs (observe/observer_process.h starts it). Standard input is the
// socket: one line goes out, what is wrong with the object or nothing, then events come in until the board ends.
#include <dlfcn.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include "box/box.h"
#include "gicube/observer.h"

namespace {

std::string load(const char* file, const gicube_observer*& observer) {
  void* const library = ::dlopen(file, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return ::dlerror();
  void* const symbol = ::dlsym(library, "gicube_observer_describe");
  if (symbol == nullptr) return "expected a function gicube_observer_describe, got none";
  try {
    observer = reinterpret_cast<const gicube_observer* (*)()>(symbol)();
  } catch (...) {
    return "gicube_observer_describe() threw an exception";
  }
  if (observer == nullptr) return "gicube_observer_describe() returned null";
  if (observer->abi != GICUBE_OBSERVER_ABI) {
    return "abi: expected " + std::to_string(GICUBE_OBSERVER_ABI) + ", got " + std::to_string(observer->abi);
  }
  if (observer->size < sizeof *observer) {
    return "size: expected at least " + std::to_string(sizeof *observer) + ", got " + std::to_string(observer->size);
  }
  return observer->take == nullptr ? "take: expected a function, got null" : "";
}

void serve(const gicube_observer& observer) {
  std::vector<gicube_event> events(256);
  const std::size_t room = events.size() * sizeof(gicube_event);
  for (std::size_t held = 0;;) {
    const ssize_t got = ::read(STDIN_FILENO, reinterpret_cast<char*>(events.data()) + held, room - held);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    held += static_cast<std::size_t>(got);
    const std::size_t whole = held / sizeof(gicube_event), rest = held % sizeof(gicube_event);
    if (whole == 0) continue;
    observer.take(events.data(), whole);
    std::memmove(events.data(), events.data() + whole, rest);
    held = rest;
  }
  if (observer.end != nullptr) observer.end();
}

// The board closes its end once it has ended, or waits for this process no longer. An observer whose code does not
// return then is ended.
[[noreturn]] void end_with_board() {
  constexpr int kPatienceMs = 30'000;  // as the board's
  constexpr int kLeftMs = 2'000;       // chosen: without a board, what is in the socket takes milliseconds
  const auto wait_for = [](short event, int limit_ms) {
    pollfd board{STDIN_FILENO, event, 0};
    while (::poll(&board, 1, limit_ms) < 0 && errno == EINTR) continue;
  };
  wait_for(POLLRDHUP, -1);
  wait_for(0, kPatienceMs);
  ::poll(nullptr, 0, kLeftMs);
  ::_exit(1);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr,
                 "gicube-observer-host: gicube-board --observer FILE starts this program; by itself it does nothing\n");
    return 2;
  }
  for (const int each : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(each, SIG_IGN);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  std::thread(end_with_board).detach();
  const gicube_observer* observer = nullptr;
  std::string fault = load(argv[1], observer);
  for (char& each : fault) each = each < ' ' || each > '~' ? '?' : each;
  const bool is_good = fault.empty();
  fault += '\n';
  if (is_good && std::strcmp(argv[2], "boxed") == 0) gicube::emu::enter_box({.has_clients = false});
  if (::write(STDIN_FILENO, fault.data(), fault.size()) != static_cast<ssize_t>(fault.size()) || !is_good) return 1;
  try {
    serve(*observer);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gicube-observer-host: %s threw: %s\n", argv[1], error.what());
    return 1;
  }
  return 0;
}
