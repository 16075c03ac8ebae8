#include "memory/irradiance_memory.h"

#include "gicube/wire/bytes.h"
#include "test.h"

namespace gicube::emu {
namespace {

IrradianceMemory memory_of(const std::array<int, 3>& size, std::uint32_t most = IrradianceMemory::kPaperMost) {
  IrradianceMemory memory(8, most);
  memory.resize(size);
  return memory;
}

Deposit even(const std::array<std::int32_t, 3>& voxel, std::uint32_t share) {
  Deposit deposit;
  deposit.voxel = voxel;
  deposit.shares.fill(share);
  return deposit;
}

std::uint32_t word(const IrradianceMemory& memory, std::size_t block, std::size_t x, std::size_t y, std::size_t z) {
  const std::uint32_t* view = memory.view(block);
  return view == nullptr ? 0 : view[x + 9 * (y + 9 * z)];
}

TEST(IrradianceMemory, ADepositGoesToEveryBlockThatHoldsOneOfItsVoxels) {
  IrradianceMemory memory = memory_of({16, 16, 16});
  EXPECT_EQ(memory.blocks_of(even({3, 3, 3}, 1)).count, 1u);
  EXPECT_EQ(memory.blocks_of(even({7, 3, 3}, 1)).count, 2u);  // voxel 8 lies on the face
  EXPECT_EQ(memory.blocks_of(even({8, 3, 3}, 1)).count, 2u);
  EXPECT_EQ(memory.blocks_of(even({8, 7, 3}, 1)).count, 4u);
  EXPECT_EQ(memory.blocks_of(even({7, 7, 8}, 1)).count, 8u);
  EXPECT_EQ(memory.blocks_of(even({9, 9, 9}, 1)).count, 1u);
  EXPECT_EQ(memory.blocks_of(even({0, 0, 0}, 1)).count, 1u);
}

TEST(IrradianceMemory, SharesOfNothingReachNoBlock) {
  IrradianceMemory memory = memory_of({16, 16, 16});
  Deposit low = even({7, 3, 3}, 0);
  for (std::size_t i = 0; i < 8; i += 2) low.shares[i] = 5;  // the lower voxels along x alone
  const SharingBlocks blocks = memory.blocks_of(low);
  ASSERT_EQ(blocks.count, 1u);
  EXPECT_EQ(blocks.block[0], 0u);
}

TEST(IrradianceMemory, ACopyHoldsWhatItsVoxelHoldsAndIsCountedOnce) {
  IrradianceMemory memory = memory_of({16, 16, 16});
  const Deposited sum = memory.add(even({7, 7, 7}, 10));
  EXPECT_EQ(sum.kept, 80u);
  EXPECT_EQ(sum.clipped, 0u);
  for (std::size_t block = 0; block < 8; ++block) {
    const std::size_t x = block & 1, y = block >> 1 & 1, z = block >> 2;
    EXPECT_EQ(word(memory, block, x != 0 ? 0 : 8, y != 0 ? 0 : 8, z != 0 ? 0 : 8), 10u) << block;
  }
}

TEST(IrradianceMemory, WordsSaturateAndWhatDoesNotFitIsCountedOnce) {
  IrradianceMemory memory = memory_of({16, 16, 16});
  memory.add(even({7, 7, 7}, 2000));
  const Deposited sum = memory.add(even({7, 7, 7}, 100));
  EXPECT_EQ(sum.kept, 8u * 47);
  EXPECT_EQ(sum.clipped, 8u * 53);
  EXPECT_EQ(word(memory, 0, 8, 8, 8), 2047u);
  EXPECT_EQ(word(memory, 7, 0, 0, 0), 2047u);
}

TEST(IrradianceMemory, AWideWordTakesAllOf32Bits) {
  IrradianceMemory memory = memory_of({16, 16, 16}, IrradianceMemory::kWideMost);
  memory.add(even({3, 3, 3}, 0xFFFF'FFF0u));
  const Deposited sum = memory.add(even({3, 3, 3}, 0x20));
  EXPECT_EQ(sum.kept, 8u * 15);
  EXPECT_EQ(sum.clipped, 8u * 17);
}

TEST(IrradianceMemory, SumsDoNotDependOnWhichThreadAddsThem) {
  IrradianceMemory memory = memory_of({16, 16, 16});
  std::array<Deposited, 4> sums;
  {
    std::vector<std::jthread> threads;
    for (Deposited& sum : sums) {
      threads.emplace_back([&memory, &sum] {
        for (int i = 0; i < 300; ++i) sum += memory.add(even({7, 7, i % 8}, 3));
      });
    }
  }
  const Deposited all =
      std::accumulate(sums.begin(), sums.end(), Deposited{}, [](Deposited a, const Deposited& b) { return a += b; });
  EXPECT_EQ(all.kept + all.clipped, 4u * 300 * 24);
  IrradianceMemory again = memory_of({16, 16, 16});
  Deposited alone;
  for (int i = 0; i < 1200; ++i) alone += again.add(even({7, 7, i % 300 % 8}, 3));
  EXPECT_EQ(all.kept, alone.kept);
  for (std::size_t z = 0; z < 9; ++z) EXPECT_EQ(word(memory, 0, 8, 8, z), word(again, 0, 8, 8, z));
}

TEST(IrradianceMemory, WritingSetsTheCopiesTooAndReadingGivesWhatWasWritten) {
  IrradianceMemory memory = memory_of({16, 16, 16});
  std::vector<std::uint8_t> bytes(4 * 8 * 8 * 8);
  wire::store(std::span(bytes), 0, std::uint32_t{500});   // voxel (8, 0, 0), the first of block 1
  wire::store(std::span(bytes), 4, std::uint32_t{9000});  // beyond what 11 bits hold
  memory.write(bytes.size(), bytes);
  EXPECT_EQ(word(memory, 0, 8, 0, 0), 500u);
  EXPECT_EQ(word(memory, 1, 0, 0, 0), 500u);
  std::vector<std::uint8_t> out(8);
  memory.read(bytes.size(), out);
  EXPECT_EQ(wire::load<std::uint32_t>(out, 0), 500u);
  EXPECT_EQ(wire::load<std::uint32_t>(out, 4), 2047u);
}

TEST(IrradianceMemory, BlocksThatNoEnergyReachedTakeNoMemory) {
  IrradianceMemory memory = memory_of({64, 64, 64});
  memory.add(even({3, 3, 3}, 1));
  EXPECT_EQ(memory.stored_blocks(), 1u);
  memory.clear();
  EXPECT_EQ(memory.stored_blocks(), 0u);
}

}  // namespace
}  // namespace gicube::emu
