#include "scratch_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "gicube/error.h"

namespace gicube {
namespace {

std::string folder() {
  const char* const given = ::getenv("TMPDIR");
  return given != nullptr && *given != '\0' ? given : "/var/tmp";  // /tmp may be memory
}

}  // namespace

void ScratchFile::fail(const char* does, const std::string& got) const {
  throw Error(fmt::format("volume: expected a folder {} that {} {} (TMPDIR), got {}", folder(), does, what_, got));
}

// Calls step(done) until `bytes` are done: pread or pwrite.
void ScratchFile::in_steps(std::size_t bytes, const char* does, const auto& step) const {
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t more = step(done);
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) fail(does, more < 0 ? std::strerror(errno) : "the end of the file");
    done += static_cast<std::size_t>(more);
  }
}

ScratchFile::ScratchFile(std::string what) : what_(std::move(what)) {
  std::string path = folder() + "/gicube-volume-XXXXXX";
  file_ = Fd(::mkostemp(path.data(), O_CLOEXEC));
  if (file_.get() < 0) fail("can keep", std::strerror(errno));
  ::unlink(path.c_str());
}

void ScratchFile::write(std::uint64_t at, std::span<const std::uint8_t> bytes) {
  in_steps(bytes.size(), "can keep", [&](std::size_t done) {
    return ::pwrite(file_.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
  });
}

void ScratchFile::read(std::uint64_t at, std::span<std::uint8_t> bytes) const {
  in_steps(bytes.size(), "gives back", [&](std::size_t done) {
    return ::pread(file_.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
  });
}

}  // namespace gicube
