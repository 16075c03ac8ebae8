#include "rights.h"

#include <linux/capability.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "box/box.h"

namespace gicube::emu {

CallMemory* shared_memory() {
  struct stat status {};
  if (::fstat(kMemoryDescriptor, &status) != 0 || status.st_size != sizeof(CallMemory)) return nullptr;
  void* const memory = ::mmap(nullptr, sizeof(CallMemory), PROT_READ | PROT_WRITE, MAP_SHARED, kMemoryDescriptor, 0);
  return memory != MAP_FAILED ? static_cast<CallMemory*>(memory) : nullptr;
}

void give_up_rights() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(signal, SIG_IGN);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct has[_LINUX_CAPABILITY_U32S_3]{}, none[_LINUX_CAPABILITY_U32S_3]{};
  ::syscall(SYS_capget, &header, has);
  // A service's filter of system calls may end who calls it.
  if ((has[0].permitted | has[1].permitted) != 0) ::syscall(SYS_capset, &header, none);
}

void end_with_parent(bool does) {
  ::prctl(PR_SET_PDEATHSIG, does ? SIGKILL : 0, 0, 0, 0);
  pollfd orders{kOrdersDescriptor, 0, 0};  // it may have gone before
  if (::poll(&orders, 1, 0) > 0 && (orders.revents & POLLHUP) != 0) ::_exit(0);
}

void enter_call_box(CallMemory& memory, const CallSlot& own, bool is_boxed) {
  const auto begin = reinterpret_cast<char*>(&memory), end = begin + sizeof memory;
  const auto first = reinterpret_cast<const char*>(&own), last = first + sizeof own;
  ::munmap(begin, static_cast<std::size_t>(first - begin));
  if (last != end) ::munmap(begin + (last - begin), static_cast<std::size_t>(end - last));
  ::close_range(STDERR_FILENO + 1, ~0u, 0);
  if (is_boxed) enter_box({.has_clients = false});
}

}  // namespace gicube::emu
