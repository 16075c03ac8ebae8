#include "cone_beam/fdk.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cone_beam/phantom/phantom.h"
#include "open_board.h"
#include "small_scan.h"

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
  EXPECT_GE(divided.rays, 2 * plain.rays);
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

}  // namespace
}  // namespace gicube::samples
