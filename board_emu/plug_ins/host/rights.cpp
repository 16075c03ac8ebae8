#include <linux/capability.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "host.h"

namespace gicube::emu {

CallMemory* shared_memory() {
  struct stat status {};
  if (::fstat(kMemoryDescriptor, &status) != 0 || status.st_size != sizeof(CallMemory)) return nullptr;
  void* const memory = ::mmap(nullptr, sizeof(CallMemory), PROT_READ | PROT_WRITE, MAP_SHARED, kMemoryDescriptor, 0);
  ::close(kMemoryDescriptor);
  return memory != MAP_FAILED ? static_cast<CallMemory*>(memory) : nullptr;
}

void give_up_rights(bool is_observer) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(signal, SIG_IGN);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  if (is_observer) return;
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct has[_LINUX_CAPABILITY_U32S_3]{}, none[_LINUX_CAPABILITY_U32S_3]{};
  ::syscall(SYS_capget, &header, has);
  // A service's system call filter may kill a process for this call.
  if ((has[0].permitted | has[1].permitted) != 0) ::syscall(SYS_capset, &header, none);
}

void end_with_parent(bool does) {
  ::prctl(PR_SET_PDEATHSIG, does ? SIGKILL : 0, 0, 0, 0);
  pollfd board{kSocketDescriptor, 0, 0};  // it may have ended before this call
  if (::poll(&board, 1, 0) > 0 && (board.revents & POLLHUP) != 0) ::_exit(0);
}

}  // namespace gicube::emu
