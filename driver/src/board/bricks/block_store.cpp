#include "block_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "gicube/error.h"

namespace gicube {
namespace {

std::string folder() {
  const char* const given = ::getenv("TMPDIR");
  return given != nullptr && *given != '\0' ? given : "/var/tmp";  // /tmp may be memory
}

[[noreturn]] void fail(const char* what, const std::string& got) {
  throw Error(fmt::format("volume: expected a folder {} that {} a volume larger than the card (TMPDIR), got {}",
                          folder(), what, got));
}

Fd nameless_file() {
  std::string path = folder() + "/gicube-volume-XXXXXX";
  Fd file(::mkostemp(path.data(), O_CLOEXEC));
  if (file.get() < 0) fail("can keep", std::strerror(errno));
  ::unlink(path.c_str());
  return file;
}

// Calls step(done) until `bytes` are done: pread or pwrite.
void in_steps(std::size_t bytes, const char* what, const auto& step) {
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t more = step(done);
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) fail(what, more < 0 ? std::strerror(errno) : "the end of the file");
    done += static_cast<std::size_t>(more);
  }
}

}  // namespace

BlockStore::BlockStore(std::size_t blocks, std::size_t block_bytes, Place place)
    : block_bytes_(block_bytes), places_(blocks, -1) {
  if (place == Place::kFile) file_ = nameless_file();
}

void BlockStore::write(std::int64_t place, std::span<const std::uint8_t> bytes) {
  if (file_.get() < 0) {
    memory_[static_cast<std::size_t>(place)].assign(bytes.begin(), bytes.end());
    return;
  }
  const off_t at = place * static_cast<off_t>(block_bytes_);
  in_steps(bytes.size(), "can keep", [&](std::size_t done) {
    return ::pwrite(file_.get(), bytes.data() + done, bytes.size() - done, at + static_cast<off_t>(done));
  });
}

void BlockStore::add(std::size_t block, std::span<const std::uint8_t> bytes) {
  if (file_.get() < 0) memory_.emplace_back();
  write(next_, bytes);
  places_[block] = next_++;
}

void BlockStore::put(std::size_t block, std::span<const std::uint8_t> bytes) {
  has(block) ? write(places_[block], bytes) : add(block, bytes);
}

void BlockStore::clear() {
  places_.assign(places_.size(), -1);
  next_ = 0;
  memory_.clear();
}

void BlockStore::state(Archive& archive) {
  std::vector<std::uint32_t> stored;
  for (std::size_t block = 0; block < count(); ++block) {
    if (has(block)) stored.push_back(static_cast<std::uint32_t>(block));
  }
  archive.list("blocks", stored);
  std::vector<std::uint8_t> bytes;
  for (const std::uint32_t block : stored) {
    const bool is_new = block < count() && !(archive.loads() && has(block));
    archive.expect(is_new, "blocks", fmt::format("each below {} once", count()), block);
    if (!archive.loads()) read(block, bytes);
    archive.bytes("block" + std::to_string(block), bytes, block_bytes_, block_bytes_);
    if (archive.loads()) add(block, bytes);
  }
}

void BlockStore::read(std::size_t block, std::vector<std::uint8_t>& out) const {
  const std::int64_t place = places_[block];
  if (file_.get() < 0) {
    out = memory_[static_cast<std::size_t>(place)];
    return;
  }
  out.resize(block_bytes_);
  const off_t at = place * static_cast<off_t>(block_bytes_);
  in_steps(out.size(), "gives back", [&](std::size_t done) {
    return ::pread(file_.get(), out.data() + done, out.size() - done, at + static_cast<off_t>(done));
  });
}

}  // namespace gicube
