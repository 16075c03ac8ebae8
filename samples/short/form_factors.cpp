// Form factors from pairs of elements [P §5.6]: the share of one square's diffuse light that arrives at another one,
// with and without a ball between them.
//
// The board makes rays between random points of two elements and measures the transmittance of each. The picture shows
// the light of a small square lamp on a floor with the soft shadow of the ball, one form factor per part of the floor.
//
//   c++ -std=c++20 -O2 form_factors.cpp $(pkg-config --cflags --libs gicube) -o form_factors
//   ./form_factors
//
// Writes form_factors.ppm. Prints both form factors and their errors against the closed form (Howell's catalogue, C-11)
// and against a sum over points with exact visibility. Returns 1 if an error is above 1%.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "picture.h"
#include "voxels.h"

using gicube::Vec3;
using std::numbers::pi;

constexpr int kSize = 64;                            // voxels along each edge
constexpr double kLow = 11.5, kHigh = 51.5;          // the floor's height, and the lamp's, which shines down
constexpr double kSide = 40, kArea = kSide * kSide;  // of both squares, in voxels: a cube's opposite faces
constexpr Vec3 kBall{31.5, 31.5, 31.5};
constexpr double kRadius = 9;

// Form factor of two opposed equal squares with sides of x distances (Howell, C-11).
double opposed_squares(double x) {
  const double y = 1 + x * x;
  return 2 / (pi * x * x) *
         (std::log(y / std::sqrt(1 + 2 * x * x)) + 2 * x * std::sqrt(y) * std::atan(x / std::sqrt(y)) -
          2 * x * std::atan(x));
}

bool passes_ball(Vec3 from, Vec3 to) {
  const Vec3 way = to - from;
  const double nearest = std::clamp(dot(kBall - from, way) / dot(way, way), 0.0, 1.0);
  return length(from + nearest * way - kBall) > kRadius;
}

// Mean over n^4 pairs of points of the floor and the lamp, with exact visibility.
double factor_with_ball(int n) {
  double sum = 0;
  const auto place = [n](int i) { return kLow + (i + 0.5) * kSide / n; };
  for (int i = 0; i < n * n * n * n; ++i) {
    const Vec3 from{place(i % n), kLow, place(i / n % n)};
    const Vec3 to{place(i / n / n % n), kHigh, place(i / n / n / n)};
    const double squared = dot(to - from, to - from);
    if (passes_ball(from, to)) sum += kSide * kSide / squared / (pi * squared);  // both cosines are kSide / distance
  }
  return sum / std::pow(n, 4) * kArea;
}

int main() {
  // 0.5 at the ball's surface, more inside.
  const auto values = make_voxels({kSize, kSize, kSize}, [](Vec3 place) {
    return std::clamp(0.5 + (kRadius - length(place - kBall)) / 4, 0.0, 1.0);
  });
  auto board = gicube::Board::open("emu:");
  board.load_volume({.samples = std::as_bytes(std::span(values)),
                     .type = gicube::SampleType::kFloat32,
                     .dims = {kSize, kSize, kSize},
                     .range = gicube::ValueRange{0, 1},
                     .find_gradients = false});

  // u x v points to the front: upwards for the floor, downwards for the lamp.
  const gicube::Element floor{.origin = {kLow, kLow, kLow}, .u = {0, 0, kSide}, .v = {kSide, 0, 0}};
  const gicube::Element lamp{.origin = {kLow, kHigh, kLow}, .u = {kSide, 0, 0}, .v = {0, 0, kSide}};
  const gicube::Element squares[] = {floor, lamp};
  const gicube::ElementPair pair[] = {{.a = 0, .b = 1}};
  const auto factor = [&] { return board.pair_factors(squares, pair, {.rays = 4096})[0].transported * kArea; };

  board.set_transfer_function({.opacities = {{0, 0}}});  // nothing is visible
  const double clear = factor(), clear_exact = opposed_squares(kSide / (kHigh - kLow));
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0.5, 0}, {0.5, 1}}});
  const double blocked = factor(), blocked_exact = factor_with_ball(24);

  // The picture has a smaller lamp, so that the shadow is darker.
  constexpr int kParts = 96;  // of the floor's edge
  std::vector<gicube::Element> elements = {{.origin = {21.5, kHigh, 21.5}, .u = {20, 0, 0}, .v = {0, 0, 20}}};
  std::vector<gicube::ElementPair> pairs;
  for (std::uint32_t i = 0; i < kParts * kParts; ++i) {
    const double x = i % kParts * kSide / kParts, z = i / kParts * kSide / kParts;
    elements.push_back(
        {.origin = floor.origin + Vec3{x, 0, z}, .u = {0, 0, kSide / kParts}, .v = {kSide / kParts, 0, 0}});
    pairs.push_back({.a = i + 1, .b = 0, .id = i});
  }
  const auto factors = board.pair_factors(elements, pairs, {.rays = 256});
  const double most = std::ranges::max(factors, {}, &gicube::PairFactor::transported).transported;
  std::vector<gicube::Colour> pixels;
  for (const gicube::PairFactor& part : factors) {
    const double light = part.transported / most;
    pixels.push_back({light, 0.9 * light, 0.75 * light});
  }
  write_light("form_factors.ppm", kParts, pixels);

  const double clear_error = clear / clear_exact - 1, blocked_error = blocked / blocked_exact - 1;
  std::printf(
      "form factor %.5f (closed form %.5f, error %.2f%%), with the ball %.5f (exact visibility %.5f, error %.2f%%)\n",
      clear, clear_exact, 100 * clear_error, blocked, blocked_exact, 100 * blocked_error);
  return std::abs(clear_error) > 0.01 || std::abs(blocked_error) > 0.01;
}
