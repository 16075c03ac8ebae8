#include "gicube/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <random>
#include <system_error>
#include <utility>

namespace gicube {
namespace {

constexpr std::size_t kPiece = std::size_t{64} << 10;  // chosen: few system calls, little memory
constexpr int kMaxNames = 100;                         // chosen: attempts with 32 random bits each

[[noreturn]] void fail(const std::string& what, int error = errno) {
  throw std::system_error(error, std::generic_category(), what);
}

// Returns the file descriptor of this process that the name, or the link of that name (such as /dev/stdout), refers to;
// -1: none.
int own_descriptor(const std::filesystem::path& name) {
  std::error_code none;
  for (const std::string& text : {name.string(), std::filesystem::read_symlink(name, none).string()}) {
    for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
      if (!text.starts_with(folder)) continue;
      int fd = -1;
      const char* const last = text.data() + text.size();
      const auto [end, error] = std::from_chars(text.data() + folder.size(), last, fd);
      if (error == std::errc{} && end == last) return fd;
    }
  }
  return -1;
}

// Follows all links of a name. The target need not exist.
std::filesystem::path followed(std::filesystem::path name) {
  std::error_code none;
  while (std::filesystem::is_symlink(name, none)) name = name.parent_path() / std::filesystem::read_symlink(name, none);
  return name;
}

// Copies mode, owner and group of the replaced file to the new one, but grants no permission that is not in `mode`. If
// the group cannot be set, it gets no permissions.
bool take_over(int fd, const struct stat& before, unsigned mode) {
  constexpr unsigned kAll = 0777, kReadWrite = 0666, kGroup = 0070;
  unsigned kept = before.st_mode & kAll & ~(kReadWrite & ~mode);
  const auto same_owner = static_cast<uid_t>(-1);
  const bool has_group =
      ::fchown(fd, before.st_uid, before.st_gid) == 0 || ::fchown(fd, same_owner, before.st_gid) == 0;
  if (!has_group) kept &= ~kGroup;
  return ::fchmod(fd, kept) == 0;
}

}  // namespace

bool may_be_written(const std::filesystem::path& file) {
  constexpr unsigned kWrite = 0222;
  struct stat there {};
  if (::stat(file.c_str(), &there) != 0 || !S_ISREG(there.st_mode)) return true;
  return (there.st_mode & kWrite) != 0 && ::faccessat(AT_FDCWD, file.c_str(), W_OK, AT_EACCESS) == 0;
}

WholeFile::WholeFile(const std::filesystem::path& target, unsigned mode) : target_(target) {
  struct stat there {};
  const int missing = ::stat(target.c_str(), &there) == 0 ? 0 : errno;
  if (const int own = own_descriptor(target); own >= 0) {
    fd_ = ::fcntl(own, F_DUPFD_CLOEXEC, 0);
  } else if (missing != 0 && missing != ENOENT) {
    fail(target.string(), missing);
  } else if (missing == 0 && !S_ISREG(there.st_mode)) {
    fd_ = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
  } else if (!may_be_written(target)) {
    fail(target.string(), EACCES);
  } else {
    place_ = followed(target);
    std::random_device random;
    for (int i = 0; i < kMaxNames && fd_ < 0; ++i) {
      std::array<char, 16> ending{};
      std::snprintf(ending.data(), ending.size(), ".%08x.part", random());
      part_ = place_.string() + ending.data();
      fd_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
      if (fd_ < 0 && errno != EEXIST) break;
    }
    if (fd_ >= 0 && missing == 0 && !take_over(fd_, there, mode)) fail(target.string());
  }
  if (fd_ < 0) fail(target.string());
}

WholeFile::~WholeFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!part_.empty()) ::unlink(part_.c_str());
}

void WholeFile::put(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(target_.string());
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void WholeFile::write(std::string_view bytes) {
  if (waiting_.size() + bytes.size() > kPiece) flush();
  if (bytes.size() > kPiece) return put(bytes);
  waiting_ += bytes;
}

void WholeFile::flush() {
  put(waiting_);
  waiting_.clear();
}

void WholeFile::close() {
  flush();
  // Some FUSE file systems do not support fsync and return EINVAL.
  if (!part_.empty() && ::fsync(fd_) != 0 && errno != EINVAL) fail(target_.string());
  if (::close(std::exchange(fd_, -1)) != 0) fail(target_.string());
}

void WholeFile::commit() {
  if (fd_ >= 0) close();
  if (part_.empty()) return;
  if (::rename(part_.c_str(), place_.c_str()) != 0) fail(target_.string());
  part_.clear();
}

void check_standard_output() {
  if (std::fflush(stdout) != 0) fail("standard output");
  if (std::ferror(stdout) != 0) fail("standard output", EIO);
}

}  // namespace gicube
