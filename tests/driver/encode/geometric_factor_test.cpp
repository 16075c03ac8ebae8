// Light between two elements against the closed forms of the textbooks, and against plain sums over many small parts.
#include "encode/geometric_factor.h"

#include "test.h"

namespace gicube {
namespace {

using std::numbers::pi;

Element patch(Vec3 origin, Vec3 u, Vec3 v) { return {ElementKind::kPatch, origin, u, v, {}}; }
Element box(Vec3 origin, double edge) { return {ElementKind::kBox, origin, {edge, 0, 0}, {0, edge, 0}, {0, 0, edge}}; }

// Form factor of two parallel rectangles of a x b at distance c (Howell's catalogue, C-11).
double parallel(double a, double b, double c) {
  const double x = a / c, y = b / c, x2 = 1 + x * x, y2 = 1 + y * y;
  return 2 / (pi * x * y) *
         (std::log(std::sqrt(x2 * y2 / (x2 + y2 - 1))) + x * std::sqrt(y2) * std::atan(x / std::sqrt(y2)) +
          y * std::sqrt(x2) * std::atan(y / std::sqrt(x2)) - x * std::atan(x) - y * std::atan(y));
}

// Of two perpendicular rectangles with a common edge of length l, h high and w wide, from the one that is w wide
// (C-14).
double perpendicular(double h, double w, double l) {
  const double a = h / l, b = w / l, a2 = a * a, b2 = b * b, s = a2 + b2;
  return 1 / (pi * b) *
         (b * std::atan(1 / b) + a * std::atan(1 / a) - std::sqrt(s) * std::atan(1 / std::sqrt(s)) +
          0.25 * std::log((1 + a2) * (1 + b2) / (1 + s) * std::pow(b2 * (1 + s) / ((1 + b2) * s), b2) *
                          std::pow(a2 * (1 + s) / ((1 + a2) * s), a2)));
}

TEST(GeometricFactor, OfParallelRectanglesIsTheCatalogues) {
  for (const double distance : {0.5, 1.0, 2.0, 7.0}) {
    const GeometricFactor found =
        geometric_factor(patch({0, 0, 0}, {2, 0, 0}, {0, 3, 0}), patch({0, 0, distance}, {0, 3, 0}, {2, 0, 0}), true);
    const double expected = parallel(2, 3, distance) / 6;  // of both: over the other one's area
    EXPECT_NEAR(found.mean, expected, 0.004 * expected) << distance;
    EXPECT_LT(found.error, 0.05 * expected) << distance;
  }
}

TEST(GeometricFactor, OfPerpendicularRectanglesWithACommonEdgeIsTheCatalogues) {
  EXPECT_NEAR(perpendicular(1, 1, 1), 0.200044, 1e-6);
  for (const auto& [h, w, l] : {std::array{1.0, 1.0, 1.0}, {2.0, 1.0, 3.0}, {0.5, 2.0, 1.0}}) {
    const GeometricFactor found =
        geometric_factor(patch({0, 0, 0}, {l, 0, 0}, {0, w, 0}), patch({0, 0, 0}, {0, 0, h}, {l, 0, 0}), true);
    const double expected = perpendicular(h, w, l) / (h * l);
    EXPECT_NEAR(found.mean, expected, 0.02 * expected) << h << ' ' << w;
    EXPECT_GT(found.error, 0);
  }
}

TEST(GeometricFactor, IsNoneOfPatchesThatLookAwayOrLieInOnePlane) {
  const Element up = patch({0, 0, 0}, {2, 0, 0}, {0, 2, 0});
  EXPECT_EQ(geometric_factor(up, patch({0, 0, 3}, {2, 0, 0}, {0, 2, 0}), true).mean, 0) << "it looks up too";
  EXPECT_EQ(geometric_factor(up, patch({0, 0, -3}, {0, 2, 0}, {2, 0, 0}), true).mean, 0);
  EXPECT_EQ(geometric_factor(up, patch({5, 0, 0}, {2, 0, 0}, {0, 2, 0}), true).mean, 0);
  EXPECT_EQ(geometric_factor(up, patch({5, 0, 1e-6}, {0, 2, 0}, {2, 0, 0}), true).mean, 0)
      << "no higher than floats round";
  EXPECT_EQ(geometric_factor(up, patch({0, 0, 3}, {2, 0, 0}, {4, 0, 0}), true).mean, 0) << "without an area";
}

// A wall that stands half below the floor's plane gives what its upper half gives.
TEST(GeometricFactor, CountsOnlyWhatIsInFrontOfTheOther) {
  const Element floor = patch({0, 0, 0}, {3, 0, 0}, {0, 3, 0});
  const Element whole = patch({0, -1, -2}, {0, 0, 4}, {3, 0, 0}), upper = patch({0, -1, 0}, {0, 0, 2}, {3, 0, 0});
  const double all = geometric_factor(floor, whole, true).mean * 12,
               half = geometric_factor(floor, upper, true).mean * 6;
  EXPECT_GT(half, 0);
  EXPECT_NEAR(all, half, 1e-6 * half);
  EXPECT_NEAR(geometric_factor(whole, floor, true).mean * 12, half, 1e-6 * half);
}

template <typename Kernel>
double summed(const Element& a, const Element& b, int n, const Kernel& kernel) {
  double sum = 0;
  const auto places = [n](const Element& e) {
    std::vector<Vec3> out;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        for (int k = 0; k < (e.kind == ElementKind::kBox ? n : 1); ++k) {
          out.push_back(e.origin + ((i + 0.5) / n) * e.u + ((j + 0.5) / n) * e.v + ((k + 0.5) / n) * e.w);
        }
      }
    }
    return out;
  };
  const auto of_a = places(a), of_b = places(b);
  for (const Vec3 from : of_a) {
    for (const Vec3 to : of_b) sum += kernel(to - from);
  }
  return sum / static_cast<double>(of_a.size() * of_b.size()) / pi;
}

TEST(GeometricFactor, OfAPatchAndABoxIsTheMeanOfTheCosine) {
  const Element floor = patch({0, 0, 0}, {2, 0, 0}, {0, 3, 0});
  for (const Element& cube : {box({0.5, 0.5, 2}, 1), box({4, -3, 1}, 2), box({0, 0, 0}, 1)}) {
    const double expected = summed(floor, cube, 24, [](Vec3 way) { return way.z / std::pow(length(way), 3); });
    for (const GeometricFactor& found : {geometric_factor(floor, cube, true), geometric_factor(cube, floor, true)}) {
      EXPECT_NEAR(found.mean, expected, 0.02 * expected);
    }
  }
  const double above = geometric_factor(floor, box({0, 0, 1}, 1), true).mean;
  EXPECT_EQ(geometric_factor(floor, box({0, 0, -2}, 1), true).mean, 0) << "behind it";
  EXPECT_GT(above, 0);
}

TEST(GeometricFactor, OfBoxesIsTheMeanOfTheInverseSquare) {
  const auto inverse_square = [](Vec3 way) { return 1 / dot(way, way); };
  const Element cube = box({0, 0, 0}, 1);
  for (const Element& other : {box({1, 0, 0}, 1), box({1, 1, 1}, 2), box({3, -2, 4}, 1), box({0.2, 2, 0}, 0.5)}) {
    const double expected = summed(cube, other, 9, inverse_square);
    EXPECT_NEAR(geometric_factor(cube, other, true).mean, expected, 0.02 * expected);
    EXPECT_NEAR(geometric_factor(other, cube, true).mean, expected, 0.02 * expected);
  }
  const double far = summed(cube, box({9, 2, 3}, 2), 9, inverse_square);
  EXPECT_NEAR(geometric_factor(cube, box({9, 2, 3}, 2), false).mean, far, 1e-3 * far);
  EXPECT_LT(geometric_factor(cube, box({9, 2, 3}, 2), false).error, 1e-3 * far);
  // Left-handed sides bound the same box.
  Element turned = box({1, 1, 1}, 2);
  std::swap(turned.u, turned.v);
  const double expected = summed(cube, turned, 9, inverse_square);
  EXPECT_NEAR(geometric_factor(cube, turned, true).mean, expected, 0.02 * expected);
}

// Howell's catalogue C-41. Seen from half a disc of it, from a ring and the disc in it, by parts: the same.
TEST(GeometricFactor, OfCoaxialDiscsAndTheirPartsIsTheCatalogues) {
  const auto disc = [](double radius, double height, Vec3 shares) {
    return Element{ElementKind::kDisc, {1, 2, height}, {radius, 0, 0}, {0, height > 0 ? -radius : radius, 0}, shares};
  };
  for (const auto& [radius_1, radius_2, height] : {std::array{10.0, 10.0, 20.0}, {4.0, 15.0, 10.0}, {8.0, 8.0, 0.2}}) {
    const double r1 = radius_1 / height, r2 = radius_2 / height, s = 1 + (1 + r2 * r2) / (r1 * r1);
    const double factor = (s - std::sqrt(s * s - 4 * (r2 / r1) * (r2 / r1))) / 2;
    const double expected = factor / (std::numbers::pi * radius_2 * radius_2);
    const Element low = disc(radius_1, 0, {}), high = disc(radius_2, height, {});
    const auto mean = [&](const Element& of) { return geometric_factor(of, high, true).mean; };
    EXPECT_NEAR(mean(low), expected, 3e-5 * expected);
    EXPECT_LE(std::abs(mean(low) - expected), geometric_factor(low, high, true).error + 1e-6 * expected);
    EXPECT_NEAR(mean(disc(radius_1, 0, {0, 0.5, 0})), expected, 3e-5 * expected);
    EXPECT_NEAR(0.36 * mean(disc(0.6 * radius_1, 0, {})) + 0.64 * mean(disc(radius_1, 0, {0.36, 0, 0})), expected,
                3e-5 * expected);
  }
}

TEST(GeometricFactor, MeasuresAreAreasAndVolumes) {
  EXPECT_DOUBLE_EQ(measure_of({ElementKind::kTriangle, {1, 1, 1}, {2, 0, 0}, {1, 3, 0}, {}}), 3);
  EXPECT_DOUBLE_EQ(measure_of({ElementKind::kDisc, {1, 1, 1}, {2, 0, 0}, {0, 0, 3}, {0.25, 0.5, 0}}),
                   6 * std::numbers::pi * 0.75 * 0.5);
  EXPECT_DOUBLE_EQ(measure_of(patch({1, 1, 1}, {2, 0, 0}, {1, 3, 0})), 6);
  EXPECT_DOUBLE_EQ(measure_of(box({1, 1, 1}, 2)), 8);
  Element turned = box({1, 1, 1}, 2);
  std::swap(turned.u, turned.v);
  EXPECT_DOUBLE_EQ(measure_of(turned), 8);
}

}  // namespace
}  // namespace gicube
