#include "encode/volume/samples.h"

#include "refusal.h"
#include "test.h"
#include "test_volume.h"

namespace gicube {
namespace {

constexpr int kMax = 64;
const float kNan = std::numeric_limits<float>::quiet_NaN();

TestVolume<std::uint8_t> bytes(Dims dims) {
  return {dims, SampleType::kUint8, [](int x, int y, int z) { return x + y + z; }};
}

// The refusal of an otherwise good 4 x 3 x 2 volume after `edit`.
template <typename Edit>
std::string refusal_after(Edit&& edit) {
  const auto volume = bytes({4, 3, 2});
  VolumeView view = volume.view();
  edit(view);
  return refusal([&view] { check_volume(view, kMax); });
}

TEST(VolumeCheck, AcceptsWhatVolumeHSaysIsGood) {
  const std::vector<float> gradients(72, 0.5f);
  const std::vector<std::uint8_t> tags(24, 3);
  EXPECT_EQ(refusal_after([&](VolumeView& view) {
              view.spacing = {1, 64, 3};
              view.range = ValueRange{-1, 1};
              view.gradients = gradients;
              view.tags = tags;
            }),
            "accepted");
}

TEST(VolumeCheck, RefusesSizesTheBoardCannotHold) {
  EXPECT_EQ(refusal_after([](VolumeView& view) { view.dims = {4, 1, 6}; }), "dims[1]: expected 2..64, got 1");
  EXPECT_EQ(refusal_after([](VolumeView& view) { view.dims = {65, 2, 2}; }), "dims[0]: expected 2..64, got 65");
  EXPECT_EQ(refusal_after([](VolumeView& view) { view.dims = {4, 3, -2}; }), "dims[2]: expected 2..64, got -2");
}

TEST(VolumeCheck, RefusesAWrongAmountOfData) {
  EXPECT_EQ(refusal_after([](VolumeView& view) { view.type = SampleType::kInt16; }),
            "samples: expected 48 bytes (4 x 3 x 2 of int16), got 24");
  EXPECT_EQ(refusal_after([](VolumeView& view) { view.samples = {}; }),
            "samples: expected 24 bytes (4 x 3 x 2 of uint8), got 0");
  EXPECT_EQ(refusal_after([](VolumeView& view) { view.type = static_cast<SampleType>(9); }),
            "type: expected a SampleType, got 9");
  const std::vector<float> gradients(71);
  EXPECT_EQ(refusal_after([&](VolumeView& view) { view.gradients = gradients; }),
            "gradients: expected none or 72 floats, 3 per voxel, got 71");
  const std::vector<std::uint8_t> tags(25);
  EXPECT_EQ(refusal_after([&](VolumeView& view) { view.tags = tags; }),
            "tags: expected none or 24, one per voxel, got 25");
}

TEST(VolumeCheck, RefusesSpacingThatIsNoBox) {
  EXPECT_EQ(refusal_after([](VolumeView& view) { view.spacing.y = 0; }),
            "spacing.y: expected a finite length above 0, got 0");
  EXPECT_EQ(refusal_after([](VolumeView& view) { view.spacing.z = kNan; }),
            "spacing.z: expected a finite length above 0, got nan");
  EXPECT_EQ(refusal_after([](VolumeView& view) { view.spacing.x = -1; }),
            "spacing.x: expected a finite length above 0, got -1");
  EXPECT_EQ(refusal_after([](VolumeView& view) {
              view.spacing = {1, 2, 64.5};
            }),
            "spacing.z: expected at most 64 times the smallest edge 1, got 64.5");
}

TEST(VolumeCheck, RefusesARangeThatDoesNotRise) {
  EXPECT_EQ(refusal_after([](VolumeView& view) {
              view.range = ValueRange{3, 3};
            }),
            "range.high: expected above range.low, 3, got 3");
  EXPECT_EQ(refusal_after([](VolumeView& view) {
              view.range = ValueRange{kNan, 3};
            }),
            "range.low: expected -1e+300..1e+300, got nan");
  EXPECT_EQ(refusal_after([](VolumeView& view) {
              view.range = ValueRange{0, std::numeric_limits<double>::infinity()};
            }),
            "range.high: expected -1e+300..1e+300, got inf");
}

TEST(VolumeCheck, NamesTheFirstVoxelThatIsWrong) {
  TestVolume<std::uint16_t> twelve({4, 3, 2}, SampleType::kUint12, [](int, int, int) { return 4095; });
  EXPECT_EQ(refusal([&] { check_volume(twelve.view(), kMax); }), "accepted");
  twelve.samples[twelve.index(1, 2, 1)] = twelve.samples.back() = 4096;
  EXPECT_EQ(refusal([&] { check_volume(twelve.view(), kMax); }),
            "samples at voxel (1, 2, 1): expected 0..4095, got 4096");

  TestVolume<float> real({4, 3, 2}, SampleType::kFloat32, [](int, int, int) { return 1e38; });
  EXPECT_EQ(refusal([&] { check_volume(real.view(), kMax); }), "accepted");
  real.samples[real.index(3, 0, 1)] = kNan;
  EXPECT_EQ(refusal([&] { check_volume(real.view(), kMax); }),
            "samples at voxel (3, 0, 1): expected a finite number, got nan");
  real.samples[real.index(2, 0, 0)] = -std::numeric_limits<float>::infinity();
  EXPECT_EQ(refusal([&] { check_volume(real.view(), kMax); }),
            "samples at voxel (2, 0, 0): expected a finite number, got -inf");
}

TEST(VolumeCheck, NamesTheVoxelOfAWrongGradientOrTag) {
  std::vector<float> gradients(72);
  gradients[3 * 5 + 2] = kNan;
  EXPECT_EQ(refusal_after([&](VolumeView& view) { view.gradients = gradients; }),
            "gradients at voxel (1, 1, 0): expected a finite number, got nan");
  std::vector<std::uint8_t> tags(24);
  tags[23] = 4;
  EXPECT_EQ(refusal_after([&](VolumeView& view) { view.tags = tags; }),
            "tags at voxel (3, 2, 1): expected 0..3, got 4");
}

TEST(ResolveRange, HasTheDefaultOfEachType) {
  const auto value = [](int x, int y, int z) { return 10 * x + y - 3 * z; };
  EXPECT_EQ(resolve_range(bytes({2, 2, 2}).view()), (ValueRange{0, 255}));
  EXPECT_EQ(resolve_range(TestVolume<std::uint16_t>({2, 2, 2}, SampleType::kUint12, value).view()),
            (ValueRange{0, 4095}));
  EXPECT_EQ(resolve_range(TestVolume<std::int16_t>({4, 3, 2}, SampleType::kInt16, value).view()), (ValueRange{-3, 32}));
  EXPECT_EQ(resolve_range(TestVolume<float>({4, 3, 2}, SampleType::kFloat32, value).view()), (ValueRange{-3, 32}));
  const TestVolume<std::uint16_t> wide({2, 2, 2}, SampleType::kUint16, [](int x, int, int) { return x ? 65535 : 9; });
  EXPECT_EQ(resolve_range(wide.view()), (ValueRange{9, 65535}));
}

TEST(ResolveRange, TheCallersRangeWins) {
  const auto volume = bytes({2, 2, 2});
  VolumeView view = volume.view();
  view.range = ValueRange{-5, 7};
  EXPECT_EQ(resolve_range(view), (ValueRange{-5, 7}));
}

TEST(ResolveRange, AConstantVolumeStillHasARange) {
  const TestVolume<float> small({2, 2, 2}, SampleType::kFloat32, [](int, int, int) { return 2.5; });
  EXPECT_EQ(resolve_range(small.view()), (ValueRange{2.5, 3.5}));
  const TestVolume<float> huge({2, 2, 2}, SampleType::kFloat32, [](int, int, int) { return 3e38; });
  const ValueRange range = resolve_range(huge.view());
  EXPECT_LT(range.low, range.high);
}

TEST(RelativeSpacing, IsOverTheSmallestEdge) { EXPECT_EQ(relative_spacing({0.5, 0.25, 1}), (Vec3{2, 1, 4})); }

}  // namespace
}  // namespace gicube
