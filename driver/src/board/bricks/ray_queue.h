// Rays that wait in the host's memory for blocks of a volume in bricks, because the card has its limit of waiting rays:
// one queue per block, in memory, and beyond a limit in a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "gicube/wire/command.h"
#include "scratch_file.h"

namespace gicube {

class RayQueue {
 public:
  // Keeps at most `max_in_memory` rays in memory.
  explicit RayQueue(std::size_t max_in_memory) : max_in_memory_(max_in_memory) {}

  bool empty() const { return blocks_.empty(); }
  // All blocks that queued rays wait for.
  std::vector<wire::WaitingBlock> by_block() const;
  bool has(std::uint32_t block) const { return blocks_.contains(block); }

  // Adds records of ForwardedRays for a block. `importance`: the sum of their contributions. Throws Error: the file
  // can't be written.
  void add(std::uint32_t block, std::uint64_t importance, std::span<const std::uint8_t> records);
  // Removes at most `most` rays for a block and returns their records. Throws Error: the file can't be read.
  std::vector<std::uint8_t> take(std::uint32_t block, std::size_t most);
  void clear();

 private:
  struct Piece {
    std::uint64_t at = 0;  // of the file, bytes
    std::size_t bytes = 0;
  };
  struct Rays {
    std::size_t count = 0;
    std::uint64_t importance = 0;
    std::vector<std::uint8_t> in_memory;
    std::vector<Piece> in_file;
  };
  void write_largest();

  std::size_t max_in_memory_;
  std::size_t bytes_in_memory_ = 0;
  std::map<std::uint32_t, Rays> blocks_;
  std::optional<ScratchFile> file_;
  std::uint64_t file_end_ = 0;
  std::size_t pieces_ = 0;  // in the file; if there is none, it is written from its begin again
};

}  // namespace gicube
