// Exchange between bodies that stand free, against closed forms and converged numbers.
#include "form_factors/exchange/box_factor.h"
#include "test.h"
#include "test_board.h"

namespace gicube::samples {
namespace {

constexpr int kSize = 40;
constexpr double kSide = 20;  // voxels: the unit of the closed forms

// A medium in which light falls by e^-kappa over a side.
Board even_medium(double kappa) {
  Board board = Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64");
  const std::vector<std::byte> samples(std::size_t{kSize} * kSize * kSize, std::byte{100});
  board.load_volume({.samples = samples, .dims = {kSize, kSize, kSize}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 1 - std::exp(-kappa / kSide)}}});
  return board;
}

const Element kFloor{ElementKind::kPatch, {5, 5, 5}, {kSide, 0, 0}, {0, kSide, 0}, {}};     // looks up
const Element kCeiling{ElementKind::kPatch, {5, 5, 25}, {0, kSide, 0}, {kSide, 0, 0}, {}};  // looks down
const Element kWall{ElementKind::kPatch, {5, 5, 5}, {0, kSide, 0}, {0, 0, kSide}, {}};      // looks along +x

// Double integrals of f f T / (pi r^2) over all pairs of both, with what their errors come to.
struct Exchange {
  double value = 0, standard_error = 0;
};
double measure(const Element& e) {
  const Vec3 across = cross(e.u, e.v);
  return e.kind == ElementKind::kPatch ? length(across) : std::abs(dot(across, e.w));
}
Exchange between(Board& board, std::vector<Element> a, const std::vector<Element>& b, std::uint32_t rays) {
  std::vector<ElementPair> pairs;
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t j = 0; j < b.size(); ++j) {
      pairs.push_back({i, static_cast<std::uint32_t>(a.size()) + j, static_cast<std::uint32_t>(pairs.size())});
    }
  }
  a.insert(a.end(), b.begin(), b.end());
  const auto factors = board.pair_factors(a, pairs, {.rays = rays});
  Exchange sum;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double scale = measure(a[pairs[i].a]) * measure(a[pairs[i].b]);
    sum.value += scale * factors[i].transported;
    sum.standard_error = std::hypot(sum.standard_error, scale * factors[i].standard_error);
  }
  return sum;
}
Exchange between(Board& board, const Element& a, const Element& b) {
  return between(board, std::vector{a}, std::vector{b}, 65'536);
}

// Within 0.5%, and within three of its own standard errors, which are at most the share `bar`; `digit`: half of the
// closed form's last one.
void expect_factor(const Exchange& exchange, double area, double expected, double digit, double bar = 0.003) {
  const double factor = exchange.value / area, error = exchange.standard_error / area;
  EXPECT_NEAR(factor, expected, 0.005 * expected + digit);
  EXPECT_NEAR(factor, expected, 3 * error + 0.001 * expected + digit);
  EXPECT_LT(error, bar * expected);
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
  // Of a near pair in a medium the bar is for rays that arrive or not, and each of its parts has 64 of them: it is
  // wide.
  const double bar = kappa >= 1 ? 0.025 : 0.003;
  expect_factor(between(board, kFloor, kWall), kSide * kSide, perpendicular, 1.5 * digit, bar);
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
    return between(board, disc(kRadius, 5, true), disc(kRadius, 5 + distance, false), 64);
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
    const Exchange exchange = between(board, cube(0, 0, 0), cube(x, 0, 0));
    const double expected = WayFactor(box(0), box(x)).at(0);
    EXPECT_NEAR(exchange.value, expected, 0.005 * expected) << x;
    EXPECT_NEAR(exchange.value, expected, 3 * exchange.standard_error) << x;
  }
}

TEST(Exchange, PatchesThatDoNotSeeEachOtherHaveNone) {
  Board board = even_medium(1);
  const Element away{ElementKind::kPatch, {5, 5, 25}, {kSide, 0, 0}, {0, kSide, 0}, {}};
  EXPECT_EQ(between(board, kFloor, away).value, 0);
  EXPECT_EQ(between(board, kFloor, kFloor).value, 0);
}

}  // namespace
}  // namespace gicube::samples
