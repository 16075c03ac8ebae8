// Light between pairs of elements, against closed forms; rays made by the board and by the host.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

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

// Clear: the closed forms of parallel unit squares a side apart, and of perpendicular ones with a common edge. In a
// medium: converged sums in double precision (shared design's table).
TEST_P(FormFactors, AreThoseOfTwoSquares) {
  Board board = Board::open(kUri);
  fill(board, GetParam().kappa);
  const auto factors = board.pair_factors(kElements, kPairs, {.rays = 65'536});
  EXPECT_NEAR(form_factor(factors[0]), GetParam().parallel, 0.002 * GetParam().parallel + GetParam().digit);
  EXPECT_NEAR(form_factor(factors[1]), GetParam().perpendicular, 0.002 * GetParam().perpendicular + GetParam().digit);
  EXPECT_LT(factors[0].standard_error, 0.01 * factors[0].transported);
}

INSTANTIATE_TEST_SUITE_P(Media, FormFactors,
                         testing::Values(Medium{0, 0.199825, 0.200044, 5e-7}, Medium{0.1, 0.1789, 0.190, 5e-4},
                                         Medium{1, 0.0662, 0.122, 5e-4}, Medium{3, 0.0074, 0.061, 5e-4}));

Element disc(Vec3 centre, double radius, bool up, Vec3 shares = {}) {
  return {ElementKind::kDisc, centre, {radius, 0, 0}, {0, up ? radius : -radius, 0}, shares};
}
Element triangle(Vec3 a, Vec3 b, Vec3 c) { return {ElementKind::kTriangle, a, b - a, c - a, {}}; }

// Of the first disc's light, what arrives at the second (Howell, A Catalog of Radiation Heat Transfer Configuration
// Factors, C-41).
double coaxial_discs(double radius_1, double radius_2, double height) {
  const double r1 = radius_1 / height, r2 = radius_2 / height, s = 1 + (1 + r2 * r2) / (r1 * r1);
  return 0.5 * (s - std::sqrt(s * s - 4 * (r2 / r1) * (r2 / r1)));
}

TEST(DiscFactors, AreThoseOfCoaxialDiscs) {
  Board board = Board::open(kUri);
  fill(board, 0);
  board.set_empty_flags(std::vector<std::uint8_t>(board.empty_flags().size(), 0));
  for (const auto& [radius_1, radius_2, height] :
       {std::tuple{10.0, 10.0, 20.0}, {10.0, 10.0, 5.0}, {4.0, 15.0, 10.0}, {15.0, 3.0, 1.0}, {8.0, 8.0, 0.2}}) {
    const Element low = disc({20, 20, 5}, radius_1, true), high = disc({20, 20, 5 + height}, radius_2, false);
    const auto factor =
        board.pair_factors(std::array{low, high}, std::array{ElementPair{0, 1, 4}}, {.rays = 65'536})[0];
    const double found = factor.transported * M_PI * radius_2 * radius_2;
    const double expected = coaxial_discs(radius_1, radius_2, height);
    EXPECT_NEAR(found, expected, 0.001 * expected) << radius_1 << ' ' << radius_2 << ' ' << height;
    EXPECT_NEAR(factor.transported, expected / (M_PI * radius_2 * radius_2), 3 * factor.standard_error);
  }
}

TEST(DiscFactors, OfRingsAndSectorsSumToThatOfTheirDisc) {
  Board board = Board::open(kUri);
  fill(board, 0.5);
  const Element other = disc({24, 18, 12}, 8, false);
  const Element whole = disc({20, 20, 5}, 12, true);
  // The inner 0.36 of its area, and a ring in three sectors: 0.5, 0.3 and 0.2 of a turn.
  const std::vector<double> turns{0.5, 0.3, 0.2};
  std::vector<Element> elements{other, whole, disc({20, 20, 5}, 12 * 0.6, true)};
  std::vector<double> shares{0.36};
  double begin = 0;
  for (const double turn : turns) {
    const double cosine = 12 * std::cos(2 * M_PI * begin), sine = 12 * std::sin(2 * M_PI * begin);
    elements.push_back({ElementKind::kDisc, {20, 20, 5}, {cosine, sine, 0}, {-sine, cosine, 0}, {0.36, 1 - turn, 0}});
    shares.push_back(0.64 * turn);
    begin += turn;
  }
  std::vector<ElementPair> pairs;
  for (std::uint32_t i = 1; i < elements.size(); ++i) pairs.push_back({i, 0, i});
  const auto factors = board.pair_factors(elements, pairs, {.rays = 65'536});
  double sum = 0, error = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    sum += shares[i] * factors[i + 1].transported;
    error = std::hypot(error, shares[i] * factors[i + 1].standard_error);
  }
  EXPECT_NEAR(sum, factors[0].transported, 3 * std::hypot(error, factors[0].standard_error));
  EXPECT_NEAR(sum, factors[0].transported, 0.004 * sum);
}

TEST(DiscFactors, OfASmallPatchBelowThemIsThatOfADifferentialOne) {
  Board board = Board::open(kUri);
  fill(board, 0);
  const Element patch{ElementKind::kPatch, {19.9, 19.9, 5}, {0.2, 0, 0}, {0, 0.2, 0}, {}};
  const Element above = disc({20, 20, 13}, 6, false);
  const auto factor =
      board.pair_factors(std::array{patch, above}, std::array{ElementPair{0, 1, 4}}, {.rays = 65'536})[0];
  EXPECT_NEAR(factor.transported * M_PI * 36, 36.0 / (36 + 64), 0.001);
}

TEST(DiscFactors, OfEllipsesInSpaceAreThoseOfDiscs) {
  Board board = Board::open(kUri);
  const std::vector<std::byte> samples(std::size_t{kSize} * kSize * 20, std::byte{0});
  board.load_volume({.samples = samples, .dims = {kSize, kSize, 20}, .spacing = {1, 1, 2}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 0}}});
  // Circles across x, in voxels ellipses.
  const Element low{ElementKind::kDisc, {5, 20, 10}, {0, 10, 0}, {0, 0, 5}, {}};
  const Element high{ElementKind::kDisc, {25, 20, 10}, {0, 0, 5}, {0, 10, 0}, {}};
  const auto factor = board.pair_factors(std::array{low, high}, std::array{ElementPair{0, 1, 5}}, {.rays = 65'536})[0];
  const double expected = coaxial_discs(10, 10, 20);
  EXPECT_NEAR(factor.transported * M_PI * 100, expected, 0.002 * expected);
}

TEST(TriangleFactors, OfBothHalvesOfARectangleSumToThatOfTheRectangle) {
  Board board = Board::open(kUri);
  fill(board, 0.5);
  const Vec3 o{5, 5, 5}, x{kSide, 0, 0}, y{0, kSide, 0};
  const std::vector<Element> elements{kFloor, triangle(o, o + x, o + y), triangle(o + x + y, o + y, o + x), kCeiling,
                                      kWall};
  for (const std::uint32_t other : {3u, 4u}) {
    const std::array<ElementPair, 3> pairs{{{0, other, 1}, {1, other, 2}, {2, other, 3}}};
    for (const std::uint32_t rays : {1024u, 65'536u}) {
      const auto factors = board.pair_factors(elements, pairs, {.rays = rays});
      const double halves = 0.5 * (factors[1].transported + factors[2].transported);
      const double error = 0.5 * std::hypot(factors[1].standard_error, factors[2].standard_error);
      EXPECT_NEAR(halves, factors[0].transported, 3 * std::hypot(error, factors[0].standard_error)) << other;
      EXPECT_LT(error, 0.1 * halves);
    }
  }
}

// Every face sees the three others alone, and touches them.
TEST(TriangleFactors, OfATetrahedronAreMutualAndClose) {
  Board board = Board::open(kUri);
  fill(board, 0);
  const std::array<Vec3, 4> corner{{{6, 7, 5}, {33, 9, 8}, {12, 34, 6}, {16, 15, 31}}};
  std::vector<Element> faces;
  std::vector<double> areas;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 a = corner[(i + 1) % 4], b = corner[(i + 2) % 4], c = corner[(i + 3) % 4];
    const Vec3 across = cross(b - a, c - a);
    faces.push_back(dot(across, corner[i] - a) > 0 ? triangle(a, b, c) : triangle(a, c, b));
    areas.push_back(length(across) / 2);
  }
  std::vector<ElementPair> pairs;
  for (std::uint32_t a = 0; a < 4; ++a) {
    for (std::uint32_t b = 0; b < 4; ++b) {
      if (a != b) pairs.push_back({a, b, 4 * a + b});
    }
  }
  const auto factors = board.pair_factors(faces, pairs, {.rays = 4096});
  std::array<std::array<PairFactor, 4>, 4> by{};
  for (std::size_t i = 0; i < pairs.size(); ++i) by[pairs[i].a][pairs[i].b] = factors[i];
  for (std::size_t a = 0; a < 4; ++a) {
    double row = 0, error = 0;
    for (std::size_t b = 0; b < 4; ++b) {
      row += by[a][b].transported * areas[b], error += by[a][b].standard_error * areas[b];
      EXPECT_NEAR(by[a][b].transported, by[b][a].transported, 3 * (by[a][b].standard_error + by[b][a].standard_error));
    }
    EXPECT_NEAR(row, 1, 3 * error);
    EXPECT_LT(error, 0.01);
  }
}

// Parts of near pairs end where the volume does, but for a rounding.
TEST(PairFactors, OfElementsAtTheVolumesFacesAreMeasured) {
  Board board = Board::open(kUri);
  fill(board, 1);
  const double third = 1.0 / 3;
  const std::vector<Element> elements{
      {ElementKind::kPatch, {third, third, 0}, {39 - 1.1 * third, 0, 0}, {0, 39 - third, 0}, {}},
      {ElementKind::kDisc, {19.5, 0, 19.5}, {11.7, 0, 15.6}, {-15.6, 0, 11.7}, {}},
      {ElementKind::kTriangle, {0, third, third}, {0, 39 - third, 0}, {0, 0, 39 - third}, {}}};
  const std::array<ElementPair, 3> pairs{{{0, 1, 1}, {0, 2, 2}, {1, 2, 3}}};
  for (const PairRays made : {PairRays::kByBoard, PairRays::kByHost}) {
    for (const PairFactor& factor : board.pair_factors(elements, pairs, {.rays = 4096, .made = made})) {
      EXPECT_GE(factor.transported, 0);
    }
  }
}

TEST(PairFactors, AreTheSameBitsWhoeverMakesTheRaysAndOnWhateverLevel) {
  std::vector<Element> elements = kElements;
  elements.push_back(triangle({30, 30, 30}, {10, 32, 33}, {31, 9, 28}));
  elements.push_back(disc({20, 20, 4}, 3, true, {0.2, 0.3, 0}));
  const std::array<ElementPair, 4> pairs{{{0, 1, 1}, {0, 2, 2}, {4, 5, 3}, {0, 4, 4}}};
  std::vector<PairFactor> expected;
  for (const char* level : {"functional", "cycle"}) {
    Board board = Board::open(std::string(kUri) + "&fidelity=" + level);
    fill(board, 1);
    for (const PairRays made : {PairRays::kByBoard, PairRays::kByHost}) {
      const auto factors = board.pair_factors(elements, pairs, {.rays = 500, .first = 3, .seed = 9, .made = made});
      if (expected.empty()) expected = factors;
      EXPECT_EQ(factors, expected) << level << static_cast<int>(made);
    }
  }
  EXPECT_GT(expected[0].transported, 0);
  EXPECT_LT(expected[0].transported, expected[0].geometric);
}

TEST(PairFactors, SpareTheBusWhenTheBoardMakesTheRays) {
  Board board = Board::open(kUri);
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
  Board board = Board::open(kUri);
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
  Board board = Board::open(kUri);
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
  Board board = Board::open(kUri);
  fill(board, 1);
  const auto all = board.pair_factors(kElements, kPairs, {.rays = 64});
  const auto first = board.pair_factors(kElements, kPairs, {.rays = 40});
  const auto rest = board.pair_factors(kElements, kPairs, {.rays = 24, .first = 40});
  EXPECT_NEAR(all[0].transported, (40 * first[0].transported + 24 * rest[0].transported) / 64, 1e-15);
}

TEST(PairFactors, ThoseOfNearPairsAreFreshToo) {
  Board board = Board::open(kUri);
  fill(board, 1);
  const auto first = board.pair_factors(kElements, kPairs, {.rays = 64});
  const auto rest = board.pair_factors(kElements, kPairs, {.rays = 64, .first = 64});
  EXPECT_NE(first[1].transported, rest[1].transported);
  EXPECT_EQ(first[1].geometric, rest[1].geometric);
}

TEST(PairFactors, StepAndLeapAreTheRequestsWhateverWasRenderedBefore) {
  Board board = Board::open(kUri);
  fill(board, 1);
  for (const PairRays made : {PairRays::kByBoard, PairRays::kByHost}) {
    const PairRequest request{.rays = 64, .step = 0.25, .made = made};
    const auto before = board.pair_factors(kElements, kPairs, request);
    View view = front_view(kSize);
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
  Board board = Board::open(kUri);
  const std::vector<std::byte> samples(std::size_t{kSize} * kSize * 20, std::byte{0});
  board.load_volume({.samples = samples, .dims = {kSize, kSize, 20}, .spacing = {1, 1, 2}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 0}}});
  const std::array<Element, 2> squares{Element{ElementKind::kPatch, {5, 5, 4}, {kSide, 0, 0}, {0, kSide, 0}, {}},
                                       Element{ElementKind::kPatch, {5, 5, 14}, {0, kSide, 0}, {kSide, 0, 0}, {}}};
  const auto factor = board.pair_factors(squares, std::array{ElementPair{0, 1, 5}}, {.rays = 65'536})[0];
  EXPECT_NEAR(form_factor(factor), 0.199825, 4e-4);
}

TEST(PairFactors, WhatIsWrongIsNamed) {
  Board board = Board::open(kUri);
  EXPECT_THROW(board.pair_factors(kElements, kPairs), Rejected);
  fill(board, 1);
  auto elements = kElements;
  elements[1].origin.z = 39.5;
  EXPECT_THROWS(BadArgument,
                "elements[1]: expected an element in the volume, got one from (5, 5, 39.5) to (25, 25, 39.5)",
                board.pair_factors(elements, kPairs));
  elements[1] = {ElementKind::kDisc, {20, 20, 20}, {5, 0, 0}, {0, 5, 0}, {0, 1, 0}};
  EXPECT_THROWS(BadArgument, "elements[1].w: expected a disc's shares of 0 or more and below 1, got 1",
                board.pair_factors(elements, kPairs));
  elements[1] = {ElementKind::kDisc, {20, 20, 35}, {5, 0, 0}, {0, 3, 4}, {}};
  EXPECT_NO_THROW(board.pair_factors(elements, kPairs)) << "it touches z = 39";
  elements[1].origin.z = 35.5;
  EXPECT_THROWS(BadArgument, "got one from (15, 17, 31.5) to (25, 23, 39.5)", board.pair_factors(elements, kPairs));
  EXPECT_THROWS(BadArgument, "pairs[0]: expected elements below 4, got 9",
                board.pair_factors(kElements, std::array{ElementPair{0, 9, 0}}));
  EXPECT_THROWS(BadArgument, "request.rays: expected 1..65536, got 0",
                board.pair_factors(kElements, kPairs, {.rays = 0}));
  EXPECT_THROWS(BadArgument, "request.step: expected 0.015625..16, got 0",
                board.pair_factors(kElements, kPairs, {.step = 0}));
  EXPECT_TRUE(board.pair_factors(kElements, {}).empty());
}

}  // namespace
}  // namespace gicube
