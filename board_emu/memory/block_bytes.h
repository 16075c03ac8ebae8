// The bytes of a volume's blocks as the host wrote them. A block that was never written is uniformly zero and takes no memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gicube/archive.h"

namespace gicube::emu {

class BlockBytes {
 public:
  explicit BlockBytes(std::size_t block_bytes) : block_bytes_(block_bytes) {}

  void resize(std::size_t blocks) {  // forgets everything
    blocks_.clear();                 // first: there may be no memory for both
    blocks_.resize(blocks);
    stored_ = 0;
  }

  std::size_t count() const { return blocks_.size(); }
  std::size_t block_bytes() const { return block_bytes_; }
  std::uint64_t bytes() const { return std::uint64_t{count()} * block_bytes_; }  // of the address range
  std::size_t stored() const { return stored_; }                                 // blocks
  bool is_stored(std::size_t block) const { return !blocks_[block].empty(); }
  std::span<const std::uint8_t> operator[](std::size_t block) const { return blocks_[block]; }  // empty: never written
  std::uint8_t& byte(std::size_t block, std::size_t at) { return blocks_[block][at]; }          // of a stored one

  // What a write of such bytes would add.
  std::uint64_t bytes_to_write(std::uint64_t offset, std::uint64_t length) const {
    if (length == 0 || offset + length > bytes()) return 0;
    std::uint64_t fresh = 0;
    for (std::uint64_t block = offset / block_bytes_; block <= (offset + length - 1) / block_bytes_; ++block) {
      if (!is_stored(static_cast<std::size_t>(block))) ++fresh;
    }
    return fresh * block_bytes_;
  }

  // offset + length <= bytes(). `written(block)` is told of each block.
  template <typename Written>
  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes, const Written& written) {
    while (!bytes.empty()) {
      const auto block = static_cast<std::size_t>(offset / block_bytes_);
      const auto at = static_cast<std::size_t>(offset % block_bytes_);
      const std::size_t length = std::min(bytes.size(), block_bytes_ - at);
      auto& stored = blocks_[block];
      if (stored.empty()) {
        stored.resize(block_bytes_);
        ++stored_;
      }
      std::copy_n(bytes.begin(), length, stored.begin() + static_cast<std::ptrdiff_t>(at));
      written(block);
      bytes = bytes.subspan(length);
      offset += length;
    }
  }

  void read(std::uint64_t offset, std::span<std::uint8_t> out) const {
    while (!out.empty()) {
      const auto& stored = blocks_[static_cast<std::size_t>(offset / block_bytes_)];
      const auto at = static_cast<std::size_t>(offset % block_bytes_);
      const std::size_t length = std::min(out.size(), block_bytes_ - at);
      if (stored.empty()) {
        std::fill_n(out.begin(), length, std::uint8_t{0});
      } else {
        std::copy_n(stored.begin() + static_cast<std::ptrdiff_t>(at), length, out.begin());
      }
      out = out.subspan(length);
      offset += length;
    }
  }

  // After resize() to the volume that they belong to.
  void state(Archive& archive) {
    std::vector<std::size_t> stored;
    for (std::size_t block = 0; block < count(); ++block) {
      if (is_stored(block)) stored.push_back(block);
    }
    archive.list("stored", stored, count());
    for (const std::size_t block : stored) {
      archive.expect(block < count() && is_stored(block) != archive.loads(), "stored", "each block once", block);
      archive.bytes("block" + std::to_string(block), blocks_[block], block_bytes_, block_bytes_);
    }
    if (archive.loads()) stored_ = stored.size();
  }

 private:
  std::size_t block_bytes_;
  std::size_t stored_ = 0;
  std::vector<std::vector<std::uint8_t>> blocks_;
};

}  // namespace gicube::emu
