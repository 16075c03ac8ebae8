// The bytes of a volume's blocks as the host wrote them. A block that was never written is uniformly zero and takes no
// memory.
//
// A stored block may be elsewhere: its owner keeps the content in another form, and `pack(block, out)` restores the
// bytes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gicube/archive.h"
#include "memory/large_array.h"

namespace gicube::emu {

class BlockBytes {
 public:
  explicit BlockBytes(std::size_t block_bytes) : block_bytes_(block_bytes) {}

  void resize(std::size_t blocks) {  // deletes everything
    blocks_.clear();                 // first, because memory may not suffice for both
    blocks_.resize(blocks);
    elsewhere_.assign(blocks, 0);
    stored_ = held_ = 0;
  }

  std::size_t count() const { return blocks_.size(); }
  std::size_t block_bytes() const { return block_bytes_; }
  std::uint64_t bytes() const { return std::uint64_t{count()} * block_bytes_; }  // size of the address range
  std::size_t stored() const { return stored_; }                                 // blocks
  std::uint64_t held_bytes() const { return std::uint64_t{held_} * block_bytes_; }
  bool is_stored(std::size_t block) const { return !blocks_[block].empty() || is_elsewhere(block); }
  bool is_elsewhere(std::size_t block) const { return elsewhere_[block] != 0; }
  std::span<const std::uint8_t> operator[](std::size_t block) const { return blocks_[block]; }  // empty: not here
  std::uint8_t& byte(std::size_t block, std::size_t at) { return blocks_[block][at]; }          // if it is here

  // Bytes of memory that writing this range would add.
  std::uint64_t bytes_to_write(std::uint64_t offset, std::uint64_t length) const {
    if (length == 0 || offset + length > bytes()) return 0;
    std::uint64_t fresh = 0;
    for (std::uint64_t block = offset / block_bytes_; block <= (offset + length - 1) / block_bytes_; ++block) {
      if (blocks_[static_cast<std::size_t>(block)].empty()) ++fresh;
    }
    return fresh * block_bytes_;
  }

  // Moves the block elsewhere. May be called from several threads for different blocks; call count_held() afterwards.
  void release(std::size_t block) {
    ReturnedBytes().swap(blocks_[block]);
    elsewhere_[block] = 1;
  }
  void count_held() {
    held_ =
        static_cast<std::size_t>(std::ranges::count_if(blocks_, [](const auto& stored) { return !stored.empty(); }));
  }
  // Restores the bytes of a block that is elsewhere.
  template <typename Pack>
  void bring_back(std::size_t block, const Pack& pack) {
    if (!is_elsewhere(block)) return;
    blocks_[block].resize(block_bytes_);
    pack(block, std::span(blocks_[block]));
    elsewhere_[block] = 0;
    ++held_;
  }

  // Requires offset + length <= bytes(). Calls `written(block)` for each block.
  template <typename Pack, typename Written>
  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes, const Pack& pack, const Written& written) {
    while (!bytes.empty()) {
      const auto block = static_cast<std::size_t>(offset / block_bytes_);
      const auto at = static_cast<std::size_t>(offset % block_bytes_);
      const std::size_t length = std::min(bytes.size(), block_bytes_ - at);
      bring_back(block, pack);
      auto& stored = blocks_[block];
      if (stored.empty()) {
        stored.resize(block_bytes_);
        ++stored_;
        ++held_;
      }
      std::copy_n(bytes.begin(), length, stored.begin() + static_cast<std::ptrdiff_t>(at));
      written(block);
      bytes = bytes.subspan(length);
      offset += length;
    }
  }

  template <typename Pack>
  void read(std::uint64_t offset, std::span<std::uint8_t> out, const Pack& pack) const {
    std::vector<std::uint8_t> packed;
    while (!out.empty()) {
      const auto block = static_cast<std::size_t>(offset / block_bytes_);
      const auto at = static_cast<std::size_t>(offset % block_bytes_);
      const std::size_t length = std::min(out.size(), block_bytes_ - at);
      if (is_stored(block)) {
        const auto from = bytes_of(block, packed, pack).subspan(at, length);
        std::copy(from.begin(), from.end(), out.begin());
      } else {
        std::fill_n(out.begin(), length, std::uint8_t{0});
      }
      out = out.subspan(length);
      offset += length;
    }
  }
  // Makes the block one that was never written.
  void drop(std::size_t block) {
    if (!is_stored(block)) return;
    held_ -= is_elsewhere(block) ? 0 : 1;
    --stored_;
    ReturnedBytes().swap(blocks_[block]);
    elsewhere_[block] = 0;
  }

  // The bytes of a stored block. `room`: buffer for bytes that have to be packed.
  template <typename Pack>
  std::span<const std::uint8_t> bytes_of(std::size_t block, std::vector<std::uint8_t>& room, const Pack& pack) const {
    if (!is_elsewhere(block)) return blocks_[block];
    room.resize(block_bytes_);
    pack(block, std::span(room));
    return room;
  }

  // Saves or restores the blocks, after resize() to their volume.
  template <typename Pack>
  void state(Archive& archive, const Pack& pack) {
    std::vector<std::size_t> stored;
    for (std::size_t block = 0; block < count(); ++block) {
      if (is_stored(block)) stored.push_back(block);
    }
    archive.list("stored", stored, count());
    std::vector<std::uint8_t> room, packed;
    for (const std::size_t block : stored) {
      archive.expect(block < count() && is_stored(block) != archive.loads(), "stored", "each block once", block);
      if (!archive.loads()) {
        const auto bytes = bytes_of(block, packed, pack);
        room.assign(bytes.begin(), bytes.end());
      }
      archive.bytes("block" + std::to_string(block), room, block_bytes_, block_bytes_);
      if (archive.loads()) blocks_[block].assign(room.begin(), room.end());
    }
    if (archive.loads()) stored_ = held_ = stored.size();
  }

 private:
  std::size_t block_bytes_;
  std::size_t stored_ = 0;
  std::size_t held_ = 0;  // stored blocks that are here
  std::vector<ReturnedBytes> blocks_;
  std::vector<std::uint8_t> elsewhere_;  // one flag per block
};

}  // namespace gicube::emu
