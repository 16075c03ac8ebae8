// Parts of volumes, coarser ones, and how far these are from what they stand for.
#include "../encode/test_volume.h"
#include "gicube/error.h"
#include "gicube/level_of_detail.h"
#include "test.h"
#include "voxels.h"

namespace gicube {
namespace {

std::vector<float> values_of(const DerivedVolume& volume) {
  std::vector<float> values(volume.samples.size() / sizeof(float));
  std::memcpy(values.data(), volume.samples.data(), volume.samples.size());
  return values;
}

TransferFunction look(std::vector<OpacityPoint> opacities) { return {{{0, {1, 1, 1}}}, std::move(opacities)}; }

TEST(CoarserVolume, HoldsTheMeanOfItsOriginalsAtTheirCentre) {
  const TestVolume<std::uint8_t> volume({4, 4, 6}, SampleType::kUint8,
                                        [](int x, int y, int z) { return x + 4 * y + 16 * z; });
  const DerivedVolume coarse = coarser(volume.view(), 1);
  EXPECT_EQ(coarse.dims, (Dims{2, 2, 3}));
  EXPECT_EQ(coarse.spacing, (Vec3{2, 2, 2}));
  EXPECT_EQ(coarse.placement.edge, 2);
  EXPECT_EQ(coarse.placement.low, (Vec3{0.5, 0.5, 0.5}));
  const auto values = values_of(coarse);
  EXPECT_FLOAT_EQ(values[0], 0.5F + 4 * 0.5F + 16 * 0.5F);
  EXPECT_FLOAT_EQ(values[1 + 2 * (1 + 2 * 2)], 2.5F + 4 * 2.5F + 16 * 4.5F);
}

TEST(CoarserVolume, GoesOnBeyondTheFacesAsItIsOnThem) {
  const TestVolume<std::uint8_t> volume({5, 4, 4}, SampleType::kUint8, [](int x, int, int) { return 10 * x; });
  const DerivedVolume coarse = coarser(volume.view(), 1);
  EXPECT_EQ(coarse.dims, (Dims{3, 2, 2}));
  EXPECT_FLOAT_EQ(values_of(coarse)[2], 40);
}

TEST(CoarserVolume, TakesTheCommonestTagAndTheSumOfGivenDirections) {
  const TestVolume<std::uint8_t> volume({4, 4, 4}, SampleType::kUint8, [](int, int, int) { return 1; });
  std::vector<std::uint8_t> tags(64, 3);
  for (const int x : {0, 1}) tags[volume.index(x, 0, 0)] = 1;  // two of eight
  std::vector<float> gradients(3 * 64);
  for (std::size_t i = 0; i < 64; ++i) gradients[3 * i + i % 2] = 5;  // x and y by turns, of any length
  VolumeView view = volume.view();
  view.tags = tags;
  view.gradients = gradients;
  const DerivedVolume coarse = coarser(view, 1);
  EXPECT_EQ(coarse.tags, std::vector<std::uint8_t>(8, 3));
  EXPECT_FLOAT_EQ(coarse.gradients[0], 4);
  EXPECT_FLOAT_EQ(coarse.gradients[1], 4);
  EXPECT_FLOAT_EQ(coarse.gradients[2], 0);
}

TEST(CoarserVolume, RefusesALevelThatLeavesNoTwoVoxels) {
  const TestVolume<std::uint8_t> volume({8, 8, 8}, SampleType::kUint8, [](int, int, int) { return 1; });
  EXPECT_NO_THROW(coarser(volume.view(), 2));
  EXPECT_THROW(coarser(volume.view(), 3), BadArgument);
  EXPECT_THROW(coarser(volume.view(), 0), BadArgument);
}

// The bound is over all points: as far as any of very many can tell, and not much more than the worst of them.
TEST(LevelError, BoundsTheDifferenceAtEveryPoint) {
  std::mt19937 random(7);
  const TestVolume<std::uint8_t> volume({9, 12, 10}, SampleType::kUint8, [&](int, int, int) { return random() % 256; });
  const DerivedVolume coarse = coarser(volume.view(), 1);
  const auto fine_at = [&](int x, int y, int z) { return double(volume.samples[volume.index(x, y, z)]); };
  const auto values = values_of(coarse);
  const auto coarse_at = [&](int x, int y, int z) {
    return double(values[static_cast<std::size_t>(x + coarse.dims[0] * (y + coarse.dims[1] * z))]);
  };
  const auto sample = [](const auto& at, const Dims& dims, Vec3 p) {
    const double c[] = {p.x, p.y, p.z};
    int low[3];
    double w[3], sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double inside = std::clamp(c[i], 0.0, dims[i] - 1.0);
      low[i] = std::min(static_cast<int>(inside), dims[i] - 2);
      w[i] = inside - low[i];
    }
    for (int k = 0; k < 8; ++k) {
      const int dx = k & 1, dy = k >> 1 & 1, dz = k >> 2;
      sum += (dx != 0 ? w[0] : 1 - w[0]) * (dy != 0 ? w[1] : 1 - w[1]) * (dz != 0 ? w[2] : 1 - w[2]) *
             at(low[0] + dx, low[1] + dy, low[2] + dz);
    }
    return sum;
  };
  double worst = 0;
  for (double z = 0; z <= 9; z += 0.25) {
    for (double y = 0; y <= 11; y += 0.25) {
      for (double x = 0; x <= 8; x += 0.25) {
        const double fine = sample(fine_at, volume.dims, {x, y, z});
        const Vec3 there = 0.5 * (Vec3{x, y, z} - coarse.placement.low);
        worst = std::max(worst, std::abs(fine - sample(coarse_at, coarse.dims, there)) * 4095 / 255);
      }
    }
  }
  const LevelError error = level_error(volume.view(), coarse, {});
  EXPECT_GE(error.largest_density, worst);
  EXPECT_LE(error.largest_density, worst + 1.01);  // one unit is for rounding
  EXPECT_GT(error.rms_density, 0.1 * worst);
  EXPECT_LT(error.rms_density, worst);
}

TEST(LevelError, IsSmallWhereTheVolumeIsSmoothAndLargeForAThinSheet) {
  const TestVolume<std::uint16_t> ramp({16, 16, 16}, SampleType::kUint12,
                                       [](int x, int y, int z) { return 60 * (x + y + z); });
  const TestVolume<std::uint16_t> sheet({16, 16, 16}, SampleType::kUint12,
                                        [](int x, int, int) { return x == 7 ? 4000 : 0; });
  const std::vector<TransferFunction> opaque{look({{0, 0}, {1000, 0}, {2000, 1}})};
  const LevelError smooth = level_error(ramp.view(), coarser(ramp.view(), 1), opaque);
  EXPECT_LE(smooth.largest_density, 95);  // half a voxel at the faces, on three axes, and rounding
  EXPECT_LE(smooth.largest_opacity, 0.1);
  const LevelError thin = level_error(sheet.view(), coarser(sheet.view(), 1), opaque);
  EXPECT_GE(thin.largest_density, 2000);  // one voxel of two is left of it
  EXPECT_EQ(thin.largest_opacity, 1);
}

TEST(CroppedVolume, HasTheSameVoxelsAndSaysWhereTheyWere) {
  const TestVolume<std::uint8_t> volume({6, 5, 7}, SampleType::kUint8,
                                        [](int x, int y, int z) { return x + 6 * y + 30 * z; });
  std::vector<std::uint8_t> tags(volume.samples.size());
  for (std::size_t i = 0; i < tags.size(); ++i) tags[i] = static_cast<std::uint8_t>(i % 4);
  VolumeView view = volume.view();
  view.tags = tags;
  const DerivedVolume part = cropped(view, {{2, 1, 3}, {3, 2, 4}});
  EXPECT_EQ(part.dims, (Dims{3, 2, 4}));
  EXPECT_EQ(part.placement.low, (Vec3{2, 1, 3}));
  EXPECT_EQ(part.range, (ValueRange{0, 255}));
  for_each_voxel({3, 2, 4}, [&](int x, int y, int z) {
    const auto at = static_cast<std::size_t>(x + 3 * (y + 2 * z));
    const std::size_t from = volume.index(x + 2, y + 1, z + 3);
    EXPECT_EQ(std::to_integer<int>(part.samples[at]), volume.samples[from]);
    EXPECT_EQ(part.tags[at], tags[from]);
  });
  EXPECT_THROW(cropped(view, {{2, 1, 3}, {5, 2, 4}}), BadArgument);
}

TEST(PlacementLook, HasTheOpacityOfALongerVoxel) {
  const Placement placement{{0.5, 0.5, 0.5}, 2};
  const TransferFunction changed = placement.look(look({{0, 0}, {100, 0.5}, {200, 1}}), {0, 255});
  EXPECT_DOUBLE_EQ(changed.opacity_at(0), 0);
  EXPECT_NEAR(changed.opacity_at(100), 0.75, 1e-3);
  EXPECT_DOUBLE_EQ(changed.opacity_at(255), 1);
}

TEST(PlacementView, SeesTheSamePointsThroughTheSamePixels) {
  View view;
  view.eye = {-50, 20, 30};
  view.look_at = {10, 20, 30};
  view.orthographic_height = 40;
  view.cut_planes = {{{1, 2, 0}, 7}};
  const Placement placement{{1.5, 1.5, 1.5}, 4};
  const View moved = placement.view(view);
  EXPECT_EQ(moved.eye, (Vec3{-51.5 / 4, 18.5 / 4, 28.5 / 4}));
  EXPECT_EQ(moved.orthographic_height, 10);
  const Vec3 on_plane{7, 0, 3};  // of the original
  EXPECT_NEAR(dot(moved.cut_planes[0].normal, 0.25 * (on_plane - placement.low)), moved.cut_planes[0].offset, 1e-12);
}

TEST(PlacementView, SeesLampsAtTheSamePlaceAndAsBright) {
  View view;
  view.lamps = {{SphereLight{{9.5, 1.5, 5.5}, 8, 32}, {1, 1, 1}},
                {RectangleLight{{1.5, 1.5, 5.5}, {4, 0, 0}, {0, 8, 0}, 64}, {1, 1, 1}}};
  const View moved = Placement{{1.5, 1.5, 1.5}, 4}.view(view);
  EXPECT_EQ(moved.lamps[0].light, Light(SphereLight{{2, 0, 1}, 2, 2}));
  EXPECT_EQ(moved.lamps[1].light, Light(RectangleLight{{0, 0, 1}, {1, 0, 0}, {0, 2, 0}, 4}));
}

}  // namespace
}  // namespace gicube
