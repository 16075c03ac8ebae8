// Exchange between bodies that stand free, against closed forms and converged numbers.
#include "exchange.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "form_factors/exchange/box_factor.h"
#include "scene/program/input_error.h"
#include "test_board.h"

namespace gicube::samples {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr int kSize = 40;
constexpr double kSide = 20;  // voxels: the unit of the closed forms
constexpr double kHighest = 0.002;

// A medium in which light falls by e^-kappa over a side.
Board even_medium(double kappa) {
  Board board = reference::open_board("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64");
  const std::vector<std::byte> samples(std::size_t{kSize} * kSize * kSize, std::byte{100});
  board.load_volume({.samples = samples, .dims = {kSize, kSize, kSize}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 1 - std::exp(-kappa / kSide)}}});
  return board;
}

const Element kFloor{ElementKind::kPatch, {5, 5, 5}, {kSide, 0, 0}, {0, kSide, 0}, {}};     // looks up
const Element kCeiling{ElementKind::kPatch, {5, 5, 25}, {0, kSide, 0}, {kSide, 0, 0}, {}};  // looks down
const Element kWall{ElementKind::kPatch, {5, 5, 5}, {0, kSide, 0}, {0, 0, kSide}, {}};      // looks along +x

Exchange between(Board& board, const Element& a, const Element& b, double error = kHighest) {
  return exchange_between(board, std::span(&a, 1), std::span(&b, 1), {.error = error});
}

// Within 0.5%, and within four of its own standard errors; `digit`: half of the closed form's last one.
void expect_factor(const Exchange& exchange, double area, double expected, double digit) {
  const double factor = exchange.value / area, error = exchange.standard_error / area;
  EXPECT_NEAR(factor, expected, 0.005 * expected + digit);
  EXPECT_NEAR(factor, expected, 4 * error + digit);
  EXPECT_LT(error, 0.003 * expected);
}

struct Medium {
  double kappa;  // a side
  double parallel, perpendicular;
  double digit;
};

class ExchangeOfSquares : public testing::TestWithParam<Medium> {};

TEST_P(ExchangeOfSquares, IsTheClosedForm) {
  const auto [kappa, parallel, perpendicular, digit] = GetParam();
  Board board = even_medium(kappa);
  expect_factor(between(board, kFloor, kCeiling), kSide * kSide, parallel, digit);
  expect_factor(between(board, kFloor, kWall), kSide * kSide, perpendicular, 1.5 * digit);
}

INSTANTIATE_TEST_SUITE_P(Media, ExchangeOfSquares,
                         testing::Values(Medium{0, 0.199825, 0.200044, 5e-7}, Medium{0.1, 0.1789, 0.190, 5e-4},
                                         Medium{1, 0.0662, 0.122, 5e-4}, Medium{3, 0.0074, 0.061, 5e-4}));

// A disc as strips whose areas sum to that of the disc, around x = y = 20.
std::vector<Element> disc(double radius, double z, bool up) {
  constexpr int kStrips = 48;
  std::vector<Element> strips;
  for (int i = 0; i < kStrips; ++i) {
    const auto area_below = [&](double y) {
      return y * std::sqrt(radius * radius - y * y) + radius * radius * std::asin(y / radius);
    };
    const double low = radius * (2.0 * i / kStrips - 1), height = 2 * radius / kStrips;
    const double half = 0.5 * (area_below(std::min(low + height, radius)) - area_below(low)) / height;
    const Vec3 x{2 * half, 0, 0}, y{0, height, 0};
    strips.push_back({ElementKind::kPatch, {20 - half, 20 + low, z}, up ? x : y, up ? y : x, {}});
  }
  return strips;
}

TEST(ExchangeOfDiscs, IsTheClosedForm) {
  Board board = even_medium(0);
  constexpr double kRadius = 10, kArea = std::numbers::pi * kRadius * kRadius;
  const auto at = [&](double distance) {
    return exchange_between(board, disc(kRadius, 5, true), disc(kRadius, 5 + distance, false), {.error = kHighest});
  };
  expect_factor(at(kRadius), kArea, 0.381966, 5e-7);
  expect_factor(at(2 * kRadius), kArea, 0.171573, 5e-7);
}

Element cube(double x, double y, double z) {
  return {ElementKind::kBox, {10 + x, 10 + y, 10 + z}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

TEST(ExchangeOfVoxels, ThatTouchIsTheMeanOfTheSquareOfTheirDistance) {
  Board board = even_medium(0);
  const auto mean = [&](const Element& other) { return between(board, cube(0, 0, 0), other).value * std::numbers::pi; };
  EXPECT_NEAR(mean(cube(1, 0, 0)), 1.196, 0.005 * 1.196);
  EXPECT_NEAR(mean(cube(1, 1, 0)), 0.563, 0.005 * 0.563);
  EXPECT_NEAR(mean(cube(1, 1, 1)), 0.360, 0.005 * 0.360);
  EXPECT_NEAR(mean(cube(2, 0, 0)), 0.260, 0.005 * 0.260);
}

// Of a voxel with itself, and of two that overlap by a half: the means of BoxFactor's quadrature.
TEST(ExchangeOfVoxels, ThatOverlapIsBounded) {
  Board board = even_medium(0);
  const auto box = [](double x) { return AxisBox{{x, 0, 0}, {x + 1, 1, 1}, kMedium}; };
  for (const double x : {0.0, 0.5}) {
    const Exchange exchange = between(board, cube(0, 0, 0), cube(x, 0, 0), 0.003);
    const double expected = WayFactor(box(0), box(x)).at(0);
    EXPECT_NEAR(exchange.value, expected, 0.005 * expected) << x;
    EXPECT_NEAR(exchange.value, expected, 4 * exchange.standard_error) << x;
  }
}

TEST(Exchange, ABetterErrorIsAskedForWithMoreRaysAndCome) {
  Board board = even_medium(0);
  const Exchange coarse = between(board, kFloor, kWall, 0.02), fine = between(board, kFloor, kWall, 0.002);
  EXPECT_GT(fine.rays, coarse.rays);
  EXPECT_LT(fine.standard_error, coarse.standard_error);
  EXPECT_NEAR(coarse.value / (kSide * kSide), 0.200044, 4 * coarse.standard_error / (kSide * kSide));
}

TEST(Exchange, PatchesThatDoNotSeeEachOtherHaveNone) {
  Board board = even_medium(1);
  const Element away{ElementKind::kPatch, {5, 5, 25}, {kSide, 0, 0}, {0, kSide, 0}, {}};
  EXPECT_EQ(between(board, kFloor, away).value, 0);
  EXPECT_EQ(between(board, kFloor, kFloor).value, 0);
}

TEST(Exchange, AnElementWithoutExtentIsRefusedByName) {
  Board board = even_medium(0);
  const std::vector<Element> good{kFloor}, bad{kCeiling, {ElementKind::kPatch, {5, 5, 5}, {4, 0, 0}, {8, 0, 0}, {}}};
  EXPECT_THAT([&] { exchange_between(board, good, bad); },
              ThrowsMessage<InputError>(HasSubstr("b[1]: expected a patch of some area, got 0")));
  EXPECT_THAT(
      [&] {
        between(board, kFloor, {ElementKind::kBox, {5, 5, 5}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
      },
      ThrowsMessage<InputError>(HasSubstr("b[0]: expected a box of some volume, got 0")));
  EXPECT_THAT([&] { exchange_between(board, good, good, {.error = 0}); },
              ThrowsMessage<InputError>(HasSubstr("settings.error: expected a number above 0, got 0")));
}

}  // namespace
}  // namespace gicube::samples
