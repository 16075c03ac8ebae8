#include "landlock.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <string>
#include <system_error>

#include "every_thread.h"
#include "words/scope_exit.h"

namespace gicube::emu {
namespace {

// Constants of later versions than the header of Debian 12 (Documentation/userspace-api/landlock.rst of Linux 6.10).
constexpr std::uint64_t kTruncate = 1u << 14;       // version 3
constexpr std::uint64_t kIoctlOfDevice = 1u << 15;  // version 5
constexpr std::uint64_t kBindTcp = 1u << 0, kConnectTcp = 1u << 1;
constexpr int kVersionOfMoves = 2, kVersionOfTruncate = 3, kVersionOfTcp = 4, kVersionOfIoctl = 5;

struct RulesetAttributes {  // landlock_ruleset_attr of version 4; earlier versions have only the first field
  std::uint64_t files = 0;
  std::uint64_t tcp = 0;
};

// All rights of a version. They are refused unless a place allows them.
std::uint64_t known_rights(int version) {
  std::uint64_t rights = (std::uint64_t{LANDLOCK_ACCESS_FS_MAKE_SYM} << 1) - 1;  // all of version 1
  if (version >= kVersionOfMoves) rights |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= kVersionOfTruncate) rights |= kTruncate;
  if (version >= kVersionOfIoctl) rights |= kIoctlOfDevice;
  return rights;
}

std::uint64_t rights_of(Box::Access access) {
  switch (access) {
    case Box::Access::kRead: return LANDLOCK_ACCESS_FS_READ_FILE;
    case Box::Access::kRemove: return LANDLOCK_ACCESS_FS_REMOVE_FILE;
    case Box::Access::kWrite:
      return LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_FILE | kTruncate;
  }
  return 0;
}

[[noreturn]] void fail_at(const std::string& what) { throw std::system_error(errno, std::generic_category(), what); }

void add(int ruleset, const Box::Path& allowed, std::uint64_t known) {
  const int fd = ::open(allowed.path.c_str(), O_PATH | O_CLOEXEC);
  if (fd < 0 && errno == ENOENT) return;
  if (fd < 0) fail_at(allowed.path);
  const ScopeExit closed{[fd] { ::close(fd); }};
  landlock_path_beneath_attr rule{};
  rule.allowed_access = rights_of(allowed.access) & known;
  rule.parent_fd = fd;
  if (::syscall(SYS_landlock_add_rule, ruleset, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) != 0) fail_at(allowed.path);
}

// Restricts the calling thread. Runs in a signal handler. Returns errno or 0.
int restrict_thread(int ruleset) {
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return errno;
  return ruleset < 0 || ::syscall(SYS_landlock_restrict_self, ruleset, 0) == 0 ? 0 : errno;
}

}  // namespace

int restrict_files(const std::vector<Box::Path>& paths) {
  const auto version =
      static_cast<int>(::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION));
  if (version < 1) {
    on_every_thread(restrict_thread, -1);
    return 0;
  }
  const std::uint64_t known = known_rights(version);
  const RulesetAttributes attributes{known, kBindTcp | kConnectTcp};
  const std::size_t size = version >= kVersionOfTcp ? sizeof attributes : sizeof attributes.files;
  const auto ruleset = static_cast<int>(::syscall(SYS_landlock_create_ruleset, &attributes, size, 0));
  if (ruleset < 0) fail_at("Landlock");
  const ScopeExit closed{[ruleset] { ::close(ruleset); }};
  for (const Box::Path& allowed : paths) add(ruleset, allowed, known);
  on_every_thread(restrict_thread, ruleset);
  return version;
}

}  // namespace gicube::emu
