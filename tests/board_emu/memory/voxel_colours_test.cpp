// The colours of voxels, from their bytes to what the resampling unit reads.
#include "memory/volume_memory.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr int kColouredEdge = 8;
constexpr std::size_t kColouredVoxels = 512;
using wire::VoxelFormat;

std::uint8_t byte_at(std::size_t block, std::size_t i) { return static_cast<std::uint8_t>(block * 71 + i * 13); }
std::uint16_t density_at(std::size_t block, std::size_t voxel) {
  return static_cast<std::uint16_t>((block * 1000 + voxel * 7) % 4096);
}

// Two blocks along x with words; `painted` of them have colours.
VolumeMemory two_blocks(VoxelFormat format, const std::vector<std::size_t>& painted) {
  VolumeMemory memory(kColouredEdge, format);
  memory.resize({16, 8, 8});
  for (std::size_t block = 0; block < 2; ++block) {
    std::vector<std::uint8_t> words(memory.block_bytes());
    for (std::size_t i = 0; i < kColouredVoxels; ++i)
      wire::store36(words, i, wire::to_word(wire::Voxel{density_at(block, i), 0, 0, 0}));
    memory.write(block * words.size(), words);
  }
  for (const std::size_t block : painted) {
    std::vector<std::uint8_t> bytes(3 * kColouredVoxels);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = byte_at(block, i);
    EXPECT_TRUE(memory.write_colours(block * bytes.size(), bytes));
  }
  memory.decode(std::vector<wire::GradientEntry>(wire::kGradientCodes), true, 2, {.colours = true});
  return memory;
}

DecodedColour at(const VolumeMemory& memory, std::size_t block, std::size_t x, std::size_t y, std::size_t z) {
  return memory.view(block).colours[x + 9 * (y + 9 * z)];
}

TEST(VoxelColours, AreBytesOfAFullScaleThatIsTheDensitys) {
  const VolumeMemory memory = two_blocks(VoxelFormat::kRgb, {0, 1});
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t voxel = 3 + 8 * (2 + 8 * 5);
    EXPECT_EQ(at(memory, 0, 3, 2, 5).channel[c], (byte_at(0, 3 * voxel + c) * 32760 + 127) / 255);
    const std::size_t face = 0 + 8 * (2 + 8 * 5);  // the next block's, on this one's +1 face
    EXPECT_EQ(at(memory, 0, 8, 2, 5).channel[c], (byte_at(1, 3 * face + c) * 32760 + 127) / 255);
    EXPECT_EQ(at(memory, 1, 8, 2, 5).channel[c], 0) << "beyond the volume";
  }
}

TEST(VoxelColours, ArePremultipliedByTheirAlphaWhereThatIsTheDensity) {
  const VolumeMemory memory = two_blocks(VoxelFormat::kRgba, {0, 1});
  for (const std::size_t block : {std::size_t{0}, std::size_t{1}}) {
    for (std::size_t voxel = 0; voxel < kColouredVoxels; ++voxel) {
      const DecodedColour& colour = at(memory, block, voxel % 8, voxel / 8 % 8, voxel / 64);
      const int alpha = density_at(block, voxel) * 8;  // 12.3
      ASSERT_EQ(colour.channel[3], alpha);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(colour.channel[c], (byte_at(block, 3 * voxel + c) * alpha + 127) / 255) << block << ' ' << voxel;
      }
    }
  }
}

TEST(VoxelColours, OfABlockWithoutThemAreBlackIfAnotherHasSome) {
  const VolumeMemory memory = two_blocks(VoxelFormat::kRgb, {1});
  EXPECT_EQ(at(memory, 0, 3, 3, 3), DecodedColour{});
  EXPECT_NE(at(memory, 1, 3, 3, 3), DecodedColour{});
}

TEST(VoxelColours, OfAVolumeWithoutThemAreNone) {
  EXPECT_EQ(two_blocks(VoxelFormat::kRgb, {}).view(0).colours, nullptr);
}

TEST(VoxelColours, AreMadeAnewWhenTheirAlphaChanges) {
  VolumeMemory memory = two_blocks(VoxelFormat::kRgba, {0, 1});
  std::vector<std::uint8_t> words(memory.block_bytes());
  memory.write(memory.block_bytes(), words);  // the second block's alpha is 0 now
  memory.decode(std::vector<wire::GradientEntry>(wire::kGradientCodes), false, 1);
  EXPECT_EQ(at(memory, 1, 4, 4, 4), DecodedColour{});
  EXPECT_EQ(at(memory, 0, 8, 4, 4), DecodedColour{}) << "on the face of the block before it";
}

TEST(VoxelColours, AreRefusedOnACardWithoutThemAndForBlocksThatAreNotThere) {
  const std::vector<std::uint8_t> bytes(3 * kColouredVoxels);
  VolumeMemory plain(kColouredEdge);
  plain.resize({16, 8, 8});
  plain.write(0, std::vector<std::uint8_t>(plain.block_bytes()));
  EXPECT_FALSE(plain.write_colours(0, bytes));
  VolumeMemory memory(kColouredEdge, VoxelFormat::kRgb);
  memory.resize({16, 8, 8});
  memory.write(0, std::vector<std::uint8_t>(memory.block_bytes()));
  EXPECT_TRUE(memory.write_colours(0, bytes));
  EXPECT_FALSE(memory.write_colours(3 * kColouredVoxels, bytes)) << "its words were never written";
  EXPECT_FALSE(memory.write_colours(3 * kColouredVoxels - 1, bytes)) << "it ends there";
  EXPECT_FALSE(memory.write_colours(6 * kColouredVoxels, bytes)) << "beyond the volume";
  EXPECT_EQ(memory.colours().stored(), 1u);
}

TEST(VoxelColours, HaveBitsThatCanFlipBehindThoseOfTheWords) {
  VolumeMemory memory = two_blocks(VoxelFormat::kRgb, {0, 1});
  const std::size_t words = 8 * memory.block_bytes();
  const auto place = memory.find_bit(1, words + 24 * 5 + 3);  // of the sixth voxel's red
  ASSERT_TRUE(place.has_value());
  memory.flip(*place);
  std::vector<std::uint8_t> read(1);
  memory.read_colours(3 * kColouredVoxels + 15, read);
  EXPECT_EQ(read[0], byte_at(1, 15) ^ 8);
}

}  // namespace
}  // namespace gicube::emu
