#include "memory/volume_memory.h"

#include "gicube/wire/voxel.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr int kBlock = 8;
constexpr std::size_t kBlockWords = 512;

std::vector<wire::GradientEntry> gradient_lut() {
  std::vector<wire::GradientEntry> lut(wire::kGradientCodes);
  for (std::size_t i = 0; i < lut.size(); ++i)
    lut[i] = {static_cast<std::int16_t>(i % 511), static_cast<std::int16_t>(-(static_cast<int>(i) % 300)), 1};
  lut[wire::kNoGradient] = {0, 0, 0};
  return lut;
}

wire::Voxel voxel_at(int x, int y, int z) {
  return {static_cast<std::uint16_t>(x * 100 + y * 10 + z + 1),
          static_cast<std::uint16_t>((x + y * 20 + z * 300) % 2048), static_cast<std::uint8_t>((x + y + z) % 4), 0};
}

// Writes all blocks but those in `left_out`.
void fill(VolumeMemory& memory, const std::array<int, 3>& size, const std::vector<std::size_t>& left_out = {}) {
  memory.resize(size);
  for (std::size_t b = 0; b < memory.block_count(); ++b) {
    if (std::find(left_out.begin(), left_out.end(), b) != left_out.end()) continue;
    const auto nx = static_cast<std::size_t>(memory.blocks()[0]), ny = static_cast<std::size_t>(memory.blocks()[1]);
    std::vector<std::uint8_t> bytes(wire::packed36_bytes(kBlockWords));
    for (std::size_t i = 0; i < kBlockWords; ++i) {
      const int x = static_cast<int>(b % nx * kBlock + i % kBlock),
                y = static_cast<int>(b / nx % ny * kBlock + i / kBlock % kBlock),
                z = static_cast<int>(b / (nx * ny) * kBlock + i / kBlock / kBlock);
      if (x < size[0] && y < size[1] && z < size[2]) wire::store36(bytes, i, wire::to_word(voxel_at(x, y, z)));
    }
    memory.write(b * bytes.size(), bytes);
  }
}

TEST(VolumeMemory, DecodesEveryVoxelIntoItsBlockAndOntoTheFacesOfItsNeighbours) {
  const std::array<int, 3> size{20, 16, 9};
  VolumeMemory memory(kBlock);
  fill(memory, size);
  const auto lut = gradient_lut();
  memory.decode(lut, true, 2);
  for (std::size_t b = 0; b < memory.block_count(); ++b) {
    const BlockView view = memory.view(b);
    const int bx = static_cast<int>(b % 3), by = static_cast<int>(b / 3 % 2), bz = static_cast<int>(b / 6);
    std::size_t at = 0;
    for (int z = 0; z <= kBlock; ++z) {
      for (int y = 0; y <= kBlock; ++y) {
        for (int x = 0; x <= kBlock; ++x, ++at) {
          const int gx = bx * kBlock + x, gy = by * kBlock + y, gz = bz * kBlock + z;
          if (gx >= size[0] || gy >= size[1] || gz >= size[2]) {
            ASSERT_EQ(view.densities[at], 0);
            ASSERT_EQ(view.codes[at], 0);
            continue;
          }
          const wire::Voxel voxel = voxel_at(gx, gy, gz);
          ASSERT_EQ(view.densities[at], voxel.density << 3);
          ASSERT_EQ(gradient_code(view.codes[at]), voxel.gradient);
          ASSERT_EQ(tag_of(view.codes[at]), voxel.tag);
          const auto& gradient = view.gradients[voxel.gradient].channel;
          ASSERT_EQ(gradient[1], lut[voxel.gradient][0] * 32);
          ASSERT_EQ(gradient[2], lut[voxel.gradient][1] * 32);
        }
      }
    }
  }
}

TEST(VolumeMemory, TakesNoMemoryForBlocksNeverWrittenAndShowsThemZero) {
  VolumeMemory memory(kBlock);
  fill(memory, {16, 16, 16}, {0, 5});
  EXPECT_EQ(memory.stored_blocks(), 6u);
  memory.decode(gradient_lut(), true, 1);
  const BlockView view = memory.view(0);
  for (int i = 0; i < 9 * 9 * 9; ++i) {
    ASSERT_EQ(view.densities[i], 0);
    ASSERT_EQ(view.codes[i], 0);
  }
  EXPECT_EQ(memory.view(5).densities, view.densities);  // in the one place of all such blocks
  EXPECT_EQ(memory.decoded_densities().size(), (6 + 1) * 9u * 9 * 9 + 1);
  std::vector<std::uint8_t> bytes(100, 7);
  memory.read(10, bytes);
  EXPECT_EQ(bytes, std::vector<std::uint8_t>(100, 0));
}

TEST(VolumeMemory, HasNoCodesUntilAVoxelHasOne) {
  VolumeMemory memory(kBlock);
  memory.resize({16, 8, 8});
  std::vector<std::uint8_t> bytes(wire::packed36_bytes(kBlockWords));
  for (std::size_t i = 0; i < kBlockWords; ++i) wire::store36(bytes, i, wire::to_word(wire::Voxel{77, 0, 0, 2047}));
  for (std::size_t block = 0; block < 2; ++block) memory.write(block * bytes.size(), bytes);
  memory.decode(gradient_lut(), true, 2);
  EXPECT_TRUE(memory.decoded_codes().empty());
  EXPECT_EQ(memory.view(0).codes, nullptr);
  EXPECT_FALSE(memory.has_tags());

  wire::store36(bytes, 3, wire::to_word(wire::Voxel{77, 900, 0, 0}));
  memory.write(bytes.size(), bytes);
  memory.decode(gradient_lut(), false, 2);
  EXPECT_EQ(memory.decoded_codes().size(), memory.decoded_densities().size());
  EXPECT_EQ(gradient_code(memory.view(1).codes[3]), 900u);
  EXPECT_EQ(memory.view(0).codes[3], 0);
  EXPECT_FALSE(memory.has_tags());

  wire::store36(bytes, 3, wire::to_word(wire::Voxel{77, 900, 2, 0}));
  memory.write(0, bytes);
  memory.decode(gradient_lut(), false, 2);
  EXPECT_TRUE(memory.has_tags());
  EXPECT_EQ(tag_of(memory.view(0).codes[3]), 2u);
}

TEST(VolumeMemory, DecodesBlocksThatAreLeaptOverWhenTheyAreRead) {
  VolumeMemory memory(kBlock);
  fill(memory, {16, 16, 16});
  const std::vector<std::uint8_t> skipped{1, 0, 1, 1, 1, 1, 1, 1};
  memory.decode(gradient_lut(), true, 1, {.skipped = skipped});
  EXPECT_EQ(memory.decoded_densities().size(), 2 * 9u * 9 * 9 + 1);  // the zero block and one
  EXPECT_EQ(memory.view(1).densities[0], voxel_at(8, 0, 0).density << 3);
  memory.decode(gradient_lut(), false, 1);
  EXPECT_EQ(memory.decoded_densities().size(), 9 * 9u * 9 * 9 + 1);
  EXPECT_EQ(memory.view(2).densities[0], voxel_at(0, 8, 0).density << 3);
}

TEST(VolumeMemory, ReadsBackWhatWasWrittenInPiecesAcrossBlocks) {
  VolumeMemory memory(kBlock);
  memory.resize({16, 8, 8});
  std::vector<std::uint8_t> all(2 * wire::packed36_bytes(kBlockWords));
  std::mt19937 random(4);
  for (auto& byte : all) byte = static_cast<std::uint8_t>(random());
  for (std::size_t at = 0; at < all.size(); at += 777) {
    memory.write(at, std::span(all).subspan(at, std::min<std::size_t>(777, all.size() - at)));
  }
  std::vector<std::uint8_t> back(all.size());
  memory.read(0, back);
  EXPECT_EQ(back, all);
}

// The words of decoded blocks are gone, and come back.
TEST(VolumeMemory, ReadsBackWhatWasWrittenAlsoOfDecodedBlocks) {
  VolumeMemory memory(kBlock);
  fill(memory, {20, 16, 9}, {3});
  std::vector<std::uint8_t> before(memory.bytes()), after(before.size());
  memory.read(0, before);
  const std::uint64_t held = memory.memory_bytes();
  memory.decode(gradient_lut(), true, 2);
  EXPECT_LT(memory.memory_bytes(), held * 3 / 2) << "4 bytes for 4.5; faces are many in blocks of 8";
  memory.read(0, after);
  EXPECT_EQ(after, before);

  const std::vector<std::uint8_t> some(5, 0x55);  // not whole words, in the middle of a block
  memory.write(4 * memory.block_bytes() + 1001, some);
  std::copy(some.begin(), some.end(), before.begin() + static_cast<std::ptrdiff_t>(4 * memory.block_bytes() + 1001));
  memory.read(0, after);
  EXPECT_EQ(after, before);
  memory.decode(gradient_lut(), false, 1);
  memory.read(0, after);
  EXPECT_EQ(after, before);
}

TEST(VolumeMemory, KeepsTheWordsOfBlocksWithIrradianceBits) {
  VolumeMemory memory(kBlock);
  memory.resize({8, 8, 8});
  std::vector<std::uint8_t> bytes(memory.block_bytes());
  for (std::size_t i = 0; i < kBlockWords; ++i) {
    wire::store36(bytes, i,
                  wire::to_word(wire::Voxel{static_cast<std::uint16_t>(i), 0, 0,
                                            i == 77 ? std::uint16_t{1024} : std::uint16_t{0}}));
  }
  memory.write(0, bytes);
  memory.decode(gradient_lut(), true, 1);
  std::vector<std::uint8_t> back(bytes.size());
  memory.read(0, back);
  EXPECT_EQ(back, bytes);
  EXPECT_EQ(memory.view(0).densities[9], 8 << 3);
}

// Whatever the order in which blocks are written, decoded and left out, what is seen is what a memory has that decodes
// all at once.
TEST(VolumeMemory, ShowsTheSameHoweverItsBlocksCame) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 60; ++trial) {
    const std::array<int, 3> size{20, 16, 24};
    VolumeMemory memory(kBlock), whole(kBlock);
    memory.resize(size);
    whole.resize(size);
    const bool plain = trial % 3 == 0;  // no codes until the last turn
    for (int turn = 0; turn < 5; ++turn) {
      for (int writes = static_cast<int>(random() % 4); writes > 0; --writes) {
        std::vector<std::uint8_t> bytes(random() % 3 == 0 ? 45 : memory.block_bytes());
        for (std::size_t i = 0; i < bytes.size() / 9 * 2; ++i) {
          const std::uint64_t mask = plain && turn < 4 ? 0xFFFu : random() % 50 == 0 ? 0xF'FFFF'FFFFu : 0x1FF'FFFFu;
          wire::store36(bytes, i, (std::uint64_t{random()} << 20 ^ random()) & mask);
        }
        const std::size_t block = random() % memory.block_count();
        const std::uint64_t offset = block * memory.block_bytes() + (bytes.size() == 45 ? 9 * (random() % 200) : 0);
        memory.write(offset, bytes);
        whole.write(offset, bytes);
      }
      std::vector<std::uint8_t> skipped(memory.block_count());
      for (auto& flag : skipped) flag = random() % 4 == 0 ? 1 : 0;
      memory.decode(gradient_lut(), turn == 0, 1 + trial % 2, {.skipped = skipped});
    }
    memory.decode(gradient_lut(), false, 1);
    whole.decode(gradient_lut(), true, 1);
    for (std::size_t block = 0; block < memory.block_count(); ++block) {
      const BlockView a = memory.view(block), b = whole.view(block);
      for (std::size_t i = 0; i < 9 * 9 * 9; ++i) {
        ASSERT_EQ(a.densities[i], b.densities[i]) << trial << ' ' << block << ' ' << i;
        ASSERT_EQ(a.codes == nullptr ? 0 : a.codes[i], b.codes == nullptr ? 0 : b.codes[i])
            << trial << ' ' << block << ' ' << i;
      }
    }
    std::vector<std::uint8_t> bytes(memory.bytes()), expected(bytes.size());
    memory.read(0, bytes);
    whole.read(0, expected);
    ASSERT_EQ(bytes, expected);
  }
}

TEST(VolumeMemory, RefreshesTheFacesOfTheBlocksBeforeARewrittenBlock) {
  VolumeMemory memory(kBlock);
  fill(memory, {16, 8, 8});
  memory.decode(gradient_lut(), true, 1);
  std::vector<std::uint8_t> bytes(wire::packed36_bytes(kBlockWords));
  wire::store36(bytes, 0, wire::to_word(wire::Voxel{4000, 0, 0, 0}));
  memory.write(bytes.size(), bytes);  // block 1
  memory.decode(gradient_lut(), false, 1);
  EXPECT_EQ(memory.view(0).densities[8], 4000 << 3);
  EXPECT_EQ(memory.view(0).densities[7], voxel_at(7, 0, 0).density << 3);
}

TEST(VolumeMemory, ItsCodesStandForTheLatestGradientLut) {
  VolumeMemory memory(kBlock);
  fill(memory, {8, 8, 8});
  memory.decode(gradient_lut(), true, 1);
  auto other = gradient_lut();
  for (auto& entry : other) entry = {5, 6, 7};
  memory.decode(other, true, 1);
  const BlockView view = memory.view(0);
  EXPECT_EQ(view.gradients[gradient_code(view.codes[3])].channel[1], 5 * 32);
}

}  // namespace
}  // namespace gicube::emu
