// The irradiance of a volume with more blocks than the card stores. The words of a block are on the card or with the
// host: the card has those of blocks for which they were sent, and the host all others.
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

// At which a word saturates.
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
  // False: all its words are 0.
  bool may_have(std::size_t block) const { return store_.has(block) || changed_[block] != 0; }
  // One a block: the host has its words.
  std::vector<std::uint8_t> dark() const;

  // All words are 0: those of the card too.
  void clear();
  // No word is on the card. What only the card had is lost.
  void leave_card();

  // The card has the block's words from now on; before that it has none of them, and they are 0 there.
  void send(Device& device, std::size_t block);
  // The host has them, and they may be dropped from the card.
  void fetch(Device& device, std::size_t block);
  // Rays have left energy in the blocks of the card.
  void deposited();

  // Energy that the words accepted, and that they clipped, in units.
  struct Added {
    std::uint64_t kept = 0, clipped = 0;
  };
  // To words that the host has. Throws std::out_of_range if one is not a word of the volume, or on the card.
  Added add(std::span<const wire::HostDeposit> deposits);

  // n^3 words, from the card if they are there.
  std::vector<std::uint8_t> read(Device& device, std::size_t block);
  // Some of them, from byte `at` on.
  void write(Device& device, std::size_t block, std::size_t at, std::span<const std::uint8_t> bytes);

  // Adds to all words of a block, wherever they are; returns what they clipped, in units.
  std::uint64_t add_words(Device& device, std::size_t block, std::span<const std::uint8_t> more);

  // Throws CheckpointFault.
  void state(Archive& archive);

 private:
  std::vector<std::uint8_t> kept(std::size_t block) const;
  std::uint64_t address(std::size_t block) const;

  std::size_t words_;  // of a block
  std::uint32_t most_;
  BlockStore store_;  // blocks whose words may not all be 0; old of those that have changed on the card
  std::vector<std::uint8_t> on_card_;  // one a block
  std::vector<std::uint8_t> changed_;  // on the card, since they were sent
};

}  // namespace gicube
