// Light between pairs of elements, against closed forms; rays made by the board and by the host.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "test_board.h"

namespace gicube {
namespace {

using reference::open_board;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr int kSize = 40;
constexpr double kSide = 20;  // voxels, of the squares
constexpr const char* kUri = "emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64";

// A medium in which light falls by e^-kappa over the side of a square.
void fill(Board& board, double kappa) {
  const std::vector<std::byte> samples(std::size_t{kSize} * kSize * kSize, std::byte{100});
  board.load_volume({.samples = samples, .dims = {kSize, kSize, kSize}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 1 - std::exp(-kappa / kSide)}}});
}

const Element kFloor{ElementKind::kPatch, {5, 5, 5}, {kSide, 0, 0}, {0, kSide, 0}, {}};     // looks up
const Element kCeiling{ElementKind::kPatch, {5, 5, 25}, {0, kSide, 0}, {kSide, 0, 0}, {}};  // looks down
const Element kWall{ElementKind::kPatch, {5, 5, 5}, {0, kSide, 0}, {0, 0, kSide}, {}};      // looks along +x
const Element kAway{ElementKind::kPatch, {5, 5, 25}, {kSide, 0, 0}, {0, kSide, 0}, {}};     // looks up, above all
const std::vector<Element> kElements{kFloor, kCeiling, kWall, kAway};
constexpr std::array<ElementPair, 2> kPairs{{{0, 1, 1}, {0, 2, 2}}};

double form_factor(const PairFactor& factor) { return factor.transported * kSide * kSide; }

struct Medium {
  double kappa;  // a side
  double parallel, perpendicular;
  double digit;  // half of the last one that is given
};

class FormFactors : public testing::TestWithParam<Medium> {};

// Clear: the closed forms of parallel unit squares a side apart, and of perpendicular ones with a common edge. In a medium:
// converged sums in double precision (shared design's table).
TEST_P(FormFactors, AreThoseOfTwoSquares) {
  Board board = open_board(kUri);
  fill(board, GetParam().kappa);
  const auto factors = board.pair_factors(kElements, kPairs, {.rays = 65'536});
  EXPECT_NEAR(form_factor(factors[0]), GetParam().parallel, 0.002 * GetParam().parallel + GetParam().digit);
  EXPECT_NEAR(form_factor(factors[1]), GetParam().perpendicular, 0.002 * GetParam().perpendicular + GetParam().digit);
  EXPECT_LT(factors[0].standard_error, 0.01 * factors[0].transported);
}

INSTANTIATE_TEST_SUITE_P(Media, FormFactors,
                         testing::Values(Medium{0, 0.199825, 0.200044, 5e-7}, Medium{0.1, 0.1789, 0.190, 5e-4},
                                         Medium{1, 0.0662, 0.122, 5e-4}, Medium{3, 0.0074, 0.061, 5e-4}));

TEST(PairFactors, AreTheSameBitsWhoeverMakesTheRaysAndOnWhateverLevel) {
  std::vector<PairFactor> expected;
  for (const char* level : {"functional", "cycle"}) {
    Board board = open_board(std::string(kUri) + "&fidelity=" + level);
    fill(board, 1);
    for (const PairRays made : {PairRays::kByBoard, PairRays::kByHost}) {
      const auto factors = board.pair_factors(kElements, kPairs, {.rays = 500, .first = 3, .seed = 9, .made = made});
      if (expected.empty()) expected = factors;
      EXPECT_EQ(factors, expected) << level << static_cast<int>(made);
    }
  }
  EXPECT_GT(expected[0].transported, 0);
  EXPECT_LT(expected[0].transported, expected[0].geometric);
}

TEST(PairFactors, SpareTheBusWhenTheBoardMakesTheRays) {
  Board board = open_board(kUri);
  fill(board, 1);
  const auto bus_bytes = [&](std::span<const ElementPair> pairs, PairRays made) {
    const Counters before = board.counters();
    board.pair_factors(kElements, pairs, {.rays = 1024, .made = made});
    const Counters window = board.counters() - before;
    return window.value("bus.down.bytes") + window.value("bus.up.bytes");
  };
  constexpr std::array<ElementPair, 2> kFar{{{0, 1, 1}, {0, 1, 2}}};
  EXPECT_GT(bus_bytes(kFar, PairRays::kByHost), 2u * 1024 * 2 * 32 - 4096);
  EXPECT_LT(bus_bytes(kFar, PairRays::kByBoard), 1000u);
  // The parts of a near pair.
  EXPECT_LT(10 * bus_bytes(kPairs, PairRays::kByBoard), bus_bytes(kPairs, PairRays::kByHost));
}

TEST(PairFactors, ElementsThatLookAwayGetNothingAndSendNoRay) {
  Board board = open_board(kUri);
  fill(board, 1);
  const Counters before = board.counters();
  const auto factors = board.pair_factors(kElements, std::array{ElementPair{0, 3, 1}, ElementPair{0, 0, 2}}, {});
  for (const PairFactor& factor : factors) {
    EXPECT_EQ(factor.transported, 0);
    EXPECT_EQ(factor.geometric, 0);
  }
  const Counters window = board.counters() - before;
  EXPECT_EQ(window.value("pipeline.rays"), 0u);
  EXPECT_EQ(window.value("dsp.pair_rays"), 32u);
}

TEST(PairFactors, BoxesSeeEachOtherOverTheSquareOfTheirDistance) {
  Board board = open_board(kUri);
  fill(board, 0);
  const Element near{ElementKind::kBox, {5, 5, 5}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  const Element far{ElementKind::kBox, {5, 5, 33}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  const auto factor = board.pair_factors(std::array{near, far}, std::array{ElementPair{0, 1, 0}}, {.rays = 1024})[0];
  EXPECT_NEAR(factor.transported, 1 / (M_PI * 28 * 28), 0.005 / (M_PI * 28 * 28));
  // Touching boxes of side 1: the mean of 1/r^2 is 1.196 (shared design's table).
  const Element one{ElementKind::kBox, {5, 5, 5}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Element next{ElementKind::kBox, {6, 5, 5}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto touching =
      board.pair_factors(std::array{one, next}, std::array{ElementPair{0, 1, 0}}, {.rays = 65'536})[0];
  EXPECT_NEAR(touching.transported * M_PI, 1.196, 0.005);
}

TEST(PairFactors, MoreSamplesGoOnWhereTheFirstEnded) {
  Board board = open_board(kUri);
  fill(board, 1);
  const auto all = board.pair_factors(kElements, kPairs, {.rays = 64});
  const auto first = board.pair_factors(kElements, kPairs, {.rays = 40});
  const auto rest = board.pair_factors(kElements, kPairs, {.rays = 24, .first = 40});
  EXPECT_NEAR(all[0].transported, (40 * first[0].transported + 24 * rest[0].transported) / 64, 1e-15);
}

TEST(PairFactors, ThoseOfNearPairsAreFreshToo) {
  Board board = open_board(kUri);
  fill(board, 1);
  const auto first = board.pair_factors(kElements, kPairs, {.rays = 64});
  const auto rest = board.pair_factors(kElements, kPairs, {.rays = 64, .first = 64});
  EXPECT_NE(first[1].transported, rest[1].transported);
  EXPECT_EQ(first[1].geometric, rest[1].geometric);
}

TEST(PairFactors, StepAndLeapAreTheRequestsWhateverWasRenderedBefore) {
  Board board = open_board(kUri);
  fill(board, 1);
  for (const PairRays made : {PairRays::kByBoard, PairRays::kByHost}) {
    const PairRequest request{.rays = 64, .step = 0.25, .made = made};
    const auto before = board.pair_factors(kElements, kPairs, request);
    View view = reference::front_view(kSize);
    view.step = 2, view.leap = false;
    board.render_to_framebuffer(view);
    EXPECT_EQ(board.pair_factors(kElements, kPairs, request), before);
    const Counters counters = board.counters();
    board.pair_factors(kElements, kPairs, {.rays = 64, .step = 0.5, .made = made});
    const auto at_half = (board.counters() - counters).value("pipeline.samples");
    board.pair_factors(kElements, kPairs, request);
    EXPECT_GT(10 * (board.counters() - counters).value("pipeline.samples"), 29 * at_half);
  }
}

TEST(PairFactors, AnisotropicVoxelsAreMeasuredInSpace) {
  Board board = open_board(kUri);
  const std::vector<std::byte> samples(std::size_t{kSize} * kSize * 20, std::byte{0});
  board.load_volume({.samples = samples, .dims = {kSize, kSize, 20}, .spacing = {1, 1, 2}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 0}}});
  const std::array<Element, 2> squares{Element{ElementKind::kPatch, {5, 5, 4}, {kSide, 0, 0}, {0, kSide, 0}, {}},
                                       Element{ElementKind::kPatch, {5, 5, 14}, {0, kSide, 0}, {kSide, 0, 0}, {}}};
  const auto factor = board.pair_factors(squares, std::array{ElementPair{0, 1, 5}}, {.rays = 65'536})[0];
  EXPECT_NEAR(form_factor(factor), 0.199825, 4e-4);
}

TEST(PairFactors, WhatIsWrongIsNamed) {
  Board board = open_board(kUri);
  EXPECT_THROW(board.pair_factors(kElements, kPairs), Rejected);
  fill(board, 1);
  auto elements = kElements;
  elements[1].origin.z = 39.5;
  EXPECT_THAT([&] { board.pair_factors(elements, kPairs); },
              ThrowsMessage<BadArgument>(
                  HasSubstr("elements[1]: expected its corners in the volume, got one at (5, 5, 39.5)")));
  EXPECT_THAT(
      [&] {
        board.pair_factors(kElements, std::array{ElementPair{0, 9, 0}});
      },
      ThrowsMessage<BadArgument>(HasSubstr("pairs[0]: expected elements below 4, got 9")));
  EXPECT_THAT([&] { board.pair_factors(kElements, kPairs, {.rays = 0}); },
              ThrowsMessage<BadArgument>(HasSubstr("request.rays: expected 1..65536, got 0")));
  EXPECT_THAT([&] { board.pair_factors(kElements, kPairs, {.step = 0}); },
              ThrowsMessage<BadArgument>(HasSubstr("request.step: expected 0.015625..16, got 0")));
  EXPECT_TRUE(board.pair_factors(kElements, {}).empty());
}

}  // namespace
}  // namespace gicube
