#include "cone_beam/fdk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cone_beam/phantom/phantom.h"
#include "cone_beam/view_rays.h"
#include "open_board.h"
#include "reference/fdk.h"
#include "small_scan.h"

namespace gicube::samples {
namespace {

using reference::difference;
using std::numbers::pi;
using testing::HasSubstr;
using testing::ThrowsMessage;

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
  EXPECT_THAT([&] { reconstruct_fdk(board, geometry, views, {.rays = 5}); },
              ThrowsMessage<BadArgument>(HasSubstr("rays: expected 1..4, got 5")));
  EXPECT_THAT([&] { reconstruct_fdk(board, geometry, views, {.step = 20}); },
              ThrowsMessage<BadArgument>(HasSubstr("step")));
  ConeGeometry other = geometry;
  other.angles.pop_back();
  EXPECT_THAT([&] { reconstruct_fdk(board, other, views); }, ThrowsMessage<BadArgument>(HasSubstr("projections")));
}

TEST(ClippedRay, RunsFromFaceToFaceOfTheVolume) {
  const Grid grid{{11, 21, 31}, {2, 1, 1}};
  const HostRay ray = clipped_ray(grid, {-100, 0, 0}, {100, 0, 0});
  EXPECT_NEAR(ray.position.x, 0, 1e-12);
  EXPECT_NEAR(ray.position.y, 10, 1e-12);
  EXPECT_NEAR(ray.length, 10, 1e-12);
  EXPECT_EQ(clipped_ray(grid, {-100, 0, 16}, {100, 0, 16}).length, 0);
  EXPECT_EQ(clipped_ray(grid, {-100, 40, 0}, {100, 30, 0}).length, 0);
}

}  // namespace
}  // namespace gicube::samples
