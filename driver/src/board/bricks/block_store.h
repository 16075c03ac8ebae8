// Stores the words of a volume's blocks, in memory or in a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gicube/archive.h"
#include "scratch_file.h"

namespace gicube {

class BlockStore {
 public:
  // kFile: in a ScratchFile, whose Errors are thrown.
  enum class Place { kMemory, kFile };
  BlockStore(std::size_t blocks, std::size_t block_bytes, Place place);

  std::size_t count() const { return places_.size(); }
  bool has(std::size_t block) const { return places_[block] >= 0; }
  // Adds a block that is not stored yet. Throws Error: the file can't be written.
  void add(std::size_t block, std::span<const std::uint8_t> bytes);
  // Replaces the stored block, if there is one.
  void put(std::size_t block, std::span<const std::uint8_t> bytes);
  // Forgets all blocks.
  void clear();
  // Resizes `out`. Throws Error: the file can't be read.
  void read(std::size_t block, std::vector<std::uint8_t>& out) const;

  // Lists the stored blocks; loads them into an empty store. Throws CheckpointFault, and as add() and read().
  void state(Archive& archive);

 private:
  std::size_t block_bytes_;
  void write(std::int64_t place, std::span<const std::uint8_t> bytes);

  std::vector<std::int64_t> places_;  // of each block, in blocks; -1: not stored
  std::int64_t next_ = 0;
  std::vector<std::vector<std::uint8_t>> memory_;  // by place
  std::optional<ScratchFile> file_;
};

}  // namespace gicube
