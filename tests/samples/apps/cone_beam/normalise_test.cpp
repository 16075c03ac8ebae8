#include "cone_beam/fdk.h"

#include "cone_beam/phantom/phantom.h"
#include "cone_beam/view_rays.h"
#include "open_board.h"
#include "small_scan.h"
#include "test.h"

namespace gicube::samples {
namespace {

// Of what is even, how uneven slices in the middle are: the ripple of rays that lie as unevenly in all views.
double ripple(const ConeGeometry& geometry, const FdkSettings& settings) {
  Board board = open_board();
  const auto made = reconstruct_fdk(board, geometry, project(uniform_sphere(40, 1), geometry), settings);
  const std::vector<float> along = profile(geometry.volume, made.values, 2, {24, 24, 0});
  double squares = 0;
  for (std::size_t z = 14; z < 34; ++z) squares += std::pow(double{along[z]} - double{along[z - 1]}, 2);
  return std::sqrt(squares / 20);
}

ConeGeometry sparse(double spacing) {
  ConeGeometry geometry = small_scan(48, 40);
  const double pitch = 2 * spacing * geometry.volume.spacing.x;
  const int pixels = static_cast<int>(200 / pitch);
  geometry.detector = {pixels, pixels, pitch, pitch};
  return geometry;
}

TEST(Normalised, RaysThatAreFarApartLeaveFewerRipples) {
  const ConeGeometry geometry = sparse(1.4);
  const double plain = ripple(geometry, {.rays = 1, .normalise = false}), divided = ripple(geometry, {.rays = 1});
  EXPECT_GT(plain, 0.05);
  EXPECT_LT(divided, 0.5 * plain);
}

TEST(Normalised, WhereRaysAreDenseNothingIsToBeDone) {
  const ConeGeometry geometry = sparse(0.5);
  Board board = open_board();
  const Projections views = project(high_contrast_shepp_logan(42), geometry);
  const auto plain = reconstruct_fdk(board, geometry, views, {.normalise = false});
  const auto divided = reconstruct_fdk(board, geometry, views);
  EXPECT_LT(compare(geometry.volume, divided.values, plain.values, {42, 20}).rmse, 0.003);
  EXPECT_EQ(divided.rays, plain.rays);
}

// Beyond the detector's edge views leave less for another reason.
TEST(Normalised, WhatSomeViewsDontSeeStaysAsItIs) {
  ConeGeometry geometry = sparse(1);
  geometry.detector.columns /= 2;
  Board board = open_board();
  const Projections views = project(uniform_sphere(40, 1), geometry);
  const auto plain = reconstruct_fdk(board, geometry, views, {.sharpen = 0, .normalise = false});
  const auto divided = reconstruct_fdk(board, geometry, views, {.sharpen = 0});
  const std::size_t row = (24 * 48 + 24) * 48;
  EXPECT_EQ(divided.values[row + 4], plain.values[row + 4]);
  EXPECT_NE(divided.values[row + 24], plain.values[row + 24]);
}

// What splatting leaves of rays that would make a volume of ones, over what they should leave: what normalise() divides
// by. Compares all voxels that are divided within 36 of the axis.
struct Difference {
  double of_slices = 0;  // RMS of the means of slices: the ripples that all views have in common
  double plain = 0;      // the same if nothing were divided
};
Difference splatted_less_factors(const ConeGeometry& geometry, int fine) {
  const Detector& d = geometry.detector;
  const Vec3 edge = geometry.volume.spacing;
  const double at_axis = geometry.source_to_axis / geometry.source_to_detector;
  const double area = d.pitch_u * d.pitch_v * at_axis * at_axis / (fine * fine) / (edge.x * edge.y * edge.z);
  std::vector<double> even;
  for_each_ray(d, {fine, fine},
               [&](double u, double v) { even.push_back(area * slant(geometry.source_to_detector, u, v)); });
  const std::vector<double> arcs = arc_weights(geometry);
  Board board = open_board();
  Projector projector = projector_of(board, geometry, 1, {fine, fine});
  Reconstruction counts, factors;
  const auto densities = [&](std::size_t view) {
    std::vector<double> out = even;
    for (double& value : out) value *= arcs[view];
    return out;
  };
  const std::vector<float> left =
      backproject(projector, std::ranges::max(even) * std::ranges::max(arcs), densities, counts);
  factors.values.assign(left.size(), 1);
  normalise(factors, geometry, {.rays = fine});
  Difference out;
  int slices = 0;
  for (std::size_t z = 0, i = 0; z < static_cast<std::size_t>(geometry.volume.dims[2]); ++z) {
    double splatted = 0, divided = 0, all = 0;
    for_each_in_slice(geometry.volume, z, [&](Vec3 at) {
      double wanted = 0;
      for (std::size_t view = 0; view < arcs.size(); ++view) {
        const double angle = geometry.angles[view], toward = at.x * std::cos(angle) + at.y * std::sin(angle);
        wanted += arcs[view] * std::pow(geometry.source_to_axis / (geometry.source_to_axis - toward), 2);
      }
      if (std::hypot(at.x, at.y) < 36 && factors.values[i] != 1) {
        splatted += double{left[i]} / wanted - 1;
        divided += double{left[i]} / wanted * double{factors.values[i]} - 1;
        ++all;
      }
      ++i;
    });
    if (all == 0) continue;
    ++slices;
    out.of_slices += std::pow(divided / all, 2);
    out.plain += std::pow(splatted / all, 2);
  }
  EXPECT_GT(slices, 20);
  out.of_slices = std::sqrt(out.of_slices / slices);
  out.plain = std::sqrt(out.plain / slices);
  return out;
}

TEST(Normalised, FactorsAreThoseOfSplattedWeights) {
  double largest = 0;
  const auto expect_same = [&largest](const ConeGeometry& geometry, int fine) {
    const Difference off = splatted_less_factors(geometry, fine);
    EXPECT_LT(off.of_slices, 0.002);
    largest = std::max(largest, off.plain);
  };
  for (const double spacing : {0.7, 1.1, 1.4}) {
    for (const int fine : {1, 2}) {
      SCOPED_TRACE(testing::Message() << spacing << ' ' << fine);
      ConeGeometry geometry = sparse(spacing);
      geometry.angles = even_angles(80, 0.1, 2 * std::numbers::pi);
      expect_same(geometry, fine);
      geometry.angles =
          even_angles(60, 0.1, 1.3 * std::numbers::pi);  // factors that depend on the direction from the axis
      geometry.volume.spacing.z *= 0.8;
      geometry.detector.offset_v = 1.3;
      expect_same(geometry, fine);
    }
  }
  EXPECT_GT(largest, 0.1);
}

}  // namespace
}  // namespace gicube::samples
