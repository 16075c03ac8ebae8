// The volume's memory: 36-bit words as the host wrote them, and each block decoded for the pipeline with its +1 faces:
// a density and a gradient code with a tag per voxel. A sample looks up the gradients of the codes that it needs.
//
// A block that was never written is uniformly zero and takes no memory. The host sends every voxel once; copies on
// shared faces are made here [H1001-H1003]. Blocks that all rays skip are not decoded. The words of a
// decoded block are freed, because they can be restored from its voxels, unless they have irradiance bits, which no
// driver writes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gicube/archive.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/voxel.h"
#include "memory/block_bytes.h"
#include "memory/blocked.h"
#include "memory/large_array.h"
#include "words/words.h"

namespace gicube::emu {

// One block as the pipeline reads it: (n+1)^3 voxels, x fastest.
struct BlockView {
  const std::int16_t* densities = nullptr;     // 12.3
  const std::uint16_t* codes = nullptr;        // gradient codes and tags (words.h); null: all are 0
  const DecodedGradient* gradients = nullptr;  // gradients by code
  const DecodedColour* colours = nullptr;      // null: no voxel has a colour
};

// The part of the volume that a command's rays read.
struct VolumeReads {
  bool colours = false;                     // if the volume has any
  std::span<const std::uint8_t> skipped{};  // one flag per block, nonzero: not read; empty: all blocks are read
};

class VolumeMemory : public Blocked {
 public:
  explicit VolumeMemory(int block_voxels, wire::VoxelFormat format = wire::VoxelFormat::kDensity);

  wire::VoxelFormat format() const { return format_; }

  // Deletes everything; `size` in voxels, all at least 2, or all 0 for no volume.
  void resize(const std::array<int, 3>& size);

  std::size_t block_count() const { return words_.count(); }
  std::uint64_t bytes() const { return words_.bytes(); }  // size of the address range
  std::size_t stored_blocks() const { return words_.stored(); }

  // Host memory: in use, added by writing a range, and an upper bound of what decode() adds while it works.
  std::uint64_t memory_bytes() const {
    return words_.held_bytes() + colours_.held_bytes() + densities_.capacity() * sizeof(std::int16_t) +
           codes_.capacity() * sizeof(std::uint16_t) + decoded_colours_.capacity() * sizeof(DecodedColour);
  }
  std::uint64_t bytes_to_write(std::uint64_t offset, std::uint64_t length) const {
    return words_.bytes_to_write(offset, length);
  }
  std::uint64_t bytes_to_write_colours(std::uint64_t offset, std::uint64_t length) const {
    return colours_.bytes_to_write(offset, length);
  }
  std::uint64_t bytes_to_decode(const VolumeReads& reads) const;
  // Host memory per block, stored or not.
  static constexpr std::uint64_t kBytesOfBlock = 2 * sizeof(std::vector<std::uint8_t>) + 1 + sizeof(std::size_t);

  // Byte ranges of the packed blocks (memory_map.h), offset + length <= bytes(). Reading returns what was written, or
  // 0.
  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const { words_.read(offset, out, packer()); }
  // Byte ranges of the colours. Returns false and writes nothing if the range is invalid or a block's words are not
  // stored.
  bool write_colours(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  void read_colours(std::uint64_t offset, std::span<std::uint8_t> out) const { colours_.read(offset, out, kHere); }
  const BlockBytes& colours() const { return colours_; }
  bool is_stored(std::size_t block) const { return words_.is_stored(block); }
  // A stored block's words; `room`: buffer for words that have to be restored.
  std::span<const std::uint8_t> packed(std::size_t block, std::vector<std::uint8_t>& room) const {
    return words_.bytes_of(block, room, packer());
  }
  std::size_t block_bytes() const { return words_.block_bytes(); }

  // Deletes a block's content.
  void drop(std::size_t block);

  // A bit of a stored block's words, or of its colours, which follow the words.
  struct BitPlace {
    std::size_t block = 0;
    std::size_t bit = 0;
  };
  // Finds bit `bit` of stored block `stored`; both indices wrap around. Returns nothing if no block is stored.
  std::optional<BitPlace> find_bit(std::size_t stored, std::size_t bit) const;
  // Inverts the bit, until it is overwritten.
  void flip(const BitPlace& place);

  // Updates the decoded form of what is read, on `threads` threads. Call before view() when anything was written, the
  // gradient LUT changed, or other things are read.
  void decode(std::span<const wire::GradientEntry> gradients, bool gradients_changed, unsigned threads,
              const VolumeReads& reads = {});
  BlockView view(std::size_t block) const {
    const std::size_t first = first_[block];
    return {densities_.data() + first, codes_.empty() ? nullptr : codes_.data() + first, gradients_.data(),
            decoded_colours_.empty() ? nullptr : decoded_colours_.data() + first};
  }
  // Whether some voxel has a tag other than 0.
  bool has_tags() const { return has_tags_; }

  // All decoded blocks in one array, for readers of many blocks at once: block b's voxels begin at first()[b]. Blocks
  // that were never written or never read share the first slot.
  std::span<const std::int16_t> decoded_densities() const {
    return densities_;
  }                                                                        // one extra: the last is read as a pair, too
  std::span<const std::uint16_t> decoded_codes() const { return codes_; }  // same order; empty: all are 0
  std::span<const DecodedColour> decoded_colours() const { return decoded_colours_; }  // same order; empty: no colours
  std::span<const DecodedGradient> gradients() const { return gradients_; }            // by code
  std::span<const std::size_t> first() const { return first_; }
  // Counts the calls of decode() that changed anything, over all volumes.
  std::uint64_t decodings() const { return decodings_; }
  // Saves or restores size and words. The decoded form is rebuilt.
  void state(Archive& archive);

 private:
  void mark_stale(std::size_t block);
  std::size_t places() const { return densities_.size() - 1; }
  void make_places(std::span<const std::uint8_t> skipped);
  void decode_blocks(std::span<const std::size_t> which, unsigned threads);
  // Decodes the block's own voxels if its words are here, and may free these. Returns the OR of their codes and tags.
  std::uint16_t decode_own(std::size_t block);
  // Copies the neighbours' voxels to the block's +1 faces. Returns the OR of their codes and tags, even if none are
  // stored.
  std::uint16_t decode_faces(std::size_t block);
  // Copies `count` voxels from (0, y, z) of the block at `from`, which may be outside the volume, to the voxels from
  // `at` on.
  std::uint16_t copy_row(const std::array<int, 3>& from, std::size_t y, std::size_t z, std::size_t count,
                         std::size_t at);

  // The `pack` of BlockBytes.
  struct Packer {
    const VolumeMemory* of;
    void operator()(std::size_t block, std::span<std::uint8_t> out) const;
  };
  Packer packer() const { return {this}; }
  static constexpr auto kHere = [](std::size_t, std::span<std::uint8_t>) {};  // colours are never elsewhere

  wire::VoxelFormat format_;
  BlockBytes words_, colours_;
  std::vector<std::uint8_t> stale_;     // one flag per block
  std::vector<std::size_t> free_;       // slots of dropped blocks
  std::vector<std::size_t> first_;      // slot of each block in the following arrays
  LargeArray<std::int16_t> densities_;  // blocks with faces; the first is all zero
  LargeArray<std::uint16_t> codes_;     // empty while all are 0
  bool has_tags_ = false;
  std::vector<DecodedGradient> gradients_;
  LargeArray<DecodedColour> decoded_colours_;  // empty until colours are read
  std::uint64_t decodings_ = 0;
  bool resized_ = false;  // since the last decoding
};

}  // namespace gicube::emu
