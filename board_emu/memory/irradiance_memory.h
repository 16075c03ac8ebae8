// The irradiance words of the volume [P §2.2]: a saturating sum of energy per voxel, with copies on the faces that
// blocks share.
//
// Each block has words for its (n+1)^3 voxels, as in the board's memory. A deposit goes into every block that holds one
// of its voxels: the functional level adds to all of them at once, the cycle level sends irradiance carriers.
// Saturating sums of non-negative terms do not depend on their order. A block that no energy has reached takes no
// memory [H921].
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gicube/archive.h"
#include "gicube/wire/memory_map.h"
#include "memory/blocked.h"
#include "words/words.h"

namespace gicube::emu {

// Energy units of a deposit. Both members count a voxel once, however many copies it has.
struct Deposited {
  std::uint64_t kept = 0;
  std::uint64_t clipped = 0;

  Deposited& operator+=(const Deposited& other) {
    kept += other.kept;
    clipped += other.clipped;
    return *this;
  }
};

// Blocks that hold a voxel of a deposit.
struct SharingBlocks {
  std::size_t count = 0;
  std::array<std::uint32_t, 8> block{};
};

class IrradianceMemory : public Blocked {
 public:
  static constexpr std::uint32_t kPaperMost = (1u << 11) - 1;  // [P §4.2]
  static constexpr std::uint32_t kWideMost = ~std::uint32_t{0};

  // `most`: the value at which words saturate.
  IrradianceMemory(int block_voxels, std::uint32_t most) : Blocked(block_voxels), most_(most) {}

  void resize(const std::array<int, 3>& size);  // voxels; deletes everything
  void clear() { resize(size_); }
  // Sets the words of the block, and their copies, to 0.
  void drop(std::size_t block);

  // Counts the calls that may change words: those above, write(), and expect_deposits(), which announces deposits.
  std::uint64_t changes() const { return changes_; }
  void expect_deposits() { ++changes_; }

  SharingBlocks blocks_of(const Deposit& deposit) const;
  // Adds the shares of those voxels that `block` holds. May be called from several threads.
  Deposited add(const Deposit& deposit, std::uint32_t block);
  // Adds the deposit to every block that holds one of its voxels.
  Deposited add(const Deposit& deposit) {
    const SharingBlocks sharing = blocks_of(deposit);
    Deposited sum;
    for (std::size_t i = 0; i < sharing.count; ++i) sum += add(deposit, sharing.block[i]);
    return sum;
  }

  // (n+1)^3 words, x fastest; null if all are zero.
  const std::uint32_t* view(std::size_t block) const { return words_[block].load(std::memory_order_acquire); }
  std::size_t stored_blocks() const;

  // Host memory of the stored words, and what the words of all other blocks would take; both with the copy of the
  // functional level (functional/simd).
  std::uint64_t stored_bytes() const { return stored_blocks() * bytes_of_words(); }
  std::uint64_t free_bytes() const { return words_.size() * bytes_of_words() - stored_bytes(); }
  // free_bytes() if energy reaches at most `blocks` blocks: their words have copies in up to seven others.
  std::uint64_t free_bytes(std::uint64_t blocks) const { return std::min(8 * blocks * bytes_of_words(), free_bytes()); }
  // Upper bound of the memory that writing `length` bytes adds: a voxel has copies in up to eight blocks.
  std::uint64_t bytes_to_write(std::uint64_t length) const {
    return std::min(8 * (length / block_bytes() + 2) * bytes_of_words(), free_bytes());
  }
  // Host memory per block, stored or not.
  static constexpr std::uint64_t kBytesOfBlock = 2 * sizeof(std::uint32_t*);

  // Byte ranges of the irradiance (memory_map.h): n^3 words per block. `offset` and the length are multiples of four,
  // within bytes(). Writing sets all copies; a word above `most` saturates.
  std::uint64_t bytes() const { return words_.size() * block_bytes(); }
  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const;
  // Saves or restores the words, after resize() to their volume.
  void state(Archive& archive);

 private:
  using Words = std::atomic<std::uint32_t*>;

  std::uint64_t block_bytes() const { return wire::kIrradianceBytes * voxels_of_block(); }
  std::uint64_t bytes_of_words() const { return voxels_and_faces() * (sizeof(std::uint32_t) + sizeof(std::int16_t)); }
  std::uint32_t* storage(std::size_t block);
  std::uint32_t most_;
  std::uint64_t changes_ = 1;
  std::vector<Words> words_;
  std::vector<std::unique_ptr<std::uint32_t[]>> owned_;  // owners of words_
};

}  // namespace gicube::emu
