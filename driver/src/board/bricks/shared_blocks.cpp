#include "shared_blocks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gicube/wire/bytes.h"

namespace gicube {
namespace {

constexpr double kEmpty = 1.0 / 64;  // chosen: rays leap over most blocks of zeros

template <typename Use>
void for_each_block(const std::array<int, 3>& begin, const std::array<int, 3>& end, const Dims& blocks,
                    const Use& use) {
  for (int z = begin[2]; z < end[2]; ++z) {
    for (int y = begin[1]; y < end[1]; ++y) {
      for (int x = begin[0]; x < end[0]; ++x) use(static_cast<std::size_t>(x + blocks[0] * (y + blocks[1] * z)));
    }
  }
}

}  // namespace

void SharedBlocks::begin(Dims blocks, std::span<const std::uint8_t> stored) {
  blocks_ = blocks;
  cost_.resize(stored.size());
  std::ranges::transform(stored, cost_.begin(), [](std::uint8_t there) { return there != 0 ? 1 : kEmpty; });
  owner_.assign(stored.size(), 0);
  deal();
}

void SharedBlocks::measured(std::uint64_t samples) {
  constexpr double kEnough = 1.1;  // chosen: moving blocks costs bus time
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
    // One that had nothing to do still counts, or its blocks would go to one rank when rays come to them.
    if (expected[rank] > 0) cost_[block] *= std::max(taken[rank], mean / 64) / expected[rank];
  }
  deal();
}

void SharedBlocks::deal() { deal({{0, 0, 0}, {blocks_[0], blocks_[1], blocks_[2]}}, 0, ranks()); }

double SharedBlocks::cost(const Box& box) const {
  double sum = 0;
  for_each_block(box.begin, box.end, blocks_, [&](std::size_t block) { sum += cost_[block]; });
  return sum;
}

// To ranks first .. first + count - 1: halves the box across its longest edge where both halves cost as much for each of their ranks.
void SharedBlocks::deal(const Box& box, std::size_t first, std::size_t count) {
  const auto edge = [&box](std::size_t axis) { return box.end[axis] - box.begin[axis]; };
  std::size_t axis = 0;
  for (const std::size_t other : {1, 2}) axis = edge(other) > edge(axis) ? other : axis;
  if (count == 1 || edge(axis) < 2) {
    for_each_block(box.begin, box.end, blocks_, [&](std::size_t block) { owner_[block] = static_cast<int>(first); });
    return;
  }
  const std::size_t low_count = count / 2;
  const double wanted = cost(box) * static_cast<double>(low_count) / static_cast<double>(count);
  Box low = box, high = box, layer = box;
  double so_far = 0;
  int at = box.begin[axis];
  for (; at + 1 < box.end[axis]; ++at) {
    layer.begin[axis] = at, layer.end[axis] = at + 1;
    const double more = cost(layer);
    if (at > box.begin[axis] && so_far + more / 2 > wanted) break;
    so_far += more;
  }
  low.end[axis] = high.begin[axis] = at;
  deal(low, first, low_count);
  deal(high, first + low_count, count - low_count);
}

std::vector<wire::WaitingBlock> SharedBlocks::take_others(std::vector<wire::WaitingBlock>& waiting) const {
  const auto others =
      std::stable_partition(waiting.begin(), waiting.end(), [&](const auto& each) { return is_own(each.block); });
  std::vector<wire::WaitingBlock> out(others, waiting.end());
  waiting.erase(others, waiting.end());
  return out;
}

}  // namespace gicube
