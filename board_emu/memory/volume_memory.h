// The volume's memory: 36-bit words as the host wrote them, and each block decoded with its +1 faces for the pipeline.
//
// A block that was never written is uniformly zero and takes no memory. Copies on shared faces are made here: the host
// sends every voxel once (docs/HARDWARE.md).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "flow.h"
#include "gicube/wire/lut.h"

namespace gicube::emu {

// One block as the pipeline reads it: (n+1)^3 voxels, x fastest.
struct BlockView {
  const DecodedVoxel* voxels = nullptr;
  const std::uint8_t* tags = nullptr;  // null: tag 0 everywhere
};

class VolumeMemory {
 public:
  explicit VolumeMemory(int block_voxels);

  // Forgets everything; `size` in voxels, all at least 2, or all 0 for no volume.
  void resize(const std::array<int, 3>& size);

  const std::array<int, 3>& size() const { return size_; }
  const std::array<int, 3>& blocks() const { return blocks_; }
  std::size_t block_count() const { return packed_.size(); }
  int block_voxels() const { return n_; }
  std::uint64_t bytes() const { return block_count() * block_bytes_; }  // of the address range
  std::size_t stored_blocks() const;

  // Byte ranges of the packed blocks (memory_map.h), offset + length <= bytes(). Reading gives what was written, or 0.
  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const;
  // A block's words; empty if it was never written.
  std::span<const std::uint8_t> packed(std::size_t block) const { return packed_[block]; }
  std::size_t block_bytes() const { return block_bytes_; }

  // A bit of a stored block's words.
  struct BitPlace {
    std::size_t block = 0;
    std::size_t bit = 0;
  };
  // Bit `bit` of the `stored`-th of the blocks that are stored; both count round. Nothing if none is.
  std::optional<BitPlace> find_bit(std::size_t stored, std::size_t bit) const;
  // It reads wrong from now on, until it is written.
  void flip(const BitPlace& place);

  // Makes every block's decoded form current, on `threads` threads. Call before view() when anything was written or the
  // gradient LUT changed.
  void decode(std::span<const wire::GradientEntry> gradients, bool gradients_changed, unsigned threads);
  // Counts the calls of decode() that changed anything, over all volumes.
  std::uint64_t decodings() const { return decodings_; }
  bool is_stored(std::size_t block) const { return !decoded_[block].voxels.empty(); }
  BlockView view(std::size_t block) const {
    const Decoded& decoded = decoded_[block];
    return {decoded.voxels.empty() ? zero_.data() : decoded.voxels.data(),
            decoded.tags.empty() ? nullptr : decoded.tags.data()};
  }

 private:
  struct Decoded {
    std::vector<DecodedVoxel> voxels;
    std::vector<std::uint8_t> tags;  // empty while every tag is 0
    bool stale = false;
  };

  std::size_t block_index(int bx, int by, int bz) const;
  void mark_stale(std::size_t block);
  void decode_block(std::size_t block, std::span<const DecodedVoxel> codes);

  int n_;
  std::size_t block_bytes_;
  std::array<int, 3> size_{};
  std::array<int, 3> blocks_{};
  std::vector<std::vector<std::uint8_t>> packed_;  // empty: never written
  std::vector<Decoded> decoded_;
  std::uint64_t decodings_ = 0;
  bool resized_ = false;  // since then
  std::vector<DecodedVoxel> zero_;  // what every block without storage shows
};

}  // namespace gicube::emu
