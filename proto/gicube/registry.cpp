#include "gicube/registry.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace gicube {

std::string registry_folder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  struct stat status {};
  // A root that has kept a user's environment leaves that user's folder alone.
  const bool is_mine = runtime != nullptr && *runtime == '/' && ::stat(runtime, &status) == 0 &&
                       S_ISDIR(status.st_mode) && status.st_uid == ::geteuid();
  return is_mine ? std::string(runtime) + "/gicube" : "/tmp/gicube-" + std::to_string(::geteuid());
}

std::string registry_fault(const std::string& folder) {
  struct stat status {};
  const std::string expected =
      folder + ": expected a folder of user " + std::to_string(::geteuid()) + ", mode 700, got ";
  if (::lstat(folder.c_str(), &status) != 0) return expected + std::generic_category().message(errno);
  if (!S_ISDIR(status.st_mode)) return expected + "a file";
  if (status.st_uid != ::geteuid()) return expected + "one of user " + std::to_string(status.st_uid);
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) == 0) return {};
  std::string digits;
  for (const int shift : {6, 3, 0}) digits += static_cast<char>('0' + (status.st_mode >> shift & 7));
  return expected + "mode " + digits;
}

}  // namespace gicube
