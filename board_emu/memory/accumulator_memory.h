// Accumulators of backprojecting rays: one signed word per voxel, of 36 bits on the board (command.h).
//
// Each word belongs to one block; nothing samples the accumulators, so shared faces have no copies. The functional
// level nevertheless gives each block (n+1)^3 words: contributions to voxels beyond a block's far faces stay there as
// partial sums of the neighbour's words, so that threads can work on blocks side by side without locks. Integer sums do
// not depend on their order; a word's value is the total of its partial sums. A block that no ray has reached takes no
// memory.
//
// Contributions may be queued, because adding those of many commands together costs less. They are added before words
// are read [H1004, H1005].
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

// Words that settle() clipped.
struct Overflow {
  std::uint64_t words = 0;
  std::int64_t clipped = 0;  // signed sum of the clipped excess
};

class AccumulatorMemory;

// Queue of contributions to the words.
class WaitingAdds {
 public:
  WaitingAdds() = default;
  WaitingAdds(const WaitingAdds&) = delete;
  WaitingAdds& operator=(const WaitingAdds&) = delete;
  virtual ~WaitingAdds() = default;
  virtual void add_to(AccumulatorMemory& accumulators) = 0;  // empties the queue
  virtual void forget() = 0;
};

class AccumulatorMemory : public Blocked {
 public:
  explicit AccumulatorMemory(int block_voxels) : Blocked(block_voxels) {}

  void resize(const std::array<int, 3>& size);  // voxels; deletes everything
  // Frees the words: which blocks have some would depend on what has been queued, and checkpoints must not.
  void clear() { resize(size_); }
  std::size_t block_count() const { return blocks_words_.size(); }

  // The blocks that own words of the deposit's shares.
  SharingBlocks blocks_of(const Deposit& deposit) const;
  // Adds the shares, as signed numbers, whose words belong to `block`. Returns their sum.
  std::int64_t add(const Deposit& deposit, std::uint32_t block);

  // A block's (n+1)^3 words, x fastest, without queued contributions. Creates them if there are none.
  std::int64_t* storage(std::size_t block);
  // The queue of contributions; null if there is none.
  std::unique_ptr<WaitingAdds>& waiting() { return waiting_; }

  // Raises the bounds: words of storage() may have changed by that much, or will when queued contributions are added.
  void moved(std::size_t block, std::uint64_t by) { bounds_[block] += by; }
  void moved_anywhere(std::uint64_t by) {
    for (std::uint64_t& bound : bounds_) bound += by;
  }
  // To be called after a command: clips words beyond +-kMaxSum. Reads the words only if one of them can be.
  Overflow settle();

  // Byte ranges of the accumulators (memory_map.h). `offset` and the length are multiples of nine, two words, within
  // bytes().
  std::uint64_t bytes() const { return blocks_words_.size() * block_bytes(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out);

  std::size_t stored_blocks() const;
  // Saves or restores the words, after resize() to their volume.
  void state(Archive& archive);

  // Host memory, like IrradianceMemory's: of the words, and as many bytes for the queue.
  std::uint64_t stored_bytes() const { return 2 * stored_blocks() * bytes_of_words(); }
  std::uint64_t free_bytes() const { return 2 * max_waiting_bytes() - stored_bytes(); }
  static constexpr std::uint64_t kBytesOfBlock = sizeof(std::int64_t*) + sizeof(std::uint64_t);
  // Limit of the queue: beyond it, the queue would take more memory than the words.
  std::uint64_t max_waiting_bytes() const { return blocks_words_.size() * bytes_of_words(); }

 private:
  std::uint64_t block_bytes() const { return voxels_of_block() * 9 / 2; }
  std::uint64_t bytes_of_words() const { return voxels_and_faces() * sizeof(std::int64_t); }
  void finish();  // adds queued contributions
  void read_row(std::size_t block, int y, int z, std::span<std::int64_t> row) const;
  void gather_parts();
  bool can_overflow() const;

  using Words = std::unique_ptr<std::int64_t[]>;
  std::vector<Words> blocks_words_;
  std::vector<std::uint64_t> bounds_;  // largest magnitude of a block's words, with queued contributions
  std::unique_ptr<WaitingAdds> waiting_;
};

}  // namespace gicube::emu
