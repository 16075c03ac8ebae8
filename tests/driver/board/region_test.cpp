// Boxes of the volume and of the irradiance, read back and written.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

constexpr Dims kDims{29, 24, 35};

std::vector<std::uint16_t> noise(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint16_t> values(count);
  for (auto& value : values) value = static_cast<std::uint16_t>(random() % 4096);
  return values;
}

VolumeView view_of(std::span<const std::uint16_t> values) {
  return {.samples = std::as_bytes(values), .type = SampleType::kUint12, .dims = kDims, .spacing = {1, 1.5, 2}};
}

std::size_t at(int x, int y, int z) { return static_cast<std::size_t>(x + kDims[0] * (y + kDims[1] * z)); }

class Regions : public ::testing::Test {
 protected:
  void SetUp() override {
    board_.load_volume(view_of(values_));
    board_.set_transfer_function(step_function(0.1));
  }
  // Writes random values into the box, here and on the board.
  void change(const VoxelBox& box, unsigned seed) {
    std::vector<float> written;
    const auto fresh = noise(static_cast<std::size_t>(box.size[0] * box.size[1] * box.size[2]), seed);
    std::size_t i = 0;
    for (int z = box.low[2]; z < box.low[2] + box.size[2]; ++z) {
      for (int y = box.low[1]; y < box.low[1] + box.size[1]; ++y) {
        for (int x = box.low[0]; x < box.low[0] + box.size[0]; ++x) {
          values_[at(x, y, z)] = fresh[i++];
          written.push_back(values_[at(x, y, z)]);
        }
      }
    }
    board_.write_volume(box, written);
  }
  static View turned_view() {
    View view = front_view(35);
    view.eye = {60, 45, -30};
    view.look_at = {14, 12, 17};
    return view;
  }

  std::vector<std::uint16_t> values_ = noise(at(0, 0, kDims[2]), 1);
  Board board_ = Board::open(kSmallBlocks);
};

TEST_F(Regions, AVolumeReadsBackAsItWasLoaded) {
  const VoxelBox box{{5, 7, 6}, {20, 3, 29}};
  const auto read = board_.read_volume(box);
  std::size_t i = 0;
  for (int z = 6; z < 35; ++z) {
    for (int y = 7; y < 10; ++y) {
      for (int x = 5; x < 25; ++x) ASSERT_EQ(read[i++], values_[at(x, y, z)]) << x << ' ' << y << ' ' << z;
    }
  }
  EXPECT_EQ(i, read.size());
}

// Values, gradients of the neighbourhood, copies on shared faces and empty flags: as if the whole had been loaded.
TEST_F(Regions, AVolumeThatWasChangedIsAsIfItHadBeenLoadedSo) {
  Board other = Board::open(kSmallBlocks);
  other.set_transfer_function(step_function(0.1));
  const std::array<VoxelBox, 5> boxes{{{{0, 0, 0}, {1, 1, 1}},
                                       {{7, 8, 15}, {2, 1, 2}},
                                       {{28, 23, 34}, {1, 1, 1}},
                                       {{3, 4, 5}, {20, 18, 21}},
                                       {{0, 0, 0}, {29, 24, 35}}}};
  for (unsigned i = 0; i < boxes.size(); ++i) {
    change(boxes[i], 100 + i);
    other.load_volume(view_of(values_));
    EXPECT_EQ(board_.read_volume({{0, 0, 0}, kDims}), other.read_volume({{0, 0, 0}, kDims})) << i;
    EXPECT_EQ(board_.empty_flags(), other.empty_flags()) << i;
    EXPECT_EQ(board_.render(turned_view()).pixels, other.render(turned_view()).pixels) << i;
  }
}

TEST_F(Regions, ClearingABoxMakesItsBlocksEmptyAgain) {
  const VoxelBox all{{0, 0, 0}, kDims};
  board_.write_volume(all, std::vector<float>(at(0, 0, kDims[2]), 0));
  for (const std::uint8_t flag : board_.empty_flags()) EXPECT_EQ(flag, 1);
}

TEST_F(Regions, IrradianceReadsBackAsItWasWritten) {
  board_.clear_irradiance(0.25);
  const VoxelBox box{{6, 0, 7}, {12, 24, 9}};
  std::vector<float> values;
  for (int i = 0; i < 12 * 24 * 9; ++i) values.push_back(0.25f * static_cast<float>(i % 2048));
  board_.write_irradiance(box, values);
  EXPECT_EQ(board_.read_irradiance(box), values);
  const auto all = board_.read_irradiance();
  EXPECT_EQ(all[at(6, 0, 7)], values[0]);
  EXPECT_EQ(all[at(5, 0, 7)], 0);
  EXPECT_EQ(all[at(17, 23, 15)], values.back());
  board_.write_irradiance({{6, 0, 7}, {1, 1, 1}}, std::array{1e9f});
  EXPECT_EQ(board_.read_irradiance({{6, 0, 7}, {1, 1, 1}}), std::vector{2047 * 0.25f});
}

TEST_F(Regions, WrittenIrradianceLightsThePicture) {
  board_.clear_irradiance(1);
  View view = turned_view();
  view.irradiance = true;
  view.exposure = 0.01;
  const Image dark = board_.render(view);
  board_.write_irradiance({{0, 0, 0}, kDims}, std::vector<float>(at(0, 0, kDims[2]), 50));
  const Image lit = board_.render(view);
  std::uint64_t before = 0, after = 0;
  for (const auto& pixel : dark.pixels) before += pixel.red;
  for (const auto& pixel : lit.pixels) after += pixel.red;
  EXPECT_EQ(before, 0u);
  EXPECT_GT(after, 1000u);
}

TEST_F(Regions, WhatDoesNotFitIsNamed) {
  EXPECT_THROWS(BadArgument, "box.size.z: expected 1..1, got 2", board_.read_volume({{0, 0, 34}, {1, 1, 2}}));
  EXPECT_THROWS(BadArgument, "values: expected 2, 1 per voxel of the box, got 1",
                board_.write_volume({{0, 0, 0}, {2, 1, 1}}, std::array{1.0f}));
  EXPECT_THROWS(BadArgument, "values[0]: expected a finite number, got nan",
                board_.write_volume({{0, 0, 0}, {1, 1, 1}}, std::array{std::nanf("")}));
  EXPECT_THROW(board_.write_irradiance({{0, 0, 0}, {1, 1, 1}}, std::array{1.0f}), Rejected);
  board_.clear_irradiance(1);
  EXPECT_THROWS(BadArgument, "values[0]: expected a finite number of at least 0, got -1",
                board_.write_irradiance({{0, 0, 0}, {1, 1, 1}}, std::array{-1.0f}));
}

}  // namespace
}  // namespace gicube
