#include "encode/volume/voxel_blocks.h"

#include "encode/volume/samples.h"
#include "gicube/wire/voxel.h"
#include "refusal.h"
#include "test.h"

namespace gicube {
namespace {

// A volume of voxels and its blocks.
struct Volume {
  Dims dims;
  std::vector<std::uint16_t> densities, codes;
  std::vector<std::uint8_t> tags;

  explicit Volume(Dims size) : dims(size) {
    const std::size_t count = voxel_count(size);
    densities.resize(count);
    codes.resize(count);
    tags.resize(count);
  }
  std::size_t index(int x, int y, int z) const {
    const int voxel = (z * dims[1] + y) * dims[0] + x;
    return static_cast<std::size_t>(voxel);
  }
  VoxelBlocks blocks(int n) const { return {dims, n, {densities, codes, tags, {}}}; }
};

Volume random_volume(Dims dims, unsigned seed) {
  Volume volume(dims);
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < volume.densities.size(); ++i) {
    volume.densities[i] = static_cast<std::uint16_t>(random() % 4096);
    volume.codes[i] = static_cast<std::uint16_t>(random() % 2048);
    volume.tags[i] = static_cast<std::uint8_t>(random() % 4);
  }
  return volume;
}

TEST(VoxelBlocks, CoverTheVolume) {
  EXPECT_EQ(Volume({32, 33, 8}).blocks(32).blocks(), (Dims{1, 2, 1}));
  EXPECT_EQ(Volume({32, 33, 8}).blocks(8).blocks(), (Dims{4, 5, 1}));
  EXPECT_EQ(Volume({32, 33, 8}).blocks(8).count(), 20u);
}

TEST(VoxelBlocks, EveryVoxelTravelsOnceInItsBlock) {
  for (const Dims dims : {Dims{16, 16, 16}, Dims{19, 8, 13}, Dims{2, 9, 2}}) {
    const Volume volume = random_volume(dims, 1);
    const VoxelBlocks blocks = volume.blocks(8);
    std::vector<std::uint8_t> bytes{1, 2, 3};
    for (std::size_t b = 0; b < blocks.count(); ++b) {
      blocks.pack(b, bytes);
      ASSERT_EQ(bytes.size(), 512u * 9 / 2);
      const int i = static_cast<int>(b), nx = blocks.blocks()[0], ny = blocks.blocks()[1];
      for (int at = 0; at < 512; ++at) {
        const int x = i % nx * 8 + at % 8, y = i / nx % ny * 8 + at / 8 % 8, z = i / nx / ny * 8 + at / 64;
        wire::Voxel expected;  // beyond the volume: zero
        if (x < dims[0] && y < dims[1] && z < dims[2]) {
          const std::size_t v = volume.index(x, y, z);
          expected = {volume.densities[v], volume.codes[v], volume.tags[v], 0};
        }
        ASSERT_EQ(wire::to_voxel(wire::load36(bytes, static_cast<std::size_t>(at))), expected) << b << ' ' << at;
      }
    }
  }
}

TEST(VoxelBlocks, NoCodesMeanNoGradient) {
  Volume volume = random_volume({8, 8, 8}, 3);
  std::fill(volume.codes.begin(), volume.codes.end(), std::uint16_t{0});
  const VoxelBlocks with = volume.blocks(8);
  const VoxelBlocks without(volume.dims, 8, {volume.densities, {}, volume.tags, {}});
  std::vector<std::uint8_t> a, b;
  with.pack(0, a);
  without.pack(0, b);
  EXPECT_EQ(a, b);
  EXPECT_EQ(with.stored(0), without.stored(0));
}

TEST(VoxelBlocks, NoTagsMeanTagZero) {
  Volume volume = random_volume({8, 8, 8}, 2);
  std::fill(volume.tags.begin(), volume.tags.end(), std::uint8_t{0});
  const VoxelBlocks with = volume.blocks(8);
  const VoxelBlocks without(volume.dims, 8, {volume.densities, volume.codes, {}, {}});
  std::vector<std::uint8_t> a, b;
  with.pack(0, a);
  without.pack(0, b);
  EXPECT_EQ(a, b);
  EXPECT_EQ(with.statistics(0), without.statistics(0));
  EXPECT_EQ(without.statistics(0).tags, 1);
}

TEST(VoxelBlocks, StatisticsAreThoseOfTheBlockAndItsUpperFaces) {
  for (const Dims dims : {Dims{16, 24, 8}, Dims{17, 9, 20}, Dims{2, 3, 5}}) {
    const Volume volume = random_volume(dims, 3);
    const VoxelBlocks blocks = volume.blocks(8);
    for (std::size_t b = 0; b < blocks.count(); ++b) {
      const int i = static_cast<int>(b), nx = blocks.blocks()[0], ny = blocks.blocks()[1];
      const int x0 = i % nx * 8, y0 = i / nx % ny * 8, z0 = i / nx / ny * 8;
      BlockStatistics expected{4095, 0, 0};
      for (int z = z0; z < std::min(z0 + 9, dims[2]); ++z) {
        for (int y = y0; y < std::min(y0 + 9, dims[1]); ++y) {
          for (int x = x0; x < std::min(x0 + 9, dims[0]); ++x) {
            const std::size_t v = volume.index(x, y, z);
            expected.min_density = std::min(expected.min_density, volume.densities[v]);
            expected.max_density = std::max(expected.max_density, volume.densities[v]);
            expected.tags = static_cast<std::uint8_t>(expected.tags | 1 << volume.tags[v]);
          }
        }
      }
      EXPECT_EQ(blocks.statistics(b), expected) << b;
    }
  }
}

TEST(VoxelBlocks, AnObjectOnTheSharedFaceBelongsToBothBlocks) {
  Volume volume({16, 8, 8});
  volume.densities[volume.index(8, 3, 3)] = 100;
  EXPECT_TRUE(volume.blocks(8).stored(0));
  EXPECT_TRUE(volume.blocks(8).stored(1));
  EXPECT_EQ(volume.blocks(8).statistics(0), (BlockStatistics{0, 100, 1}));
  volume.densities[volume.index(8, 3, 3)] = 0;
  volume.densities[volume.index(9, 3, 3)] = 100;
  EXPECT_FALSE(volume.blocks(8).stored(0));
  EXPECT_TRUE(volume.blocks(8).stored(1));
}

TEST(VoxelBlocks, ZeroDensityIsStoredForATagOrAGradient) {
  Volume tagged({16, 8, 8});
  EXPECT_FALSE(tagged.blocks(8).stored(0));
  tagged.tags[tagged.index(3, 3, 3)] = 2;
  EXPECT_TRUE(tagged.blocks(8).stored(0));
  EXPECT_FALSE(tagged.blocks(8).stored(1));
  Volume beside_an_object({16, 8, 8});
  beside_an_object.codes[beside_an_object.index(8, 3, 3)] = 77;  // the copy on block 0's face must not be lost
  EXPECT_TRUE(beside_an_object.blocks(8).stored(0));
  EXPECT_TRUE(beside_an_object.blocks(8).stored(1));
}

TEST(VoxelBlocks, PaddingBeyondTheVolumeDoesNotCount) {
  Volume volume({10, 8, 8});
  std::fill(volume.densities.begin(), volume.densities.end(), std::uint16_t{4095});
  EXPECT_EQ(volume.blocks(8).statistics(1), (BlockStatistics{4095, 4095, 1}));
}

TEST(VoxelBlocks, RefuseSizesThatDoNotFit) {
  const Volume volume({8, 8, 8});
  EXPECT_EQ(refusal([&] { volume.blocks(7); }), "block_voxels: expected an even number of at least 2, got 7");
  EXPECT_EQ(refusal([&] { volume.blocks(0); }), "block_voxels: expected an even number of at least 2, got 0");
  EXPECT_EQ(refusal([&] {
              VoxelBlocks({8, 8, 9}, 8, {volume.densities, volume.codes, {}, {}});
            }),
            "densities: expected 576, one per voxel, got 512");
  const std::vector<std::uint8_t> tags(511);
  EXPECT_EQ(refusal([&] {
              VoxelBlocks({8, 8, 8}, 8, {volume.densities, volume.codes, tags, {}});
            }),
            "tags: expected 512, one per voxel, got 511");
}

}  // namespace
}  // namespace gicube
