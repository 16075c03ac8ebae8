#include "call_filter.h"

#include <fcntl.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

namespace gicube::emu {
namespace {

// System call numbers. libseccomp ignores those that a processor architecture does not have.
using Calls = std::initializer_list<int>;

constexpr Calls kComputing{
    // Memory
    SCMP_SYS(brk), SCMP_SYS(madvise), SCMP_SYS(mremap), SCMP_SYS(munmap),
    // Threads
    SCMP_SYS(exit), SCMP_SYS(exit_group), SCMP_SYS(futex), SCMP_SYS(getpid), SCMP_SYS(gettid), SCMP_SYS(rseq),
    SCMP_SYS(sched_get_priority_max), SCMP_SYS(sched_get_priority_min), SCMP_SYS(sched_getaffinity),
    SCMP_SYS(sched_getparam), SCMP_SYS(sched_getscheduler), SCMP_SYS(sched_yield), SCMP_SYS(set_robust_list),
    // Signals and time
    SCMP_SYS(clock_getres), SCMP_SYS(clock_gettime), SCMP_SYS(clock_nanosleep), SCMP_SYS(gettimeofday),
    SCMP_SYS(nanosleep), SCMP_SYS(pause), SCMP_SYS(restart_syscall), SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(rt_sigreturn), SCMP_SYS(rt_sigtimedwait), SCMP_SYS(sigaltstack), SCMP_SYS(time), SCMP_SYS(timer_create),
    SCMP_SYS(timer_delete), SCMP_SYS(timer_getoverrun), SCMP_SYS(timer_gettime), SCMP_SYS(timer_settime),
    // Queries of the libraries about this process and the machine
    SCMP_SYS(getcpu), SCMP_SYS(getegid), SCMP_SYS(geteuid), SCMP_SYS(getgid), SCMP_SYS(getrandom), SCMP_SYS(getrusage),
    SCMP_SYS(getuid), SCMP_SYS(sysinfo), SCMP_SYS(uname)};

// Use of open files, and waiting for them. Libraries query the status of an open file with newfstatat.
// clang-format off
constexpr Calls kOpenFiles{
    SCMP_SYS(close), SCMP_SYS(epoll_create1), SCMP_SYS(epoll_ctl), SCMP_SYS(epoll_pwait), SCMP_SYS(epoll_wait),
    SCMP_SYS(eventfd2), SCMP_SYS(fstat), SCMP_SYS(fsync), SCMP_SYS(ftruncate), SCMP_SYS(lseek), SCMP_SYS(newfstatat),
    SCMP_SYS(pipe2), SCMP_SYS(poll), SCMP_SYS(ppoll), SCMP_SYS(pread64), SCMP_SYS(pwrite64), SCMP_SYS(read),
    SCMP_SYS(readv), SCMP_SYS(recvfrom), SCMP_SYS(recvmsg), SCMP_SYS(sendmsg), SCMP_SYS(sendto), SCMP_SYS(shutdown),
    SCMP_SYS(timerfd_create), SCMP_SYS(timerfd_settime), SCMP_SYS(write), SCMP_SYS(writev)};
// clang-format on

constexpr Calls kClients{SCMP_SYS(accept),      SCMP_SYS(accept4),    SCMP_SYS(getpeername),
                         SCMP_SYS(getsockname), SCMP_SYS(getsockopt), SCMP_SYS(setsockopt)};

// Files by name. Landlock restricts the files, but not status queries.
constexpr Calls kNamedFiles{SCMP_SYS(access),    SCMP_SYS(faccessat), SCMP_SYS(faccessat2), SCMP_SYS(lstat),
                            SCMP_SYS(open),      SCMP_SYS(openat),    SCMP_SYS(rename),     SCMP_SYS(renameat),
                            SCMP_SYS(renameat2), SCMP_SYS(stat),      SCMP_SYS(statx),      SCMP_SYS(unlink),
                            SCMP_SYS(unlinkat)};

// No library of the process makes these calls. A process that does has been compromised and is killed.
// clang-format off
constexpr Calls kHostile{
    SCMP_SYS(add_key), SCMP_SYS(bpf), SCMP_SYS(chroot), SCMP_SYS(delete_module), SCMP_SYS(execve), SCMP_SYS(execveat),
    SCMP_SYS(finit_module), SCMP_SYS(init_module), SCMP_SYS(io_uring_setup), SCMP_SYS(kexec_file_load),
    SCMP_SYS(kexec_load), SCMP_SYS(keyctl), SCMP_SYS(mount), SCMP_SYS(move_mount), SCMP_SYS(open_by_handle_at),
    SCMP_SYS(open_tree), SCMP_SYS(perf_event_open), SCMP_SYS(pidfd_getfd), SCMP_SYS(pivot_root),
    SCMP_SYS(process_vm_readv), SCMP_SYS(process_vm_writev), SCMP_SYS(ptrace), SCMP_SYS(request_key), SCMP_SYS(setns),
    SCMP_SYS(umount2), SCMP_SYS(unshare), SCMP_SYS(userfaultfd)};
// clang-format on

// Checks a result of libseccomp: 0, or a negative error.
void check(int result) {
  if (result != 0) throw std::system_error(-result, std::generic_category(), "seccomp");
}

class Filter {
 public:
  // All calls without a rule return EPERM.
  Filter() : context_(::seccomp_init(SCMP_ACT_ERRNO(EPERM)), &::seccomp_release) {
    if (!context_) check(-ENOMEM);
    set(SCMP_FLTATR_CTL_TSYNC, 1);
    set(SCMP_FLTATR_CTL_OPTIMIZE, 2);  // binary tree instead of a linear search
    set(SCMP_FLTATR_API_SYSRAWRC, 1);  // report the kernel's own errors
  }

  void add(std::uint32_t action, Calls calls) {
    for (const int call : calls) add(action, call, {});
  }
  void allow(Calls calls) { add(SCMP_ACT_ALLOW, calls); }

  // Conditions on an argument: its masked bits, or all of it, equal a value.
  static scmp_arg_cmp bits(unsigned argument, std::uint64_t mask, std::uint64_t value) {
    return {argument, SCMP_CMP_MASKED_EQ, mask, value};
  }
  static scmp_arg_cmp equals(unsigned argument, std::uint64_t value) { return {argument, SCMP_CMP_EQ, value, 0}; }
  void allow_if(int call, const std::vector<scmp_arg_cmp>& conditions) { add(SCMP_ACT_ALLOW, call, conditions); }

  void load() { check(::seccomp_load(context_.get())); }

 private:
  void set(scmp_filter_attr attribute, std::uint32_t value) {
    check(::seccomp_attr_set(context_.get(), attribute, value));
  }
  void add(std::uint32_t action, int call, const std::vector<scmp_arg_cmp>& conditions) {
    check(::seccomp_rule_add_array(context_.get(), action, call, static_cast<unsigned>(conditions.size()),
                                   conditions.data()));
  }

  std::unique_ptr<void, void (*)(void*)> context_;
};

// Writable memory can never be executed.
void allow_memory(Filter& filter) {
  for (const int call : {SCMP_SYS(mmap), SCMP_SYS(mprotect)}) filter.allow_if(call, {Filter::bits(2, PROT_EXEC, 0)});
}

// Allows new threads, but no processes and no namespaces.
void allow_threads(Filter& filter) {
  constexpr std::uint64_t kNamespaces =
      CLONE_NEWCGROUP | CLONE_NEWIPC | CLONE_NEWNET | CLONE_NEWNS | CLONE_NEWPID | CLONE_NEWUSER | CLONE_NEWUTS;
  filter.allow_if(SCMP_SYS(clone), {Filter::bits(0, CLONE_THREAD | kNamespaces, CLONE_THREAD)});
  filter.add(SCMP_ACT_ERRNO(ENOSYS), {SCMP_SYS(clone3)});  // its flags cannot be checked; libc then uses clone
  filter.allow_if(SCMP_SYS(prctl), {Filter::equals(0, PR_SET_NAME)});
  filter.allow_if(SCMP_SYS(tgkill), {Filter::equals(0, static_cast<std::uint64_t>(::getpid()))});
  filter.allow_if(SCMP_SYS(prlimit64), {Filter::equals(0, 0), Filter::equals(2, 0)});  // reads its own limits
}

void allow_modes_of_descriptors(Filter& filter) {
  for (const int request : {FIONBIO, FIONREAD, TCGETS}) {
    filter.allow_if(SCMP_SYS(ioctl), {Filter::equals(1, static_cast<std::uint64_t>(request))});
  }
  for (const int command : {F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL, F_SETFL}) {
    filter.allow_if(SCMP_SYS(fcntl), {Filter::equals(1, static_cast<std::uint64_t>(command))});
  }
}

}  // namespace

bool filter_calls(bool uses_files, bool has_clients) {
  const std::uint32_t kill = SECCOMP_RET_KILL_PROCESS;
  if (::syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &kill) != 0) return false;
  Filter filter;
  filter.allow(kComputing);
  filter.allow(kOpenFiles);
  if (uses_files) filter.allow(kNamedFiles);
  if (has_clients) filter.allow(kClients);
  allow_memory(filter);
  allow_threads(filter);
  allow_modes_of_descriptors(filter);
  filter.add(SCMP_ACT_KILL_PROCESS, kHostile);
  filter.load();
  return true;
}

}  // namespace gicube::emu
