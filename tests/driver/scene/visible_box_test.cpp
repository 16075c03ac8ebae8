#include "gicube/scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

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

TransferFunctionFile above(double value) { return {{{{0, {1, 1, 1}}}, {{value, 0}, {value, 1}}}, true}; }

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
