#include "shared_blocks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gicube/wire/bytes.h"
#include "volume_parts.h"

namespace gicube {
namespace {

constexpr double kEmpty = 1.0 / 64;  // chosen: cost of a block of zeros, most of which are skipped

}  // namespace

void SharedBlocks::begin(Dims blocks, std::span<const std::uint8_t> stored) {
  blocks_ = blocks;
  cost_.resize(stored.size());
  std::ranges::transform(stored, cost_.begin(), [](std::uint8_t there) { return there != 0 ? 1 : kEmpty; });
  owner_.assign(stored.size(), 0);
  deal();
}

void SharedBlocks::measured(std::uint64_t samples) {
  constexpr double kEnough = 1.1;  // chosen: of the mean; moving blocks costs bus time
  std::vector<std::uint8_t> own(8);
  wire::store(std::span(own), 0, samples);
  std::vector<double> taken(ranks()), expected(ranks());
  const auto all = gather(own);
  for (std::size_t rank = 0; rank < ranks(); ++rank) {
    taken[rank] = static_cast<double>(wire::load<std::uint64_t>(all[rank], 0));
  }
  const double mean = std::accumulate(taken.begin(), taken.end(), 0.0) / static_cast<double>(ranks());
  if (mean == 0 || *std::ranges::max_element(taken) <= kEnough * mean) return;
  for (std::size_t block = 0; block < cost_.size(); ++block) {
    expected[static_cast<std::size_t>(owner_[block])] += cost_[block];
  }
  for (std::size_t block = 0; block < cost_.size(); ++block) {
    const auto rank = static_cast<std::size_t>(owner_[block]);
    // A rank without samples keeps some cost. Otherwise all its blocks would go to one rank.
    if (expected[rank] > 0) cost_[block] *= std::max(taken[rank], mean / 64) / expected[rank];
  }
  deal();
}

void SharedBlocks::deal() {
  const VolumeParts parts(blocks_, cost_, exchange_->ranks());
  for (int rank = 0; rank < exchange_->ranks(); ++rank) {
    parts.for_each_block(rank, [&](std::size_t block) { owner_[block] = rank; });
  }
}

std::vector<wire::WaitingBlock> SharedBlocks::take_others(std::vector<wire::WaitingBlock>& waiting) const {
  const auto others =
      std::stable_partition(waiting.begin(), waiting.end(), [&](const auto& each) { return is_own(each.block); });
  std::vector<wire::WaitingBlock> out(others, waiting.end());
  waiting.erase(others, waiting.end());
  return out;
}

}  // namespace gicube
