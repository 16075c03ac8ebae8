// A volume with more blocks than the card stores. The host keeps all blocks. While rays are traced, the blocks that
// they wait for are sent to the card, where they replace the least recently needed ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "block_store.h"
#include "board/device.h"
#include "brick_light.h"
#include "encode/volume/gradients.h"
#include "gicube/vector.h"
#include "gicube/wire/coarse_block.h"
#include "gicube/wire/voxel.h"

namespace gicube {

// Sizes of a block of n^3 voxels as VoxelBlocks::pack() makes it: its words, followed by their colours if the volume
// has any.
constexpr std::size_t bytes_of_words(std::size_t n) { return wire::packed36_bytes(n * n * n); }
constexpr std::size_t bytes_of_block(std::size_t n, bool coloured) {
  return bytes_of_words(n) + (coloured ? wire::kColourBytes * n * n * n : 0);
}
void write_packed_block(Device& device, std::size_t block, std::size_t n, std::span<const std::uint8_t> packed);

// How rays use the irradiance of the blocks in which they take samples: not at all, read it, or deposit into it.
enum class LightUse { kNone, kSeen, kLeft };

struct BrickNeeds {
  LightUse light = LightUse::kNone;
  std::span<const std::uint8_t>
      leapt_over{};  // flags, one per block, or none: blocks that are not sent for samples in them
  std::span<const std::uint8_t>
      levels{};  // of detail, one per block, which is sent in cells of 2^level voxels; or none

  int level(std::size_t block) const { return levels.empty() ? 0 : levels[block]; }
};

class Bricks {
 public:
  // A volume of `blocks` blocks in x, y and z, of n^3 voxels. `store` has those that are not zero, their +1 faces
  // included. `capacity`: blocks that the card stores, at least 8.
  Bricks(Dims blocks, int n, BlockStore store, BrickLight light, std::size_t capacity)
      : blocks_(blocks), n_(n), capacity_(capacity), store_(std::move(store)), light_(std::move(light)) {}

  Dims blocks() const { return blocks_; }
  std::size_t count() const { return store_.count(); }
  int block_voxels() const { return n_; }
  bool has_voxels(std::size_t block) const { return store_.has(block); }  // false: all voxels are zero
  std::size_t capacity() const { return capacity_; }                      // of the card, blocks
  BrickLight& light() { return light_; }

  // Has the card drop all blocks. It must know the volume's size, and have no irradiance of it.
  void begin(Device& device);
  // Whether rays must wait for the block, by the last load() or prepare().
  bool is_absent(std::size_t block) const { return (absent_[block / 8] >> block % 8 & 1) != 0; }
  // To be called before each command: tells the card which blocks are absent for rays with these needs.
  void prepare(Device& device, const BrickNeeds& needs);
  // Sends blocks in which rays wait to take samples, most important first, as many as there is room for, at least one.
  // Other blocks stay on the card as long as there is room. It may be called again after any exception.
  void load(Device& device, std::span<const std::size_t> wanted, const BrickNeeds& needs);

  // Orders the blocks that rays wait for, for load(), as many as the card has room for: by the sum of what their rays
  // can still contribute, divided by the number of blocks to send. It is the sorter's measure of a queue [P §5.3].
  std::vector<std::size_t> by_importance(std::span<const wire::WaitingBlock> waiting, LightUse light) const;

  // The number of blocks that the card has, by level, and the largest error of a voxel's density, since clear_detail().
  struct Detail {
    std::array<std::size_t, wire::kMaxCoarseLevel + 1> blocks{};
    int largest_error = 0;
  };
  Detail detail() const;
  void clear_detail(const BrickNeeds& needs);
  // Sets what send() needs for coarse blocks. `dims`: of the volume, voxels. The codebook must outlive this object.
  void set_cells(const Dims& dims, bool coloured, const GradientCodebook* codebook) {
    dims_ = dims, coloured_ = coloured, codebook_ = codebook;
  }

  // The n^3 packed words of a block.
  std::vector<std::uint8_t> read(std::size_t block) const;

  // Lists everything but the number of blocks, their edge and the capacity. Throws CheckpointFault.
  void state(Archive& archive);

 private:
  // The blocks for one load().
  struct Choice {
    std::vector<std::uint8_t> chosen, voxels,
        light;                        // one per block: it gets a slot, and needs its words and its irradiance
    std::vector<std::size_t> blocks;  // chosen ones, in order
  };
  template <typename Use>
  void for_each_need(std::size_t block, LightUse light, const Use& use) const;
  Choice choose(std::span<const std::size_t> wanted, const BrickNeeds& needs) const;
  void make_room(Device& device, const Choice& choice);
  void drop(Device& device, std::size_t block);
  bool can_be_sampled(std::size_t block, const BrickNeeds& needs) const;
  bool has_words(std::size_t block, const BrickNeeds& needs) const { return on_card_[block] == 1 + needs.level(block); }
  void send(Device& device, std::size_t block, int level, std::vector<std::uint32_t>& commands);

  Dims blocks_;
  int n_;
  std::size_t capacity_;
  BlockStore store_;
  BrickLight light_;
  std::vector<std::uint8_t> has_place_;                        // one flag per block: it occupies a slot of the card
  std::vector<std::uint8_t> on_card_;                          // 1 + the level of its words there; 0: none
  std::vector<std::uint16_t> error_;                           // largest error of densities there, if coarse
  int largest_error_ = 0;                                      // of detail()
  std::array<std::size_t, wire::kMaxCoarseLevel + 1> sent_{};  // by level, of detail()
  Dims dims_{};                                                // voxels
  const GradientCodebook* codebook_ = nullptr;
  bool coloured_ = false;
  std::vector<std::uint32_t> needed_in_;  // number of the latest load() that needed it
  std::uint32_t loads_ = 0;
  std::vector<std::uint8_t> absent_, dark_;  // packed flags as last sent; empty: unknown
};

// From the completion of a command in bricks: the blocks that rays wait for, and how many deposits the host must make.
struct Waiting {
  std::vector<wire::WaitingBlock> blocks;
  std::uint32_t host_deposits = 0;
};
// Throws std::out_of_range if the payload has a wrong size or names a block beyond `blocks`.
Waiting decode_waiting(std::span<const std::uint8_t> payload, std::size_t blocks);

}  // namespace gicube
