#include "cone_beam/fdk.h"

#include "cone_beam/phantom/phantom.h"
#include "cone_beam/view_rays.h"
#include "open_board.h"
#include "reference/fdk.h"
#include "small_scan.h"
#include "test.h"

namespace gicube::samples {
namespace {

using reference::difference;
using std::numbers::pi;

// Of what the board makes of a scan, and of what the reference does, against the phantom.
struct Errors {
  double board = 0, reference = 0, bias = 0;
};
Errors errors(const Phantom& phantom, const ConeGeometry& geometry, const FdkSettings& settings = {}) {
  Board board = open_board();
  const Projections views = project(phantom, geometry);
  const Reconstruction made = reconstruct_fdk(board, geometry, views, settings);
  EXPECT_EQ(made.overflowed, 0u);
  const auto truth = voxels(phantom, geometry.volume);
  const auto off = difference(geometry.volume, made.values, truth, 42, 20);
  return {off.rmse, difference(geometry.volume, reference::reconstruct(geometry, views), truth, 42, 20).rmse, off.bias};
}

TEST(Fdk, AUniformSpheresMeanIsWithinAPercent) {
  const ConeGeometry geometry = small_scan(48, 90);
  Board board = open_board();
  const Reconstruction made = reconstruct_fdk(board, geometry, project(uniform_sphere(36, 0.5), geometry));
  const std::vector<double> value(made.values.size(), 0.5);
  EXPECT_NEAR(difference(geometry.volume, made.values, value, 24, 8).bias, 0, 0.005);
  EXPECT_GT(made.rays, 90u * 48 * 20);
  EXPECT_GT(made.deposits, made.rays);
  EXPECT_GT(made.board_time, 0u);
}

TEST(Fdk, IsAsGoodAsDoublePrecisionWithinATenth) {
  const ConeGeometry geometry = small_scan(48, 90);
  for (const Phantom& phantom : {high_contrast_shepp_logan(42), uniform_sphere(36, 1)}) {
    const Errors found = errors(phantom, geometry);
    EXPECT_LT(found.board, 1.1 * found.reference) << found.reference;
  }
}

TEST(Fdk, RaysAndSharpeningFollowFromPixelsAndVoxels) {
  using testing::DoubleNear;
  ConeGeometry geometry = small_scan(20, 4);
  const auto pixels = [&](double wide, double high) {  // in voxels, at the axis
    geometry.detector.pitch_u = 2 * 4.5 * wide;
    geometry.detector.pitch_v = 2 * 4.5 * high;
    return rays_of({}, geometry);
  };
  EXPECT_EQ(pixels(0.69, 0.69), (PixelRays{1, 1}));
  EXPECT_EQ(pixels(0.69, 0.71), (PixelRays{1, 2}));
  EXPECT_EQ(pixels(0.71, 0.69), (PixelRays{1, 2}));
  EXPECT_EQ(pixels(0.89, 0.54), (PixelRays{1, 1}));
  EXPECT_EQ(pixels(0.91, 0.54), (PixelRays{2, 1}));
  EXPECT_EQ(pixels(2.5, 2.6), (PixelRays{2, 3}));
  EXPECT_EQ(pixels(2.6, 1), (PixelRays{3, 2}));
  EXPECT_EQ(pixels(9, 9), (PixelRays{4, 4}));
  EXPECT_EQ(rays_of({.rays = 1}, geometry), (PixelRays{1, 1}));
  EXPECT_THAT(sharpening_of({}, geometry), ElementsAre(0.1, 0.1, 1.0 / 12));

  pixels(0.5, 0.8);
  geometry.volume.spacing.y *= 0.5;
  EXPECT_THAT(sharpening_of({.rays = 1}, geometry),
              ElementsAre(DoubleNear(0.9375 / 12, 1e-12), DoubleNear(0, 1e-12), DoubleNear(0.36 / 12, 1e-12)));
  EXPECT_THAT(sharpening_of({.sharpen = 0.1}, geometry), testing::Each(0.1));
}

// Values between pixels are those of Catmull and Rom's cubics.
TEST(Fdk, RaysBetweenPixelsHaveTheValuesOfCubics) {
  const ConeGeometry geometry = small_scan(16, 4);
  Projections views{16, 16, std::vector<float>(1024)};
  const auto filtered = [&](int fine) {
    return filtered_view(views, geometry, 0, ramp_filter(geometry, Window::kRamLak), {fine, fine});
  };
  for (std::size_t i = 0; i < 256; ++i) views.values[i] = static_cast<float>(i / 16 * (i / 16)) * (i % 16 == 8 ? 1 : 0);
  const std::vector<double> one = filtered(1), four = filtered(4);
  // Down the rows of a column, but for the weights that rays have by their place.
  const auto bare = [&](const std::vector<double>& view, int fine, std::size_t row, std::size_t column) {
    const double at = fine, u = u_of(geometry.detector, (double(column) + 0.5) / at - 0.5),
                 v = v_of(geometry.detector, (double(row) + 0.5) / at - 0.5);
    return view[row * 16 * static_cast<std::size_t>(fine) + column] * at * at / slant(800, u, v);
  };
  const auto pixel = [&](std::size_t row, std::size_t column) { return bare(one, 1, row, column); };
  // Of four rays a pixel, ray 29 lies 1/8 before the middle of pixel 7.
  // Their two middle pixels, and slopes there of half the difference of a pixel's neighbours.
  const double t = 7.0 / 8, h = t * t * (3 - 2 * t), first = t * (1 - t) * (1 - t) / 2, second = t * t * (1 - t) / 2;
  const double w[]{-first, 1 - h + second, h + first, -second};
  double wanted = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) wanted += w[j] * w[i] * pixel(5 + j, 5 + i);
  }
  EXPECT_NEAR(bare(four, 4, 29, 29), wanted, 1e-9 * std::abs(wanted));
}

TEST(Fdk, MoreRaysAndSmallerStepsChangeLittle) {
  const ConeGeometry geometry = small_scan(32, 60);
  const Phantom head = high_contrast_shepp_logan(42);
  const double once = errors(head, geometry).board;
  EXPECT_NEAR(errors(head, geometry, {.rays = 2}).board, once, 0.03 * once);
  EXPECT_NEAR(errors(head, geometry, {.step = 0.5}).board, once, 0.03 * once);
}

TEST(Fdk, WindowsSmoothAsTheySay) {
  const ConeGeometry geometry = small_scan(32, 60);
  const Projections views = project(high_contrast_shepp_logan(42), geometry);
  const auto roughness = [&](Window window) {
    Board board = open_board();
    const auto made = reconstruct_fdk(board, geometry, views, {.window = window});
    double sum = 0;
    for (std::size_t i = 1; i < made.values.size(); ++i) sum += std::pow(made.values[i] - made.values[i - 1], 2);
    return sum;
  };
  const double sharp = roughness(Window::kRamLak), middle = roughness(Window::kSheppLogan),
               soft = roughness(Window::kHann);
  EXPECT_GT(sharp, middle);
  EXPECT_GT(middle, soft);
}

TEST(Fdk, ShortScansOffsetDetectorsAndLongVoxelsAreAsGood) {
  const Phantom head = high_contrast_shepp_logan(38);
  ConeGeometry part = small_scan(48, 70, pi + 2 * std::atan(100.0 / 800));
  Errors found = errors(head, part);
  EXPECT_LT(found.board, 1.12 * found.reference) << "short scan";
  EXPECT_NEAR(found.bias, 0, 0.01);

  ConeGeometry moved = small_scan(48, 90);
  moved.detector.offset_u = 5.3;
  moved.detector.offset_v = -4.1;
  found = errors(head, moved);
  EXPECT_LT(found.board, 1.12 * found.reference) << "offset";

  ConeGeometry flat = small_scan(48, 90);
  flat.volume = {{48, 40, 24}, {1.9, 2.2, 3.8}};
  found = errors(head, flat);
  EXPECT_LT(found.board, 1.15 * found.reference) << "long voxels";
  EXPECT_NEAR(found.bias, 0, 0.01);
}

TEST(Fdk, ARotatedPhantomIsRotatedTheRightWay) {
  const ConeGeometry geometry = small_scan(32, 60);
  const Phantom ball{{1, {8, 8, 8}, {15, 5, -12}, 0}};
  Board board = open_board();
  const auto made = reconstruct_fdk(board, geometry, project(ball, geometry));
  Vec3 centre;
  double mass = 0;
  for (std::size_t i = 0; i < made.values.size(); ++i) {
    if (made.values[i] < 0.5F) continue;
    const std::size_t row = i / 32, slice = row / 32;
    const Vec3 voxel{static_cast<double>(i % 32), static_cast<double>(row % 32), static_cast<double>(slice)};
    centre = centre + to_space(geometry.volume, voxel);
    ++mass;
  }
  centre = (1 / mass) * centre;
  EXPECT_NEAR(centre.x, 15, 1);
  EXPECT_NEAR(centre.y, 5, 1);
  EXPECT_NEAR(centre.z, -12, 1);
}

TEST(Fdk, TheCycleLevelMakesTheSameBits) {
  const ConeGeometry geometry = small_scan(16, 6);
  const Projections views = project(high_contrast_shepp_logan(42), geometry);
  Board functional = open_board(), cycle = open_board("&fidelity=cycle&set=asic.processors=3");
  const auto one = reconstruct_fdk(functional, geometry, views), other = reconstruct_fdk(cycle, geometry, views);
  EXPECT_EQ(one.values, other.values);
  EXPECT_EQ(one.deposits, other.deposits);
  EXPECT_GT(other.board_time, one.board_time / 100);
}

TEST(Fdk, WhatIsWrongIsNamed) {
  const ConeGeometry geometry = small_scan(16, 8);
  const Projections views = project(uniform_sphere(30, 1), geometry);
  Board board = open_board();
  EXPECT_THROWS(BadArgument, "rays: expected 0..4, got 5", reconstruct_fdk(board, geometry, views, {.rays = 5}));
  EXPECT_THROWS(BadArgument, "step", reconstruct_fdk(board, geometry, views, {.step = 20}));
  ConeGeometry other = geometry;
  other.angles.pop_back();
  EXPECT_THROWS(BadArgument, "projections", reconstruct_fdk(board, other, views));
}

}  // namespace
}  // namespace gicube::samples
