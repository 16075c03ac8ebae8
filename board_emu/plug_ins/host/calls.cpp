#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <exception>
#include <string>

#include "box/box.h"
#include "host.h"

namespace gicube::emu {

namespace {

constexpr std::chrono::hours kLong{1};

void scatter(const gicube_bsdf& routine, CallSlot& slot) {
  const std::uint32_t count = slot.count;
  for (std::uint32_t i = 0; i < count; ++i) {
    gicube_bsdf_event event = slot.events[i].event;
    event.parameters = slot.events[i].parameters;
    gicube_bsdf_answer answer{};
    answer.passes = 1;
    answer.cycles = routine.cycles;
    routine.scatter(&event, &answer);
    slot.answers[i] = answer;
    slot.turn.step();
  }
}

void answer(const gicube_bsdf& routine, CallSlot& slot) {
  slot.has_thrown = 0;
  slot.text[0] = '\0';
  try {
    if (slot.call == CallKind::kScatter) return scatter(routine, slot);
    const CallSlot::Event& first = slot.events[0];
    slot.verdict = routine.check(first.parameters, first.event.parameter_count, slot.text, sizeof slot.text);
  } catch (const std::exception& error) {
    slot.text[std::string(error.what()).copy(slot.text, kMaxText - 1)] = '\0';
    slot.has_thrown = 1;
  } catch (...) {
    slot.has_thrown = 1;
  }
}

[[noreturn]] void make_calls(CallMemory& memory, const gicube_bsdf& routine, CallSlot& slot, bool is_boxed) {
  const auto begin = reinterpret_cast<char*>(&memory), end = begin + sizeof memory;
  const auto first = reinterpret_cast<char*>(&slot), last = first + sizeof slot;
  ::munmap(begin, static_cast<std::size_t>(first - begin));
  if (last != end) ::munmap(last, static_cast<std::size_t>(end - last));
  ::close_range(STDERR_FILENO + 1, ~0u, 0);
  if (is_boxed) enter_box({.has_clients = false});
  Patience patience;
  for (;;) {
    while (!slot.turn.wait_for(Party::kBoard, slot.spins, patience, kLong)) continue;
    answer(routine, slot);
    slot.turn.give(Party::kBoard);
  }
}

class Workers {
 public:
  Workers(CallMemory& memory, const gicube_bsdf& routine, bool is_boxed)
      : memory_(memory), routine_(routine), is_boxed_(is_boxed) {}
  ~Workers() {
    for (std::uint32_t slot = 0; slot < kMaxCalls; ++slot) end(slot, true);
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  void begin(std::uint32_t slot) {
    end(slot, true);
    const pid_t parent = ::getpid(), process = ::fork();
    if (process == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
      if (::getppid() != parent) ::_exit(0);
      sigset_t none;
      sigemptyset(&none);
      ::sigprocmask(SIG_SETMASK, &none, nullptr);
      memory_.slots[slot].turn.begin();
      make_calls(memory_, routine_, memory_.slots[slot], is_boxed_);
    }
    if (process < 0) return report_end(slot, CallSlot::kNoProcess);
    processes_[slot] = process;
    memory_.slots[slot].process = process;
  }

  void end(std::uint32_t slot, bool waits) {
    if (processes_[slot] == 0) return;
    ::kill(processes_[slot], SIGKILL);
    if (!waits) return;
    ::waitpid(processes_[slot], nullptr, 0);
    processes_[slot] = 0;
  }

  void collect_ended() {
    for (;;) {
      int status = 0;
      const pid_t process = ::waitpid(-1, &status, WNOHANG);
      if (process <= 0) return;
      const auto ended = std::ranges::find(processes_, process);
      if (ended == processes_.end()) continue;
      *ended = 0;
      report_end(static_cast<std::size_t>(ended - processes_.begin()), status);
    }
  }

 private:
  void report_end(std::size_t slot, int status) {
    memory_.slots[slot].wait_status = status;
    memory_.slots[slot].turn.give(Party::kNobody);
  }

  CallMemory& memory_;
  const gicube_bsdf& routine_;
  const bool is_boxed_;
  std::array<pid_t, kMaxCalls> processes_{};
};

}  // namespace

void serve_orders(CallMemory& memory, const gicube_bsdf& routine, bool is_boxed) {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGCHLD);
  ::sigprocmask(SIG_BLOCK, &ends, nullptr);
  const int ended = ::signalfd(-1, &ends, SFD_CLOEXEC | SFD_NONBLOCK);
  Workers workers(memory, routine, is_boxed);
  for (;;) {
    pollfd events[]{{kSocketDescriptor, POLLIN, 0}, {ended, POLLIN, 0}};
    ::poll(events, 2, -1);
    if (events[1].revents != 0) {
      signalfd_siginfo info;
      while (::read(ended, &info, sizeof info) > 0) continue;
      workers.collect_ended();
    }
    if (events[0].revents == 0) continue;
    SlotOrder order;
    if (::recv(kSocketDescriptor, &order, sizeof order, 0) != static_cast<ssize_t>(sizeof order)) return;
    if (order.slot >= kMaxCalls) continue;
    if (order.kind == SlotOrder::Kind::kBegin) {
      workers.begin(order.slot);
    } else {
      workers.end(order.slot, false);
    }
  }
}

}  // namespace gicube::emu
