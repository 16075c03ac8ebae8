#include "functional/simd/splat_pieces.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "gicube/wire/ray.h"
#include "instruction_sets.h"
#include "memory/sum_memory.h"

namespace gicube::emu {
namespace {

constexpr int kVoxels = 8;
constexpr std::size_t kRow = kVoxels + 1, kWords = kRow * kRow * kRow;
constexpr std::int32_t kLast = kVoxels * wire::kVoxel - 1;  // the last place in the block

// A piece that stays in the block: from one place of it towards another.
Piece random_piece(std::mt19937& random, std::int32_t amount) {
  std::uniform_int_distribution<std::int32_t> place(0, kLast);
  std::uniform_int_distribution<std::uint32_t> count(1, 37);
  Piece piece{.count = count(random), .amount = amount};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    piece.first[axis] = place(random);
    piece.step[axis] = (place(random) - piece.first[axis]) / static_cast<std::int32_t>(piece.count);
  }
  if (piece.count % 2 == 0) return piece;
  for (std::size_t axis = 0; axis < 3;
       ++axis) {  // of the wide datapath: below a step's unit, which is one less for that
    if (piece.step[axis] <= 0) continue;
    piece.rest[axis] = static_cast<std::uint16_t>(random());
    piece.step_rest[axis] = static_cast<std::uint16_t>(random());
    --piece.step[axis];
  }
  return piece;
}

std::vector<std::int64_t> words_of(const std::vector<std::int64_t>& pairs) {
  std::vector<std::int64_t> words(kWords);
  for (std::size_t i = 0; i + 1 < kWords; ++i) {
    const auto low = static_cast<std::int32_t>(static_cast<std::uint64_t>(pairs[i]));
    words[i] += low;
    words[i + 1] += (pairs[i] - low) >> 32;
  }
  return words;
}

TEST(SplatPieces, VectorsLeaveWhatOneSampleAfterTheOtherLeaves) {
  std::mt19937 random(5);
  constexpr std::int32_t kInVectors = (1 << 17) - 1;  // the largest whose products have 32 bits
  for (const std::int32_t amount : {1, -1, 999, -54'321, kInVectors, -kInVectors, kInVectors + 1, -kInVectors - 1,
                                    wire::kMaxAmount, -wire::kMaxAmount}) {
    std::vector<Piece> pieces;
    for (int i = 0; i < 20; ++i) pieces.push_back(random_piece(random, amount));
    std::vector<std::int64_t> expected(kWords);
    splat_to_words(pieces, expected.data(), kRow, kRow * kRow);
    std::int64_t sum = 0, left = 0;
    for (const std::int64_t word : expected) sum += word;
    for (const Piece& piece : pieces) left += std::int64_t{amount} * piece.count;
    ASSERT_EQ(sum, left);
    on_every_target([&] {
      std::vector<std::int64_t> pairs(kWords);
      splat(pieces, pairs.data(), kRow, kRow * kRow);
      EXPECT_EQ(words_of(pairs), expected) << amount;
    });
    std::vector<std::int64_t> pairs(kWords);
    splat_one_by_one(pieces, pairs.data(), kRow, kRow * kRow);
    EXPECT_EQ(words_of(pairs), expected) << amount;
  }
}

}  // namespace
}  // namespace gicube::emu
