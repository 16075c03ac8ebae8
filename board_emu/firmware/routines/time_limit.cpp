#include "firmware/routines/time_limit.h"

#include <setjmp.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <system_error>

// glibc 2.36 has the field but not its documented name.
#ifndef sigev_notify_thread_id
#define sigev_notify_thread_id _sigev_un._tid
#endif

namespace gicube::emu {

namespace {

std::chrono::nanoseconds cpu_time() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

int tick_signal() { return SIGRTMIN + 4; }

// Of one thread. The handler runs on the thread that it watches: what they share needs no more than order.
class Watch {
 public:
  Watch();
  ~Watch() {
    ::timer_delete(timer_);
    current = nullptr;
  }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  bool run(void (*call)(void*), void* context);

 private:
  static void tick(int);
  bool set_ticks(std::chrono::nanoseconds period);  // 0: none

  static constinit thread_local Watch* current;

  timer_t timer_{};
  sigjmp_buf home_;
  volatile sig_atomic_t inside_ = 0;
  volatile sig_atomic_t ticking_ = 0;
  volatile std::uint64_t call_ = 0;  // running number
  std::uint64_t seen_ = 0;           // the tick's: the call that it found, since when, and how often
  std::uint64_t idle_ = 0;           // and the last call at a tick between calls
  std::chrono::nanoseconds since_{};
  int ticks_ = 0;
};

constinit thread_local Watch* Watch::current = nullptr;

Watch::Watch() {
  struct sigaction action {};
  action.sa_handler = &Watch::tick;
  action.sa_flags = SA_RESTART | SA_NODEFER;  // not deferred: the handler may be left by a jump
  sigemptyset(&action.sa_mask);
  if (::sigaction(tick_signal(), &action, nullptr) != 0) fail("sigaction");
  sigset_t ticks;
  sigemptyset(&ticks);
  sigaddset(&ticks, tick_signal());
  ::pthread_sigmask(SIG_UNBLOCK, &ticks, nullptr);

  current = this;
  sigevent event{};
  event.sigev_notify = SIGEV_THREAD_ID;
  event.sigev_signo = tick_signal();
  event.sigev_notify_thread_id = ::gettid();
  if (::timer_create(CLOCK_MONOTONIC, &event, &timer_) != 0) fail("timer_create");
}

bool Watch::set_ticks(std::chrono::nanoseconds period) {
  itimerspec spec{};
  spec.it_value.tv_nsec = spec.it_interval.tv_nsec = period.count();
  ticking_ = period.count() != 0 ? 1 : 0;
  return ::timer_settime(timer_, 0, &spec, nullptr) == 0;
}

void Watch::tick(int) {
  const int error = errno;
  Watch* const watch = current;
  if (watch != nullptr && watch->inside_ == 0) {
    if (watch->idle_ == watch->call_) watch->set_ticks({});  // no call since the last tick: let the thread sleep
    watch->idle_ = watch->call_;
  } else if (watch != nullptr) {
    if (watch->seen_ != watch->call_) {
      watch->seen_ = watch->call_;
      watch->since_ = cpu_time();
      watch->ticks_ = 0;
    } else if (++watch->ticks_ >= kTicksLimit || cpu_time() - watch->since_ >= kCpuLimit) {
      watch->inside_ = 0;
      ::siglongjmp(watch->home_, 1);
    }
  }
  errno = error;
}

// Nothing here may need a destructor.
[[gnu::noinline]] bool Watch::run(void (*call)(void*), void* context) {
  if (sigsetjmp(home_, 0) != 0) return false;
  call_ = call_ + 1;
  std::atomic_signal_fence(std::memory_order_seq_cst);
  inside_ = 1;
  try {
    if (ticking_ == 0 && !set_ticks(kTick)) fail("timer_settime");
    call(context);
  } catch (...) {
    inside_ = 0;
    throw;
  }
  inside_ = 0;
  return true;
}

}  // namespace

bool run_limited(void (*call)(void*), void* context) {
  thread_local Watch watch;
  return watch.run(call, context);
}

}  // namespace gicube::emu
