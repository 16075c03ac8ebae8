#include "encode/volume/gradients.h"

#include "test.h"
#include "test_volume.h"

namespace gicube {
namespace {

const GradientCodebook& codebook() {
  static const GradientCodebook book;
  return book;
}

// A volume whose value grows along physical direction `slope`, by |slope| a unit of length.
TestVolume<float> ramp(Vec3 slope, Vec3 spacing) {
  return {{7, 6, 5}, SampleType::kFloat32, [=](int x, int y, int z) {
            return 1000 + slope.x * spacing.x * x + slope.y * spacing.y * y + slope.z * spacing.z * z;
          }};
}

TEST(Gradients, ARampHasItsOwnDirection) {
  for (const Vec3 slope : {Vec3{1, 0, 0}, Vec3{0, -4, 0}, Vec3{0, 0, 2}, Vec3{1, 2, 4}, Vec3{-8, 4, -1}}) {
    const auto volume = ramp(slope, {1, 1, 1});
    const auto codes = gradient_codes(volume.view(), {0, 4095}, codebook(), 1);
    for (int z = 1; z < 4; ++z) {
      for (int x = 1; x < 6; ++x) EXPECT_EQ(codes[volume.index(x, 2, z)], codebook().nearest(slope));
    }
  }
}

TEST(Gradients, DirectionsArePhysicalInAnisotropicSpacing) {
  const Vec3 spacing{0.5, 1, 2};
  for (const Vec3 slope : {Vec3{1, 1, 1}, Vec3{1, 2, 4}, Vec3{-8, 4, -1}}) {
    const auto volume = ramp(slope, spacing);
    VolumeView view = volume.view();
    view.spacing = spacing;
    EXPECT_EQ(gradient_codes(view, {0, 4095}, codebook(), 1)[volume.index(3, 3, 2)], codebook().nearest(slope));
  }
}

// The filter as the book has it: 27 weights, no separation.
Vec3 plain_sobel(const auto& volume, int x, int y, int z) {
  const auto& [nx, ny, nz] = volume.dims;
  Vec3 sum;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const double value = volume.samples[volume.index(std::clamp(x + dx, 0, nx - 1), std::clamp(y + dy, 0, ny - 1),
                                                         std::clamp(z + dz, 0, nz - 1))];
        const auto smooth = [](int d) { return d == 0 ? 2.0 : 1.0; };
        sum = sum +
              value * Vec3{dx * smooth(dy) * smooth(dz), dy * smooth(dx) * smooth(dz), dz * smooth(dx) * smooth(dy)};
      }
    }
  }
  return (1.0 / 32) * sum;
}

void expect_plain_sobel(const auto& volume, unsigned threads) {
  VolumeView view = volume.view();
  view.spacing = {3, 2, 2.5};
  const ValueRange range{-10, 240};
  const auto codes = gradient_codes(view, range, codebook(), threads);
  for (int z = 0; z < volume.dims[2]; ++z) {
    for (int y = 0; y < volume.dims[1]; ++y) {
      for (int x = 0; x < volume.dims[0]; ++x) {
        const Vec3 g = plain_sobel(volume, x, y, z);
        ASSERT_EQ(codes[volume.index(x, y, z)], codebook().nearest({g.x / 1.5, g.y, g.z / 1.25}))
            << x << ' ' << y << ' ' << z;
      }
    }
  }
}

TEST(Gradients, EqualThe27WeightsEverywhereForEveryType) {
  std::mt19937 random(7);
  const auto noise = [&](int, int, int) { return random() % 251; };
  const Dims dims{9, 5, 11};
  for (const unsigned threads : {1u, 3u, 40u, 0u}) {
    expect_plain_sobel(TestVolume<std::uint8_t>(dims, SampleType::kUint8, noise), threads);
    expect_plain_sobel(TestVolume<std::uint16_t>(dims, SampleType::kUint12, noise), threads);
    expect_plain_sobel(TestVolume<std::uint16_t>(dims, SampleType::kUint16, [&](int, int, int) { return random(); }),
                       threads);
    expect_plain_sobel(TestVolume<std::int16_t>(dims, SampleType::kInt16, [&](int, int, int) { return random(); }),
                       threads);
    expect_plain_sobel(TestVolume<float>(dims, SampleType::kFloat32, noise), threads);
  }
  expect_plain_sobel(TestVolume<std::uint8_t>({2, 2, 2}, SampleType::kUint8, noise), 2);
}

TEST(Gradients, BelowAnEighthDensityAVoxelThereIsNone) {
  const auto code = [](double slope, ValueRange range) {
    const auto volume = ramp({0, slope, 0}, {1, 1, 1});
    return gradient_codes(volume.view(), range, codebook(), 1)[volume.index(3, 3, 2)];
  };
  EXPECT_EQ(code(0, {0, 4095}), 0);
  EXPECT_EQ(code(0.124, {0, 4095}), 0);
  EXPECT_EQ(code(0.126, {0, 4095}), codebook().nearest({0, 1, 0}));
  // The same slope of the value is half as many densities in a range twice as wide.
  EXPECT_EQ(code(0.248, {0, 8190}), 0);
  EXPECT_EQ(code(0.252, {0, 8190}), codebook().nearest({0, 1, 0}));
}

TEST(Gradients, ASlopeIsMeasuredOverTheSmallestEdge) {
  const auto volume = ramp({0, 0, 0.2}, {1, 1, 1});  // 0.2 a voxel
  VolumeView view = volume.view();
  EXPECT_NE(gradient_codes(view, {0, 4095}, codebook(), 1)[volume.index(3, 3, 2)], 0);
  view.spacing = {1, 1, 2};  // 0.1 an edge
  EXPECT_EQ(gradient_codes(view, {0, 4095}, codebook(), 1)[volume.index(3, 3, 2)], 0);
}

TEST(Gradients, AreNotFoundIfTheyAreNotWanted) {
  const auto volume = ramp({1, 0, 0}, {1, 1, 1});
  VolumeView view = volume.view();
  EXPECT_FALSE(gradient_codes(view, {0, 4095}, codebook(), 1).empty());
  view.find_gradients = false;
  EXPECT_TRUE(gradient_codes(view, {0, 4095}, codebook(), 1).empty());
}

TEST(Gradients, SuppliedVectorsReplaceTheFilter) {
  const auto volume = ramp({1, 0, 0}, {1, 1, 1});
  std::vector<float> gradients(3 * volume.samples.size());
  const std::size_t last = volume.samples.size() - 1;
  gradients[1] = -1e-30f;
  gradients[3 * last] = 3e38f;
  gradients[3 * last + 2] = 3e38f;
  VolumeView view = volume.view();
  view.gradients = gradients;
  view.spacing = {1, 2, 3};  // supplied vectors are physical already
  const auto codes = gradient_codes(view, {0, 4095}, codebook(), 2);
  EXPECT_EQ(codes[0], codebook().nearest({0, -1, 0}));
  EXPECT_EQ(codes[1], 0);
  EXPECT_EQ(codes[last], codebook().nearest({1, 0, 1}));
}

}  // namespace
}  // namespace gicube
