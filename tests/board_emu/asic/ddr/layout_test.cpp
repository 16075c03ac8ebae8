#include "asic/ddr/layout.h"

#include "test.h"

namespace gicube::emu::ddr {
namespace {

// Voxels of a block's edge, packets of a tile.
class DdrLayout : public testing::TestWithParam<std::tuple<std::uint32_t, std::uint32_t>> {
 protected:
  const std::uint32_t edge = std::get<0>(GetParam()), packets = std::get<1>(GetParam());
};

TEST_P(DdrLayout, GivesEveryTileAPlaceOfItsOwnWithinTheRanks) {
  const std::uint32_t blocks = edge == 64 ? 61 : 401;
  const Layout layout(blocks, edge, packets);
  std::vector<bool> taken(std::size_t{layout.devices()} * 4 * 4096 * 512);
  for (std::uint32_t block = 0; block < blocks; ++block) {
    for (std::uint32_t tile = 0; tile < layout.tiles(); ++tile) {
      const Location at = layout.locate(block, tile);
      ASSERT_LT(at.device, layout.devices());
      ASSERT_LT(at.bank, 4);
      ASSERT_LT(at.row, 4096);
      for (std::uint32_t column = at.column; column < at.column + packets; ++column) {
        ASSERT_LT(column, 512);
        const std::size_t place = ((at.device * 4u + at.bank) * 4096u + at.row) * 512u + column;
        ASSERT_FALSE(taken[place]) << "block " << block << " tile " << tile;
        taken[place] = true;
      }
    }
  }
}

TEST_P(DdrLayout, NoTileNeedsTheBankOfATileBesideItForAnotherRow) {
  const Layout layout(7, edge, packets);
  const auto& tiles = layout.bricks().tiles;
  for (std::uint32_t block = 0; block < 7; ++block) {
    for (std::uint32_t tile = 0; tile < layout.tiles(); ++tile) {
      const std::uint32_t x = tile % tiles[0], y = tile / tiles[0] % tiles[1], z = tile / (tiles[0] * tiles[1]);
      const Location here = layout.locate(block, tile);
      const std::array<std::uint32_t, 3> step{1, tiles[0], tiles[0] * tiles[1]};
      const std::array<bool, 3> there{x + 1 < tiles[0], y + 1 < tiles[1], z + 1 < tiles[2]};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!there[axis]) continue;
        const Location next = layout.locate(block, tile + step[axis]);
        if (next.device != here.device || next.bank != here.bank) continue;
        ASSERT_EQ(next.row, here.row) << "block " << block << " tile " << tile << " axis " << axis;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Blocks, DdrLayout,
                         testing::Combine(testing::Values(8u, 16u, 32u, 64u), testing::Values(1u, 2u)));

TEST(DdrLayoutOfTheDesignPoint, IsTwentySevenBricks) {
  const Bricks bricks = cut_block(32);
  EXPECT_EQ(bricks.tiles, (std::array<std::uint32_t, 3>{17, 17, 33}));
  EXPECT_LE(bricks.size[0] * bricks.size[1] * bricks.size[2], 512u);
  EXPECT_EQ(bricks.count[0] * bricks.count[1] * bricks.count[2], 27u);
  EXPECT_EQ(Layout(1, 32).tiles(), 9537u);
}

TEST(DdrLayoutOfTheDesignPoint, FitsA512CubeOfFourProcessorsInTwoRanks) {
  EXPECT_EQ(Layout(0, 32).devices(), 1u);
  EXPECT_EQ(Layout(128, 32).devices(), 1u) << "256^3 on four processors";
  EXPECT_EQ(Layout(1024, 32).devices(), 2u) << "512^3";
}

TEST(DdrLayoutOfTheDesignPoint, RefusesWhatItCannotCut) {
  EXPECT_THROW(cut_block(31), std::invalid_argument);
  EXPECT_THROW(cut_block(128), std::invalid_argument);
}

}  // namespace
}  // namespace gicube::emu::ddr
