// A volume with more blocks than the card stores. The host keeps them; while a picture is rendered, the blocks that its rays
// wait for are sent to the card front to back, as many as it stores at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "block_store.h"
#include "device.h"
#include "encode/volume/block_order.h"
#include "gicube/vector.h"
#include "gicube/wire/voxel.h"

namespace gicube {

// A block of n^3 voxels as VoxelBlocks::pack() makes it: its words, and their colours behind them if the volume has some.
constexpr std::size_t bytes_of_words(std::size_t n) { return wire::packed36_bytes(n * n * n); }
constexpr std::size_t bytes_of_block(std::size_t n, bool coloured) {
  return bytes_of_words(n) + (coloured ? wire::kColourBytes * n * n * n : 0);
}
void write_packed_block(Device& device, std::size_t block, std::size_t n, std::span<const std::uint8_t> packed);

class Bricks {
 public:
  // Of so many blocks in x, y and z, of n^3 voxels; `store` has those that are not zero with their faces. `capacity`: blocks that the
  // card stores, at least 8.
  Bricks(Dims blocks, int n, BlockStore store, std::size_t capacity)
      : blocks_(blocks), n_(n), capacity_(capacity), store_(std::move(store)) {}

  Dims blocks() const { return blocks_; }
  std::size_t count() const { return store_.count(); }
  int block_voxels() const { return n_; }
  std::size_t capacity() const { return capacity_; }  // of the card, blocks

  // The card, which knows the volume's size, forgets all blocks.
  void begin(Device& device);
  // To be called before each picture: if a call of load() has thrown, what the card has is unknown, and it begins again.
  void recover(Device& device) {
    if (unsure_) begin(device);
  }
  // Sends blocks so that rays go on which wait for `waiting`, of the nearest at least. Blocks that are on the card stay there if
  // there is room, else they are replaced. `leapt_over`: flags, one a block, or none: those that rays leap over are not sent
  // for their own sake.
  void load(Device& device, const BlockOrder& order, std::span<const wire::WaitingBlock> waiting,
            std::span<const std::uint8_t> leapt_over);

  // All but the blocks' number, the edge and the capacity. Throws CheckpointFault.
  void state(Archive& archive);

 private:
  void forget_blocks();

  Dims blocks_;
  int n_;
  std::size_t capacity_;
  BlockStore store_;
  std::vector<std::uint8_t> on_card_;  // one a block: its words are there
  std::size_t count_on_card_ = 0;
  bool unsure_ = false;               // the card may have other blocks and flags than the members say
  std::vector<std::uint8_t> absent_;  // one a block: samples in it can't be taken
};

// The blocks that rays wait for, of the completion of a render or continue command; throws std::out_of_range if it is of wrong size,
// or names a block beyond `blocks`.
std::vector<wire::WaitingBlock> decode_waiting(std::span<const std::uint8_t> payload, std::size_t blocks);

}  // namespace gicube
