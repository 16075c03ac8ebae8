#include "asic/partition.h"

#include <compare>

#include "test.h"
#include "voxels.h"

namespace gicube::emu {
namespace {

v1::AsicConfig asic(v1::Partition kind, unsigned processors, const std::array<unsigned, 3>& skew = {1, 1, 1}) {
  v1::AsicConfig config;
  config.set_partition(kind);
  config.set_processors(processors);
  config.set_skew_x(skew[0]);
  config.set_skew_y(skew[1]);
  config.set_skew_z(skew[2]);
  return config;
}

std::size_t block(int x, int y, int z) { return static_cast<std::size_t>(x + 8 * (y + 8 * z)); }

TEST(Partition, SimpleSlabsAtTheDesignPointNumberQueuesAsThePaperDoes) {
  const Partition partition(asic(v1::simple_slab, 4), {8, 8, 8});
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) {
        const Home& home = partition.home(block(x, y, z));
        EXPECT_EQ(home.processor, x / 2);
        EXPECT_EQ(home.number, static_cast<std::uint32_t>(((x % 2) << 6) + (y << 3) + z));
      }
    }
  }
}

TEST(Partition, RepeatedSlabsGoRoundTheProcessors) {
  const Partition partition(asic(v1::repeated_slab, 4), {8, 8, 8});
  for (int x = 0; x < 8; ++x) EXPECT_EQ(partition.home(block(x, 3, 5)).processor, x % 4);
}

TEST(Partition, SkewedBlocksGiveEveryRowOfBlocksToAllProcessorsInTurn) {
  const Partition partition(asic(v1::skewed_block, 4), {8, 8, 8});
  EXPECT_EQ(partition.home(block(1, 2, 3)).processor, 6 % 4);
  for (const auto& step : {std::array{1, 0, 0}, std::array{0, 1, 0}, std::array{0, 0, 1}}) {
    std::set<int> owners;
    for (int i = 0; i < 4; ++i) owners.insert(partition.home(block(i * step[0], i * step[1], i * step[2])).processor);
    EXPECT_EQ(owners.size(), 4u);
  }
}

TEST(Partition, SixteenProcessorsShareAnEightfoldGridEvenlyWithASkewOfPowersOfTwoOnly) {
  const Partition plain(asic(v1::skewed_block, 16), {8, 8, 8}), even(asic(v1::skewed_block, 16, {1, 2, 4}), {8, 8, 8});
  EXPECT_EQ(even.home(block(1, 2, 3)).processor, (1 + 2 * 2 + 4 * 3) % 16);
  EXPECT_EQ(even.max_blocks(), 8u * 8 * 8 / 16);
  // i + j + k = 10 or 11 and, a turn later, none: 48 ways, the most that one sum modulo 16 has.
  EXPECT_EQ(plain.max_blocks(), 48u);
}

// The most blocks of a processor over the mean: of the whole grid, and of the worst plane of blocks across an axis.
struct Imbalance {
  double whole = 0, plane = 0;

  friend auto operator<=>(const Imbalance&, const Imbalance&) = default;
};

Imbalance imbalance(int grid, unsigned processors, const std::array<unsigned, 3>& skew) {
  const Partition partition(asic(v1::skewed_block, processors, skew), {grid, grid, grid});
  std::vector<std::vector<unsigned>> planes(static_cast<std::size_t>(3 * grid), std::vector<unsigned>(processors));
  for_each_voxel({grid, grid, grid}, [&](int x, int y, int z) {
    const unsigned owner = partition.home(static_cast<std::size_t>(x + grid * (y + grid * z))).processor;
    for (const int plane : {x, grid + y, 2 * grid + z}) ++planes[static_cast<std::size_t>(plane)][owner];
  });
  Imbalance found{static_cast<double>(partition.max_blocks()) * processors / (grid * grid * grid)};
  for (const auto& plane : planes) {
    found.plane = std::max(found.plane, static_cast<double>(std::ranges::max(plane)) * processors / (grid * grid));
  }
  return found;
}

// Rule [H331] has these numbers. Where they are as good as others the smallest coefficients are named.
TEST(Partition, TheDocumentedCoefficientsAreTheMostEvenOnes) {
  struct Row {
    int grid;
    unsigned processors;
    Imbalance of_the_sum;
    std::array<unsigned, 3> best;
    Imbalance of_the_best;
  };
  for (const Row& row : {Row{4, 8, {1.5, 2}, {1, 2, 3}, {1, 1.5}}, Row{4, 16, {3, 4}, {1, 2, 4}, {1, 2}},
                         Row{8, 16, {1.5, 2}, {1, 2, 7}, {1, 1.25}}, Row{8, 8, {1, 1}, {1, 1, 1}, {1, 1}},
                         Row{8, 4, {1, 1}, {1, 1, 1}, {1, 1}}}) {
    EXPECT_EQ(imbalance(row.grid, row.processors, {1, 1, 1}), row.of_the_sum);
    std::pair<Imbalance, std::array<unsigned, 3>> best{{1e9, 1e9}, {}};
    for (unsigned a = 1; a < row.processors; ++a) {
      for (unsigned b = a; b < row.processors; ++b) {
        for (unsigned c = b; c < row.processors; ++c) {
          best = std::min(best, {imbalance(row.grid, row.processors, {a, b, c}), {a, b, c}});
        }
      }
    }
    EXPECT_EQ(best.second, row.best);
    EXPECT_EQ(best.first, row.of_the_best);
  }
}

TEST(Partition, EveryBlockHasOneNumberOfItsProcessor) {
  for (const auto kind : {v1::simple_slab, v1::repeated_slab, v1::skewed_block}) {
    for (const unsigned processors : {1u, 3u, 4u, 7u, 16u}) {
      const std::array<int, 3> blocks{5, 3, 9};
      const Partition partition(asic(kind, processors, {1, 2, 0}), blocks);
      std::size_t all = 0;
      for (unsigned p = 0; p < processors; ++p) {
        EXPECT_LE(partition.blocks_of(p), partition.max_blocks());
        all += partition.blocks_of(p);
        for (std::uint32_t number = 0; number < partition.blocks_of(p); ++number) {
          const Home& home = partition.home(partition.block(p, number));
          EXPECT_EQ(home.processor, p);
          EXPECT_EQ(home.number, number);
        }
      }
      EXPECT_EQ(all, 5u * 3 * 9);
    }
  }
}

}  // namespace
}  // namespace gicube::emu
