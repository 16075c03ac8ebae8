#include "memory/accumulator_memory.h"

#include "bare_board.h"
#include "datapath/trilinear_splat.h"
#include "gicube/wire/voxel.h"
#include "machine_rig.h"
#include "test.h"

namespace gicube::emu {
namespace {

std::int64_t sum_at(AccumulatorMemory& accumulators, int n, std::size_t block, std::size_t word) {
  std::vector<std::uint8_t> bytes(wire::packed36_bytes(static_cast<std::size_t>(n * n * n)));
  accumulators.read(block * bytes.size(), bytes);
  const std::uint64_t bits = wire::load36(bytes, word);
  return static_cast<std::int64_t>(bits << 28) >> 28;
}

TEST(Spread, SharesSumToTheAmountAndFollowTheTrilinearWeights) {
  for (const std::int32_t amount : {1, -1, 77, -4'000'003, wire::kMaxAmount, -wire::kMaxAmount}) {
    for (const std::array<std::uint32_t, 3> fraction :
         {std::array<std::uint32_t, 3>{0, 0, 0}, {8192, 8192, 8192}, {16383, 1, 5000}}) {
      const SignedShares shares = spread(amount, fraction);
      EXPECT_EQ(std::accumulate(shares.begin(), shares.end(), std::int64_t{0}), amount);
      for (std::size_t i = 0; i < 8; ++i) {
        double part = amount;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double f = fraction[axis] / double{wire::kVoxel};
          part *= (i >> axis & 1) != 0 ? f : 1 - f;
        }
        EXPECT_NEAR(shares[i], part, 2);
      }
    }
  }
}

TEST(Spread, APlaceOnAVoxelGivesItEverything) {
  EXPECT_EQ(spread(-12345, {0, 0, 0}), (SignedShares{-12345, 0, 0, 0, 0, 0, 0, 0}));
}

// All eight voxels of a deposit at the last one may be written (cache.splat_rule), but seven of them are none.
TEST(AccumulatorMemory, ADepositBesideTheLastVoxelHasNoBlockBeyondIt) {
  AccumulatorMemory accumulators(8);
  accumulators.resize({16, 16, 16});
  Deposit deposit{.voxel = {15, 15, 15}};
  deposit.shares.fill(1);
  const SharingBlocks sharing = accumulators.blocks_of(deposit);
  EXPECT_EQ(sharing.count, 1u);
  EXPECT_EQ(sharing.block[0], 7u);
}

TEST(AccumulatorMemory, APartBeyondABlocksFaceBelongsToTheNeighboursWord) {
  AccumulatorMemory accumulators(8);
  accumulators.resize({16, 16, 16});
  // Block 0's word (8, 3, 4), of its nine a row, is block 1's (0, 3, 4); (8, 8, 8) is block 7's first.
  accumulators.storage(0)[8 + 9 * (3 + 9 * 4)] = -5;
  accumulators.storage(1)[0 + 9 * (3 + 9 * 4)] = 7;
  accumulators.storage(0)[8 + 9 * (8 + 9 * 8)] = 11;
  EXPECT_EQ(sum_at(accumulators, 8, 1, 8 * (3 + 8 * 4)), 2);
  EXPECT_EQ(sum_at(accumulators, 8, 7, 0), 11);
  accumulators.moved_anywhere(std::uint64_t{1} << 40);
  const Overflow none = accumulators.settle();  // looks at all words and brings the parts together
  EXPECT_EQ(none.words, 0u);
  EXPECT_EQ(sum_at(accumulators, 8, 1, 8 * (3 + 8 * 4)), 2);
  EXPECT_EQ(sum_at(accumulators, 8, 7, 0), 11);
  EXPECT_EQ(accumulators.storage(0)[8 + 9 * (3 + 9 * 4)], 0);
}

TEST(AccumulatorMemory, ASumBeyondItsBitsIsClippedAndCounted) {
  AccumulatorMemory accumulators(8);
  accumulators.resize({8, 8, 8});
  Deposit much;
  much.shares[0] = static_cast<std::uint32_t>(-wire::kMaxAmount);
  constexpr int kTimes = 2049;  // beyond 2^34 by a little
  std::int64_t added = 0;
  for (int i = 0; i < kTimes; ++i) added += accumulators.add(much, 0);
  EXPECT_EQ(added, -std::int64_t{kTimes} * wire::kMaxAmount);
  accumulators.moved(0, static_cast<std::uint64_t>(-added));
  const Overflow overflow = accumulators.settle();
  EXPECT_EQ(overflow.words, 1u);
  EXPECT_EQ(overflow.clipped, added + wire::kMaxSum);
  EXPECT_EQ(sum_at(accumulators, 8, 0, 0), -wire::kMaxSum);
  EXPECT_EQ(accumulators.settle().words, 0u);
}

TEST(AccumulatorMemory, WordsWhosePartsTogetherAreTooLargeAreFound) {
  AccumulatorMemory accumulators(8);
  accumulators.resize({16, 8, 8});
  constexpr std::int64_t kMore = wire::kMaxSum / 2 + 10;
  for (const std::size_t block : {0u, 1u}) {
    accumulators.storage(block)[block == 0 ? 8 : 0] = kMore;  // (8, 0, 0) of the volume
    accumulators.moved(block, kMore);
  }
  EXPECT_EQ(accumulators.settle().words, 1u);
  EXPECT_EQ(sum_at(accumulators, 8, 1, 0), wire::kMaxSum);
}

// Adds 5 to word 3 of block 0.
class Later : public WaitingAdds {
 public:
  void add_to(AccumulatorMemory& accumulators) override { accumulators.storage(0)[3] += std::exchange(waits, 0); }
  void forget() override { waits = 0; }
  std::int64_t waits = 5;
};

TEST(AccumulatorMemory, WhatWaitsIsAddedBeforeWordsAreLookedAt) {
  AccumulatorMemory accumulators(8);
  accumulators.resize({8, 8, 8});
  accumulators.waiting() = std::make_unique<Later>();
  auto& later = static_cast<Later&>(*accumulators.waiting());
  EXPECT_EQ(sum_at(accumulators, 8, 0, 3), 5);
  EXPECT_EQ(sum_at(accumulators, 8, 0, 3), 5);
  later.waits = wire::kMaxSum;
  accumulators.moved(0, 5);
  EXPECT_EQ(accumulators.settle().words, 0u);  // as far as the bounds tell
  EXPECT_EQ(later.waits, wire::kMaxSum);
  accumulators.moved(0, static_cast<std::uint64_t>(wire::kMaxSum));
  EXPECT_EQ(accumulators.settle().words, 1u);
  EXPECT_EQ(later.waits, 0);
  EXPECT_EQ(sum_at(accumulators, 8, 0, 3), wire::kMaxSum);
  later.waits = 7;
  accumulators.clear();
  EXPECT_EQ(later.waits, 0);
  EXPECT_EQ(sum_at(accumulators, 8, 0, 3), 0);
}

class Sums : public testing::TestWithParam<v1::FidelityLevel> {
 protected:
  Sums() : board_(config()) {
    board_.load_volume({16, 16, 16}, [](int, int, int) { return wire::Voxel{}; });
  }

  static v1::BoardConfig config() {
    v1::BoardConfig config = config_with({"asic.block_voxels=8", "asic.max_volume_voxels=32"});
    config.set_fidelity(GetParam());
    return config;
  }
  Completion deposit(std::int32_t amount, std::size_t rays) {
    wire::Ray ray = host_ray(1, {3, 5, 0}, {0, 0, 1});
    ray.set_colour_word(15 << 16);
    ray.opacity = static_cast<std::uint32_t>(amount) & wire::kOpacityOne;
    const auto payload = BareBoard::trace_payload(
        std::vector<wire::Ray>(rays, ray), {.type = wire::RayType::kBackproject, .words = wire::SumWords::kWhole});
    return board_.wait(board_.command(payload)).completions.at(0);
  }
  // Of voxel (3, 5, z).
  std::int64_t sum(int z) {
    const std::size_t bytes = wire::packed36_bytes(512), block = static_cast<std::size_t>(z / 8) * 4;
    const Reply reply = board_.read_memory(wire::kSums.base + block * bytes, bytes);
    const std::uint64_t bits = wire::load36(reply.payload, 3 + 8 * (5 + 8 * static_cast<std::size_t>(z % 8)));
    return static_cast<std::int64_t>(bits << 28) >> 28;
  }

  BareBoard board_;
};

TEST_P(Sums, EachStepOfARayLeavesItsAmountBetweenTheVoxels) {
  const Completion completion = deposit(-1000, 2);
  ASSERT_EQ(completion.error, wire::ErrorCode::kNone);
  const auto ledger = wire::decode<wire::DepositLedger>(completion.payload);
  EXPECT_EQ(ledger, (wire::DepositLedger{2, 30, -30'000, 0, 0}));
  EXPECT_EQ(sum(0), -1000);  // 15 samples lie in the middles between 16 voxels
  for (int z = 1; z < 15; ++z) EXPECT_EQ(sum(z), -2000) << z;
  EXPECT_EQ(sum(15), -1000);
  board_.write_register(wire::reg::kControl, wire::kControlClearSums);
  EXPECT_EQ(sum(7), 0);
}

TEST_P(Sums, ACommandThatCouldRunASumOverIsRefused) {
  const Completion completion = deposit(wire::kMaxAmount, 410);  // 5 a ray at most, by command.h
  EXPECT_EQ(completion.error, wire::ErrorCode::kBadValue);
  EXPECT_EQ(std::string(completion.payload.begin(), completion.payload.end()),
            "rays: expected at most 2^34 as the largest possible change of one accumulator, got 17196644350");
  EXPECT_EQ(deposit(wire::kMaxAmount, 400).error, wire::ErrorCode::kNone);
}

TEST_P(Sums, OverflowIsReportedByTheCommandThatBringsIt) {
  std::uint64_t overflowed = 0;
  std::int64_t kept = 0, clipped = 0;
  constexpr int kCommands = 6;
  for (int i = 0; i < kCommands; ++i) {
    const Completion completion = deposit(wire::kMaxAmount, 400);
    const auto ledger = wire::decode<wire::DepositLedger>(completion.payload);
    overflowed += ledger.overflowed;
    kept += ledger.kept;
    clipped += ledger.clipped;
  }
  EXPECT_EQ(overflowed, 14u);  // of the 16, two get half as much
  EXPECT_EQ(kept + clipped, std::int64_t{wire::kMaxAmount} * 400 * 15 * kCommands);
  EXPECT_EQ(sum(7), wire::kMaxSum);
  EXPECT_EQ(sum(0), (std::int64_t{wire::kMaxAmount} - wire::kMaxAmount / 2 - 1) * 400 * kCommands);
}

TEST_P(Sums, AreNotVoxelsAndVoxelsAreNotSums) {
  deposit(1000, 1);
  wire::Ray ray = host_ray(1, {3, 5, 0}, {0, 0, 1});
  ray.set_colour_word(15 << 16);
  EXPECT_EQ(board_.trace({ray}, {.type = wire::RayType::kIntegral}).at(0).colour_word(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Levels, Sums, testing::Values(v1::functional, v1::cycle));

}  // namespace
}  // namespace gicube::emu
