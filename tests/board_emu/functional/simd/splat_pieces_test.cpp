#include "functional/simd/splat_pieces.h"

#include "gicube/wire/ray.h"
#include "instruction_sets.h"
#include "test.h"

namespace gicube::emu {
namespace {

// A piece that stays in the tile: from one place of it towards another.
Piece random_piece(std::mt19937& random, const Tile& tile, std::int32_t amount) {
  const auto place = [&](std::size_t axis) {
    const auto voxels = static_cast<std::int32_t>(axis == 2 ? tile.depth : tile.across);
    return std::uniform_int_distribution<std::int32_t>(0, voxels * wire::kVoxel - 1)(random);
  };
  Piece piece{.count = std::uniform_int_distribution<std::uint32_t>(1, 37)(random), .amount = amount};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    piece.first[axis] = place(axis);
    piece.step[axis] = (place(axis) - piece.first[axis]) / static_cast<std::int32_t>(piece.count);
  }
  if (piece.count % 2 == 0) return piece;
  piece.wide = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {  // bits below a step's unit, which is one less for that
    if (piece.step[axis] <= 0) continue;
    piece.rest[axis] = static_cast<std::uint16_t>(random());
    piece.step_rest[axis] = static_cast<std::uint16_t>(random());
    --piece.step[axis];
  }
  return piece;
}

// Words at the place of a line of the host's cache, as cells have to be.
class Cells {
 public:
  explicit Cells(const Tile& tile) : lines_(tile.words() / 16) {}
  std::int32_t* data() { return lines_.front().words; }
  bool operator==(const Cells& other) const = default;

 private:
  struct alignas(64) Line {
    std::int32_t words[16] = {};
    bool operator==(const Line& other) const = default;
  };
  std::vector<Line> lines_;
};

constexpr Tile kTiles[] = {{8, 8}, {16, 16}, {32, 8}, {64, 2}};

TEST(SplatPieces, VectorsLeaveWhatOneSampleAfterTheOtherLeaves) {
  std::mt19937 random(5);
  constexpr std::int32_t kHalves = (1 << 15) - 1;  // the largest of 16 bits
  constexpr std::int32_t kWords = (1 << 17) - 1;   // the largest whose products have 32 bits
  std::vector<std::int32_t> amounts{1, -1, 0, 999, -21'345, -54'321, wire::kMaxAmount, -wire::kMaxAmount};
  for (const std::int32_t edge : {kHalves, kWords}) amounts.insert(amounts.end(), {edge, -edge, edge + 1, -edge - 1});
  for (const Tile& tile : kTiles) {
    std::vector<Piece> pieces;  // of different ways, one after the other, more than are splatted at once
    for (int i = 0; i < 400; ++i) {
      pieces.push_back(random_piece(random, tile, i < 100 ? kHalves - i : amounts[random() % amounts.size()]));
    }
    Cells expected(tile);
    splat_one_by_one(pieces, tile, expected.data());
    std::int64_t sum = 0, left = 0;
    for (std::size_t i = 0; i < tile.words(); ++i) sum += expected.data()[i];
    for (const Piece& piece : pieces) left += std::int64_t{piece.amount} * piece.count;
    ASSERT_EQ(sum, left);
    on_every_target([&] {
      Cells cells(tile);
      splat(pieces, tile, cells.data());
      EXPECT_TRUE(cells == expected) << tile.across;
      for (const Piece& piece : pieces) {
        Cells one(tile), alone(tile);
        splat({&piece, 1}, tile, one.data());
        splat_one_by_one({&piece, 1}, tile, alone.data());
        ASSERT_TRUE(one == alone) << tile.across << ' ' << piece.amount << ' ' << piece.count;
        if (&piece - pieces.data() > 150) break;
      }
    });
  }
}

TEST(SplatPieces, EachCellsWordGoesToItsVoxel) {
  std::mt19937 random(7);
  for (const Tile& tile : kTiles) {
    const std::size_t row = tile.across + 1, all = row * row * (tile.depth + 1);
    Cells filled(tile);
    // Two cells' words, which go to one voxel, are at most the largest number together.
    for (std::size_t i = 0; i < tile.words(); ++i) filled.data()[i] = static_cast<std::int32_t>(random()) / 8;
    std::vector<std::int64_t> before(all), expected;
    for (std::int64_t& word : before) word = static_cast<std::int64_t>(random()) << 4;
    expected = before;
    for (std::size_t i = 0; i < tile.words(); ++i) {
      const std::size_t cell = i / 8, x = cell % tile.across, y = cell / tile.across % tile.across;
      const std::size_t z = cell / tile.across / tile.across, k = i % 8;
      expected[x + (k & 1) + row * (y + (k >> 1 & 1) + row * (z + (k >> 2)))] += filled.data()[i];
    }
    const auto expect_joined = [&](auto join_cells) {
      Cells cells = filled;
      std::vector<std::int64_t> words = before;
      join_cells(tile, cells.data(), words.data());
      EXPECT_EQ(words, expected);
      EXPECT_TRUE(cells == Cells(tile));
    };
    expect_joined(join_one_by_one);
    on_every_target([&] { expect_joined(join); });
  }
}

}  // namespace
}  // namespace gicube::emu
