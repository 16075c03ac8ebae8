// The irradiance of a volume with more blocks than the card stores. The words of a block are valid either on the card,
// after send(), or in the host's memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "block_store.h"
#include "board/device.h"
#include "gicube/wire/command.h"
#include "gicube/wire/memory_map.h"

namespace gicube {

// The value at which an irradiance word saturates.
inline std::uint32_t max_irradiance(const BoardInfo& info) { return info.wide ? ~std::uint32_t{0} : 2047; }

class BrickLight {
 public:
  // Holds the irradiance of `blocks` blocks of n^3 voxels, whose words saturate at `most`; `place`: where the host
  // keeps it.
  BrickLight(std::size_t blocks, int n, std::uint32_t most, BlockStore::Place place)
      : words_(static_cast<std::size_t>(n) * n * n),
        most_(most),
        store_(blocks, 4 * words_, place),
        on_card_(blocks),
        changed_(blocks) {}

  std::size_t bytes_of_block() const { return words_ * wire::kIrradianceBytes; }
  bool on_card(std::size_t block) const { return on_card_[block] != 0; }
  // False: all words of the block are 0.
  bool may_have(std::size_t block) const { return store_.has(block) || changed_[block] != 0; }
  // One flag per block: 1 if the host has its words.
  std::vector<std::uint8_t> dark() const;

  // Sets all words to 0; those on the card must have been cleared too.
  void clear();
  // Marks all blocks as not on the card. Words that only the card had are lost.
  void leave_card();

  // Sends the block's words to the card. Before, they must be 0 there.
  void send(Device& device, std::size_t block);
  // Reads the block's words back, so that the card may drop them.
  void fetch(Device& device, std::size_t block);
  // To be called after rays have deposited energy: the words of all blocks on the card may have changed.
  void deposited();

  // Energy that the words accepted, and that they clipped, in units.
  struct Added {
    std::uint64_t kept = 0, clipped = 0;
  };
  // Adds deposits to words that the host has. Throws std::out_of_range for a word outside of the volume or on the card.
  Added add(std::span<const wire::HostDeposit> deposits);

  // The n^3 words of a block, from the card if they are there.
  std::vector<std::uint8_t> read(Device& device, std::size_t block);
  // Writes some words of a block, from byte `at` on.
  void write(Device& device, std::size_t block, std::size_t at, std::span<const std::uint8_t> bytes);

  // Adds to all words of a block, on the card or here; returns the units that were clipped.
  std::uint64_t add_words(Device& device, std::size_t block, std::span<const std::uint8_t> more);

  // Throws CheckpointFault.
  void state(Archive& archive);

 private:
  std::vector<std::uint8_t> kept(std::size_t block) const;
  std::uint64_t address(std::size_t block) const;

  std::size_t words_;  // of a block
  std::uint32_t most_;
  BlockStore store_;                   // blocks whose words may differ from 0; outdated if changed_
  std::vector<std::uint8_t> on_card_;  // one per block
  std::vector<std::uint8_t> changed_;  // on the card since send()
};

}  // namespace gicube
