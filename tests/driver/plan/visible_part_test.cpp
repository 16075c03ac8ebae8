#include "../encode/test_volume.h"
#include "gicube/level_of_detail.h"
#include "test.h"

namespace gicube {
namespace {

TestVolume<std::uint8_t> with_box(int size, int low, int high) {
  return {{size, size, size}, SampleType::kUint8, [=](int x, int y, int z) {
            const auto inside = [=](int i) { return i >= low && i <= high; };
            return inside(x) && inside(y) && inside(z) ? 200 : 20;  // noise around it
          }};
}

TransferFunction step_at(double value, double below = 0) { return {{{0, {1, 1, 1}}}, {{value, below}, {value, 0.5}}}; }

TEST(VisibleBox, HoldsAllThatCanBeSeenAndItsNeighbours) {
  const auto volume = with_box(32, 10, 17);
  const std::vector<TransferFunction> looks{step_at(100)};
  const VoxelBox box = visible_box(volume.view(), looks);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_LE(box.low[axis], 9 - 1);  // samples between the voxels 9 and 10 show; the gradient at 9 looks one further
    EXPECT_GE(box.low[axis], 9 - 1 - 4);
    EXPECT_GE(box.low[axis] + box.size[axis] - 1, 18 + 1);
    EXPECT_LE(box.low[axis] + box.size[axis] - 1, 18 + 1 + 4);
  }
}

// Between a voxel of 20 and one of 200 samples have every value between them.
TEST(VisibleBox, KeepsWhatShowsBetweenVoxelsOnly) {
  const auto volume = with_box(32, 10, 17);
  const std::vector<TransferFunction> looks{{{{0, {1, 1, 1}}}, {{100, 0}, {110, 0.5}, {120, 0}}}};
  const VoxelBox box = visible_box(volume.view(), looks);
  EXPECT_LE(box.low[0], 8);
  EXPECT_LT(box.size[0], 32);
}

TEST(VisibleBox, IsTheWholeVolumeIfNothingOrEverythingShows) {
  const auto volume = with_box(16, 5, 8);
  const Dims whole{16, 16, 16};
  EXPECT_EQ(visible_box(volume.view(), std::vector{step_at(250)}).size, whole);
  EXPECT_EQ(visible_box(volume.view(), std::vector{step_at(100, 0.1)}).size, whole);
}

TEST(VoxelsAPixel, CountsWhereTheBoxIsNearest) {
  View view;
  view.eye = {8, 8, -100};
  view.look_at = {8, 8, 8};
  view.fov_degrees = 90;
  view.height = 100;
  const VoxelBox box{{}, {17, 17, 17}};
  EXPECT_NEAR(voxels_a_pixel(view, box, {1, 1, 1}), 2 * 100 / 100.0, 1e-12);  // tan 45 is 1, 100 voxels away
  EXPECT_NEAR(voxels_a_pixel(view, box, {2, 2, 2}), 2, 1e-12);                // nothing but the edges' ratio counts
  EXPECT_NEAR(voxels_a_pixel(view, box, {1, 1, 3}), 6, 1e-12);                // three times as far
  view.orthographic_height = 50;
  EXPECT_NEAR(voxels_a_pixel(view, box, {1, 1, 1}), 0.5, 1e-12);
  view.orthographic_height = 0;
  view.eye = {8, 8, 4};
  EXPECT_EQ(voxels_a_pixel(view, box, {1, 1, 1}), 0);
}

TEST(LevelForPixels, HasVoxelsThatAreNotLargerThanAPixel) {
  EXPECT_EQ(level_for(0.3), 0);
  EXPECT_EQ(level_for(1.9), 0);
  EXPECT_EQ(level_for(2), 1);
  EXPECT_EQ(level_for(7.9), 2);
  EXPECT_EQ(level_for(8), 3);
}

}  // namespace
}  // namespace gicube
