#include "gicube/scene/scene.h"

#include "test.h"

namespace gicube::scene {
namespace {

// 8 x 7 x 6 zeros.
Volume floats() {
  Volume volume;
  volume.type = SampleType::kFloat32;
  volume.dims = {8, 7, 6};
  volume.samples.resize(8 * 7 * 6 * sizeof(float));
  return volume;
}

void set(Volume& volume, int x, int y, int z, float value) {
  std::memcpy(&volume.samples[static_cast<std::size_t>((z * 7 + y) * 8 + x) * sizeof value], &value, sizeof value);
}

TransferFunctionFile above(double value) {
  return {{{{0, {1, 1, 1}}}, {{value, 0}, {value, 1}}}, TransferScale::kNormalised};
}

TEST(VisibleBox, HoldsAllVisibleVoxelsAndOneMore) {
  Volume volume = floats();
  set(volume, 2, 3, 4, 10);
  set(volume, 5, 4, 2, 8);
  set(volume, 0, 0, 0, 3);
  const SceneBox box = visible_box(volume, above(0.5));
  EXPECT_EQ(box.low, (Vec3{1, 2, 1}));
  EXPECT_EQ(box.high, (Vec3{6, 5, 5}));
}

TEST(VisibleBox, EndsAtTheVolume) {
  Volume volume = floats();
  set(volume, 0, 6, 5, 1);
  const SceneBox box = visible_box(volume, above(0.5));
  EXPECT_EQ(box.low, (Vec3{0, 5, 4}));
  EXPECT_EQ(box.high, (Vec3{1, 6, 5}));
}

TEST(VisibleBox, IsTheWholeVolumeWhereNothingIsVisible) {
  const SceneBox box = visible_box(floats(), above(0.5));
  EXPECT_EQ(box.low, (Vec3{0, 0, 0}));
  EXPECT_EQ(box.high, (Vec3{7, 6, 5}));
}

// 64^3 zeros with a ball of radius 8 round (20, 20, 20).
Volume ball() {
  Volume volume;
  volume.dims = {64, 64, 64};
  volume.samples.resize(64 * 64 * 64);
  for (int z = 12; z <= 28; ++z) {
    for (int y = 12; y <= 28; ++y) {
      for (int x = 12; x <= 28; ++x) {
        if (length(Vec3{x - 20.0, y - 20.0, z - 20.0}) <= 8)
          volume.samples[static_cast<std::size_t>(x + 64 * (y + 64 * z))] = std::byte{255};
      }
    }
  }
  return volume;
}

TEST(VisibleBox, LeavesCrumbsAndWiresOut) {
  Volume volume = ball();
  const auto set_255 = [&](int x, int y, int z) {
    volume.samples[static_cast<std::size_t>(x + 64 * (y + 64 * z))] = std::byte{255};
  };
  for (int x = 28; x < 64; ++x) set_255(x, 20, 20);  // a wire that begins in the ball
  for (int i = 0; i < 3; ++i) set_255(60, 60, 50 + i);
  for (int i = 0; i < 27; ++i) set_255(40 + i % 3, 40 + i / 3 % 3, 40 + i / 9);  // a piece of 1% of the ball
  const SceneBox box = visible_box(volume, above(0.5));
  EXPECT_EQ(box.low, (Vec3{11, 11, 11}));
  EXPECT_LE(box.high.x, 36);  // the wire's first cells
  EXPECT_EQ(box.high.y, 29);
  EXPECT_EQ(box.high.z, 29);
}

TEST(VisibleBox, HoldsLargeOtherPieces) {
  Volume volume = ball();
  for (int z = 50; z < 58; ++z) {
    for (int y = 50; y < 58; ++y) {
      for (int x = 50; x < 58; ++x) volume.samples[static_cast<std::size_t>(x + 64 * (y + 64 * z))] = std::byte{255};
    }
  }
  EXPECT_EQ(visible_box(volume, above(0.5)).high, (Vec3{58, 58, 58}));
}

TEST(ValueRangeOf, IsTheTypesRangeOrThatOfTheFiniteSamples) {
  Volume volume = floats();
  set(volume, 1, 1, 1, -3);
  set(volume, 2, 2, 2, 12);
  set(volume, 3, 3, 3, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(value_range_of(volume), (ValueRange{-3, 12}));
  volume.range = ValueRange{0, 1};
  EXPECT_EQ(value_range_of(volume), (ValueRange{0, 1}));
  volume.range.reset();
  volume.type = SampleType::kUint8;
  EXPECT_EQ(value_range_of(volume), (ValueRange{0, 255}));
}

}  // namespace
}  // namespace gicube::scene
