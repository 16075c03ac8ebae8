#include "asic/rdram/layout.h"

#include "asic/rdram/channel.h"
#include "test.h"

namespace gicube::emu::rdram {
namespace {

struct Shape {
  std::uint32_t n, mbit, packets = 1;  // of a tile
};

void PrintTo(const Shape& shape, std::ostream* out) {
  *out << "n " << shape.n << ", " << shape.mbit << " Mbit, " << shape.packets << " packets a tile";
}

class RdramLayout : public testing::TestWithParam<Shape> {
 protected:
  static std::uint32_t columns() { return GetParam().mbit == 288 ? 128 : 64; }
};

// Seven pages of 4 x 6 x 5 voxels: 24 + 30 + 20 faces each.
TEST(Bricks, CostTheirPagesTimesTheSurfaceOfOne) { EXPECT_EQ((Bricks{.size = {2, 3, 5}, .pages = 7}).cost(), 518u); }

TEST_P(RdramLayout, GivesEveryTileAPlaceOfItsOwnWithinTheDevices) {
  const std::uint32_t blocks = GetParam().n == 64 ? 61 : 401;
  const Layout layout(blocks, GetParam().n, GetParam().mbit, GetParam().packets);
  std::vector<bool> taken(std::size_t{layout.devices()} * 32 * 512 * columns());
  for (std::uint32_t block = 0; block < blocks; ++block) {
    for (std::uint32_t tile = 0; tile < layout.tiles(); ++tile) {
      const Location at = layout.locate(block, tile);
      ASSERT_LT(at.device, layout.devices());
      ASSERT_LT(at.bank, 32);
      ASSERT_LT(at.row, 512);
      for (std::uint32_t column = at.column; column < at.column + GetParam().packets; ++column) {
        ASSERT_LT(column, columns());
        const std::size_t place = ((at.device * 32u + at.bank) * 512u + at.row) * columns() + column;
        ASSERT_FALSE(taken[place]) << "block " << block << " tile " << tile;
        taken[place] = true;
      }
    }
  }
}

bool share_sense_amps(const Location& a, const Location& b) {
  return a.device == b.device && (a.bank == b.bank || (neighbours(a.bank) >> b.bank & 1) != 0);
}

// Of these packets any two either lie in one open row or in banks that can be open together.
void expect_no_conflict(const std::vector<Location>& packets) {
  for (const Location& a : packets) {
    for (const Location& b : packets) {
      if (a.device == b.device && a.bank == b.bank && a.row == b.row) continue;
      ASSERT_FALSE(share_sense_amps(a, b))
          << int{a.bank} << " row " << a.row << ", " << int{b.bank} << " row " << b.row;
    }
  }
}

TEST_P(RdramLayout, NoFourConsecutivePacketsNeedABankTwiceOrItsNeighbour) {
  const Layout layout(5, GetParam().n, GetParam().mbit, GetParam().packets);
  for (std::uint32_t block = 0; block < 5; ++block) {
    for (std::uint32_t tile = 0; tile + 4 <= layout.tiles(); ++tile) {
      std::vector<Location> packets;
      for (std::uint32_t i = 0; i < 4; ++i) packets.push_back(layout.locate(block, tile + i));
      ASSERT_NO_FATAL_FAILURE(expect_no_conflict(packets)) << "block " << block << " tile " << tile;
    }
  }
}

TEST_P(RdramLayout, NoNeighbourhoodOfVoxelsNeedsABankTwiceOrItsNeighbour) {
  const Layout layout(3, GetParam().n, GetParam().mbit, GetParam().packets);
  const auto& tiles = layout.bricks().tiles;
  for (std::uint32_t tile = 0; tile < layout.tiles(); ++tile) {
    const std::uint32_t x = tile % tiles[0], y = tile / tiles[0] % tiles[1], z = tile / (tiles[0] * tiles[1]);
    std::vector<Location> packets;
    for (std::uint32_t k = z; k < std::min(z + 2, tiles[2]); ++k) {
      for (std::uint32_t j = y; j < std::min(y + 2, tiles[1]); ++j) {
        for (std::uint32_t i = x; i < std::min(x + 2, tiles[0]); ++i) {
          packets.push_back(layout.locate(2, i + tiles[0] * (j + tiles[1] * k)));
        }
      }
    }
    ASSERT_NO_FATAL_FAILURE(expect_no_conflict(packets)) << "tile " << tile;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, RdramLayout,
                         testing::Values(Shape{8, 144}, Shape{16, 144}, Shape{32, 144}, Shape{64, 144}, Shape{8, 288},
                                         Shape{16, 288}, Shape{32, 288}, Shape{64, 288}, Shape{8, 144, 2},
                                         Shape{32, 144, 2}, Shape{64, 144, 2}, Shape{16, 288, 2}, Shape{32, 288, 2},
                                         Shape{32, 288, 3}, Shape{64, 288, 3}));

TEST(RdramLayoutOfTheDesignPoint, IsBricksOfSixByThreeBySevenTiles) {
  const Bricks bricks = cut_block(32, 288);
  EXPECT_EQ(bricks.tiles, (std::array<std::uint32_t, 3>{17, 17, 33}));
  EXPECT_EQ(bricks.size, (std::array<std::uint32_t, 3>{6, 3, 7}));
  EXPECT_EQ(bricks.pages, 90u);
  EXPECT_EQ(Layout(1, 32, 288).tiles(), 9537u);
}

TEST(RdramLayoutOfTheDesignPoint, NeedsADeviceFor182Blocks) {
  EXPECT_EQ(Layout(0, 32, 288).devices(), 1u);
  EXPECT_EQ(Layout(128, 32, 288).devices(), 1u) << "256^3 on four processors";
  EXPECT_EQ(Layout(182, 32, 288).devices(), 1u);  // 91 of a parity, 90 pages each, of 8192
  EXPECT_EQ(Layout(183, 32, 288).devices(), 2u);
}

TEST(RdramLayoutOfTheDesignPoint, NeedsAboutTwiceTheDevicesForTilesOfTwoPackets) {
  EXPECT_EQ(Layout(1, 32, 288, 2).tiles(), 9537u);
  EXPECT_EQ(Layout(1, 32, 288, 2).packets_of_tile(), 2u);
  EXPECT_EQ(Layout(512, 32, 288).devices(), 3u);
  EXPECT_EQ(Layout(512, 32, 288, 2).devices(), 6u);
}

TEST(RdramLayoutOfTheDesignPoint, RefusesWhatItCannotCut) {
  EXPECT_THROW(cut_block(31, 288), std::invalid_argument);
  EXPECT_THROW(cut_block(128, 288), std::invalid_argument);
  EXPECT_THROW(cut_block(32, 256), std::invalid_argument);
}

}  // namespace
}  // namespace gicube::emu::rdram
