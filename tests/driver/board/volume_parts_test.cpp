// The boxes of blocks that ranks are dealt.
#include "board/bricks/volume_parts.h"

#include "test.h"

namespace gicube::reference {
namespace {

TEST(VolumeParts, AreEachBlockOnceAndCostTheSame) {
  std::mt19937 random(3);
  for (const int ranks : {1, 2, 3, 5, 8, 16}) {
    const Dims blocks{12, 9, 10};
    std::vector<double> costs(12 * 9 * 10);
    for (double& cost : costs) cost = std::uniform_real_distribution(0.5, 1.5)(random);
    const VolumeParts parts(blocks, costs, ranks);
    std::vector<int> owners(costs.size());
    for (int rank = 0; rank < ranks; ++rank) {
      double cost = 0;
      parts.for_each_block(rank, [&](std::size_t block) {
        ++owners[block];
        cost += costs[block];
      });
      EXPECT_NEAR(cost * ranks / std::accumulate(costs.begin(), costs.end(), 0.0), 1, 0.35) << rank << " of " << ranks;
    }
    EXPECT_EQ(std::ranges::count(owners, 1), static_cast<std::ptrdiff_t>(owners.size()));
  }
  const VolumeParts few({1, 1, 2}, std::vector<double>{1, 1}, 5);
  int owned = 0;
  for (int rank = 0; rank < 5; ++rank) few.for_each_block(rank, [&owned](std::size_t) { ++owned; });
  EXPECT_EQ(owned, 2);
}

}  // namespace
}  // namespace gicube::reference
