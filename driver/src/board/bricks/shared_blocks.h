// Assigns each block of a volume to the rank of a job that traces the rays in it.
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

  // Deals the blocks of a new volume; all stored blocks are taken to cost the same.
  void begin(Dims blocks, std::span<const std::uint8_t> stored);
  // `samples`: taken by this rank since the last call. Deals the blocks again if one rank took many more than the
  // others. Collective.
  void measured(std::uint64_t samples);

  int owner(std::size_t block) const { return owner_[block]; }
  bool is_own(std::size_t block) const { return owner_[block] == rank(); }
  // Removes the blocks of other ranks from the list and returns them.
  std::vector<wire::WaitingBlock> take_others(std::vector<wire::WaitingBlock>& waiting) const;

  // Collective. The bytes of each rank, by rank.
  std::vector<std::vector<std::uint8_t>> gather(const std::vector<std::uint8_t>& own) {
    return exchange_->exchange(std::vector(ranks(), own));
  }

 private:
  void deal();

  std::shared_ptr<RayExchange> exchange_;
  Dims blocks_{};
  std::vector<double> cost_;  // relative cost of the rays in each block
  std::vector<int> owner_;
};

}  // namespace gicube
