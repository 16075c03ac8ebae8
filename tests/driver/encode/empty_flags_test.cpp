#include "encode/volume/voxel_blocks.h"

#include <rapidcheck.h>

#include "gicube/wire/voxel.h"
#include "refusal.h"
#include "test.h"

namespace gicube {
namespace {

using Lut = std::vector<wire::SegmentationEntry>;

Lut invisible() { return Lut(wire::kSegmentationEntries); }

std::uint8_t flag(BlockStatistics block, const Lut& lut) { return find_empty_blocks(std::span(&block, 1), lut)[0]; }

TEST(EmptyFlags, ABlockIsEmptyIfItsDensitiesAreTransparent) {
  Lut lut = invisible();
  EXPECT_EQ(flag({0, 4095, 15}, lut), 1);
  lut[1000].opacity = 1;
  EXPECT_EQ(flag({0, 999, 1}, lut), 1);
  EXPECT_EQ(flag({1001, 4095, 1}, lut), 1);
  EXPECT_EQ(flag({1000, 1000, 1}, lut), 0);
  EXPECT_EQ(flag({0, 1000, 1}, lut), 0);
  EXPECT_EQ(flag({1000, 4095, 1}, lut), 0);
  EXPECT_EQ(flag({0, 4095, 1}, lut), 0);  // a density between the two may be interpolated
}

TEST(EmptyFlags, OnlyTagsThatTheBlockHoldsCount) {
  Lut lut = invisible();
  lut[2 << 12 | 1000].opacity = 65535;
  EXPECT_EQ(flag({0, 4095, 0b1011}, lut), 1);
  EXPECT_EQ(flag({0, 4095, 0b0100}, lut), 0);
  EXPECT_EQ(flag({0, 4095, 0b0101}, lut), 0);
}

TEST(EmptyFlags, ABlockThatIsNotStoredShowsDensityZeroOfTagZero) {
  const std::vector<std::uint16_t> zeros(512);
  const VoxelBlocks blocks({8, 8, 8}, 8, {zeros, zeros, {}, {}});
  ASSERT_FALSE(blocks.stored(0));
  Lut lut = invisible();
  lut[1].opacity = lut[1 << 12].opacity = 65535;
  EXPECT_EQ(find_empty_blocks(blocks.statistics(), lut), std::vector<std::uint8_t>{1});
  lut[0].opacity = 1;
  EXPECT_EQ(find_empty_blocks(blocks.statistics(), lut), std::vector<std::uint8_t>{0});
}

TEST(EmptyFlags, TheLutMustBeWhole) {
  const Lut lut(4096);
  EXPECT_EQ(refusal([&lut] { find_empty_blocks(std::span<const BlockStatistics>{}, lut); }),
            "segmentation LUT: expected 16384 entries, got 4096");
}

// Every voxel of a block and its +1 faces, every tag, every entry: slow and plain.
std::uint8_t plain_flag(Dims dims, int n, std::array<int, 3> block, const std::vector<std::uint16_t>& densities,
                        const std::vector<std::uint8_t>& tags, const Lut& lut) {
  std::uint16_t low = 4095, high = 0;
  std::array<bool, 4> present{};
  for (int z = block[2] * n; z <= std::min((block[2] + 1) * n, dims[2] - 1); ++z) {
    for (int y = block[1] * n; y <= std::min((block[1] + 1) * n, dims[1] - 1); ++y) {
      for (int x = block[0] * n; x <= std::min((block[0] + 1) * n, dims[0] - 1); ++x) {
        const int voxel = (z * dims[1] + y) * dims[0] + x;
        const auto i = static_cast<std::size_t>(voxel);
        low = std::min(low, densities[i]);
        high = std::max(high, densities[i]);
        present[tags[i]] = true;
      }
    }
  }
  for (std::size_t tag = 0; tag < 4; ++tag) {
    for (std::size_t d = low; present[tag] && d <= high; ++d) {
      if (lut[tag << 12 | d].opacity > 0) return 0;
    }
  }
  return 1;
}

TEST(EmptyFlags, AgreeWithLookingAtEveryVoxelAndEntry) {
  EXPECT_TRUE(rc::check([](unsigned seed) {
    std::mt19937 random(seed);
    const auto below = [&random](unsigned n) { return static_cast<std::uint16_t>(random() % n); };
    const Dims dims{2 + below(12), 2 + below(12), 2 + below(12)};
    const auto count = static_cast<std::size_t>(dims[0] * dims[1] * dims[2]);
    std::vector<std::uint16_t> densities(count), codes(count);
    std::vector<std::uint8_t> tags(count);
    for (int i = 0; i < 6; ++i) {  // a few voxels only, so that some blocks are empty
      densities[random() % count] = below(4096);
      tags[random() % count] = static_cast<std::uint8_t>(below(4));
    }
    Lut lut = invisible();
    for (int i = 0; i < 3; ++i) {
      const std::size_t first = random() % lut.size(), last = std::min(lut.size(), first + random() % 3000);
      for (std::size_t e = first; e < last; ++e) lut[e].opacity = 1;
    }
    const VoxelBlocks blocks(dims, 4, {densities, codes, tags, {}});
    const auto flags = find_empty_blocks(blocks.statistics(), lut);
    const auto [nx, ny, nz] = blocks.blocks();
    for (int b = 0; b < nx * ny * nz; ++b) {
      RC_ASSERT(flags[static_cast<std::size_t>(b)] ==
                plain_flag(dims, 4, {b % nx, b / nx % ny, b / nx / ny}, densities, tags, lut));
    }
  }));
}

TEST(EmptyFlags, PackBlockZeroInTheLowestBit) {
  const std::vector<std::uint8_t> flags{1, 0, 0, 7, 0, 0, 0, 0, 0, 255};
  EXPECT_EQ(pack_flags(flags), (std::vector<std::uint8_t>{0b00001001, 0b00000010}));
  EXPECT_TRUE(pack_flags({}).empty());
}

TEST(EmptyFlags, PackedBitsAreTheFlags) {
  EXPECT_TRUE(rc::check([](const std::vector<bool>& bits) {
    const std::vector<std::uint8_t> flags(bits.begin(), bits.end());
    const auto bytes = pack_flags(flags);
    RC_ASSERT(bytes.size() == (bits.size() + 7) / 8);
    for (std::size_t b = 0; b < 8 * bytes.size(); ++b) {
      RC_ASSERT((bytes[b / 8] >> b % 8 & 1) == (b < bits.size() && bits[b]));
    }
  }));
}

}  // namespace
}  // namespace gicube
