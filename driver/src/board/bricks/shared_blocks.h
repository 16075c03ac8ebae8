// Which rank of a job traces the rays in which blocks of a volume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gicube/ray_exchange.h"
#include "gicube/vector.h"
#include "gicube/volume.h"
#include "gicube/wire/command.h"

namespace gicube {

class SharedBlocks {
 public:
  explicit SharedBlocks(std::shared_ptr<RayExchange> exchange) : exchange_(std::move(exchange)) {}

  RayExchange& exchange() { return *exchange_; }
  int rank() const { return exchange_->rank(); }
  std::size_t ranks() const { return static_cast<std::size_t>(exchange_->ranks()); }

  // Deals the blocks of a new volume, whose rays cost as much in each stored block.
  void begin(Dims blocks, std::span<const std::uint8_t> stored);
  // A call has taken this rank so many samples since the last one. Deals the blocks anew if one rank had much more than
  // the others.
  void measured(std::uint64_t samples);

  int owner(std::size_t block) const { return owner_[block]; }
  bool is_own(std::size_t block) const { return owner_[block] == rank(); }
  // Takes the blocks of other ranks out, and returns them.
  std::vector<wire::WaitingBlock> take_others(std::vector<wire::WaitingBlock>& waiting) const;

  // Collective. What each rank has, by rank.
  std::vector<std::vector<std::uint8_t>> gather(const std::vector<std::uint8_t>& own) {
    return exchange_->exchange(std::vector(ranks(), own));
  }

 private:
  void deal();

  std::shared_ptr<RayExchange> exchange_;
  Dims blocks_{};
  std::vector<double> cost_;  // of the rays in each block, in proportion
  std::vector<int> owner_;
};

}  // namespace gicube
