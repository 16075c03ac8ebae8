// The sums of backprojecting rays: signed words, one a voxel, of 36 bits on the board (command.h).
//
// Each word belongs to one block; nothing samples the sums, so there are no copies on shared faces. The functional level
// gives each block (n+1)^3 words all the same: what a block's samples leave in the voxels beyond its far faces stays there
// as a part of the neighbour's word, so that blocks can be worked on side by side without locks. Sums of integers don't
// depend on their order, and a word's value is that of its parts together. A block that no ray has reached takes no memory.
//
// What rays leave may wait to be added, since that costs less for many commands together: whoever looks at words has it done first.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gicube/archive.h"
#include "gicube/wire/command.h"
#include "memory/blocked.h"
#include "memory/irradiance_memory.h"
#include "words/words.h"

namespace gicube::emu {

// What settling clipped.
struct Overflow {
  std::uint64_t words = 0;
  std::int64_t clipped = 0;  // signed, as what was lost
};

class SumMemory;

// What waits to be added to the words.
class WaitingAdds {
 public:
  WaitingAdds() = default;
  WaitingAdds(const WaitingAdds&) = delete;
  WaitingAdds& operator=(const WaitingAdds&) = delete;
  virtual ~WaitingAdds() = default;
  virtual void add_to(SumMemory& sums) = 0;  // nothing waits afterwards
  virtual void forget() = 0;
};

class SumMemory : public Blocked {
 public:
  explicit SumMemory(int block_voxels) : Blocked(block_voxels) {}

  void resize(const std::array<int, 3>& size);  // voxels; forgets everything
  // Blocks keep no memory: which had words would depend on what has waited, and a board's checkpoint may not.
  void clear() { resize(size_); }
  std::size_t block_count() const { return blocks_words_.size(); }

  // The blocks that words of the deposit's shares belong to.
  SharingBlocks blocks_of(const Deposit& deposit) const;
  // Adds the shares, read as signed, whose words belong to `block`, and returns their sum.
  std::int64_t add(const Deposit& deposit, std::uint32_t block);

  // A block's (n+1)^3 words, x fastest; makes them if there are none.
  std::int64_t* storage(std::size_t block);
  // Who adds later, if anyone does; the words of storage() are without what waits.
  std::unique_ptr<WaitingAdds>& waiting() { return waiting_; }

  // The words of a block's storage() can have moved by so much more, or will by what waits.
  void moved(std::size_t block, std::uint64_t by) { bounds_[block] += by; }
  void moved_anywhere(std::uint64_t by) {
    for (std::uint64_t& bound : bounds_) bound += by;
  }
  // After a command: clips what is beyond +-kMaxSum. Looks at the words only when one of them can be.
  Overflow settle();

  // Bytes of the address range (memory_map.h). `offset` and the length are multiples of nine, two words, within bytes().
  std::uint64_t bytes() const { return blocks_words_.size() * block_bytes(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out);

  std::size_t stored_blocks() const;
  // As that of irradiance.
  void state(Archive& archive);

  // Memory of the host's, as IrradianceMemory's: of words, and of as many bytes that wait.
  std::uint64_t stored_bytes() const { return 2 * stored_blocks() * bytes_of_words(); }
  std::uint64_t free_bytes() const { return 2 * max_waiting_bytes() - stored_bytes(); }
  static constexpr std::uint64_t kBytesOfBlock = sizeof(std::int64_t*) + sizeof(std::uint64_t);
  // More should not wait: it would take more than the words do.
  std::uint64_t max_waiting_bytes() const { return blocks_words_.size() * bytes_of_words(); }

 private:
  std::uint64_t block_bytes() const { return voxels_of_block() * 9 / 2; }
  std::uint64_t bytes_of_words() const { return voxels_and_faces() * sizeof(std::int64_t); }
  void finish();  // has what waits added
  void read_row(std::size_t block, int y, int z, std::span<std::int64_t> row) const;
  void gather_parts();
  bool can_overflow() const;

  using Words = std::unique_ptr<std::int64_t[]>;
  std::vector<Words> blocks_words_;
  std::vector<std::uint64_t> bounds_;  // no word of the block's storage with what waits is larger
  std::unique_ptr<WaitingAdds> waiting_;
};

}  // namespace gicube::emu
