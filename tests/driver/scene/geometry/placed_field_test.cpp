// Distances from solids that are scaled unequally, against references that find the nearest point in other ways.
#include "scene/geometry/placed_field.h"

#include "scene/geometry/signed_distance.h"
#include "test.h"

namespace gicube::scene {
namespace {

PlacedSolid placed_solid(const Shape& shape, const Affine& to_voxels) {
  return {fields_of(shape).front(), to_voxels, 0, false};
}

// The nearest point of an axis-parallel ellipsoid around the origin, by bisection of the one root (D. Eberly, Distance
// from a point to an ellipse, an ellipsoid, or a hyperellipsoid). No component of p is 0.
double ellipsoid_distance(std::array<double, 3> half, std::array<double, 3> p) {
  const auto root_sum = [&](double t) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += std::pow(half[i] * p[i] / (t + half[i] * half[i]), 2);
    return sum;
  };
  const auto least = static_cast<std::size_t>(std::min_element(half.begin(), half.end()) - half.begin());
  double low = -half[least] * half[least] + half[least] * std::abs(p[least]),
         high = 2 * std::hypot(half[0], half[1], half[2]) * std::hypot(p[0], p[1], p[2]);
  for (int i = 0; i < 200; ++i) (root_sum(0.5 * (low + high)) > 1 ? low : high) = 0.5 * (low + high);
  double squared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    squared += std::pow(p[i] - half[i] * half[i] * p[i] / (low + half[i] * half[i]), 2);
  }
  return root_sum(0) < 1 ? -std::sqrt(squared) : std::sqrt(squared);
}

TEST(PlacedField, IsTheDistanceFromABallThatIsPressedFlatOrDrawnOut) {
  std::mt19937 random(3);
  for (const std::array<double, 3> half :
       {std::array{0.4, 9.0, 9.0}, {1.0, 9.0, 9.0}, {25.0, 10.0, 16.0}, {9.0, 0.4, 3.0}}) {
    const PlacedSolid ball = placed_solid(SphereShape{}, scaling({half[0], half[1], half[2]}));
    const PlacedField field(ball);
    for (int n = 0; n < 3000;) {
      std::array<double, 3> p{};
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = std::uniform_real_distribution(-half[i] - kNearVoxels, half[i] + kNearVoxels)(random);
      }
      const double expected = ellipsoid_distance(half, p);
      if (std::abs(expected) >= kNearVoxels) continue;
      ++n;
      const Distance found = field.distance({p[0], p[1], p[2]});
      ASSERT_NEAR(found.distance, expected, std::abs(expected) <= 1 ? 0.005 : 0.05)
          << p[0] << ' ' << p[1] << ' ' << p[2] << " of " << half[0] << ' ' << half[1] << ' ' << half[2];
    }
  }
}

TEST(PlacedField, IsTheDistanceFromABoxWhicheverOfItsFacesIsNearest) {
  const Vec3 half{0.4, 9, 6};
  const PlacedSolid box = placed_solid(BoxShape{}, scaling(half));
  const PlacedField field(box);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> across(-2, 2), along(-11, 11);
  for (int n = 0; n < 3000; ++n) {
    const Vec3 p{across(random), along(random), along(random)};
    const double expected = box_distance(p, -1 * half, half, 0).distance;
    if (std::abs(expected) >= kNearVoxels) continue;
    ASSERT_NEAR(field.distance(p).distance, expected, 0.005) << p.x << ' ' << p.y << ' ' << p.z;
  }
}

TEST(PlacedField, IsTheDistanceFromATorusThatIsTurnedAndScaled) {
  const Affine map = compose(compose(translation({3, 1, 2}), rotation({1, 0, 2}, 20)), scaling({21, 9, 18}));
  const PlacedSolid torus = placed_solid(TorusShape{0.9, 0.3}, map);
  const PlacedField field(torus);
  const auto on_surface = [&map](double u, double v) {
    const double out = 0.9 + 0.3 * std::cos(v);
    return map.point({out * std::cos(u), out * std::sin(u), 0.3 * std::sin(v)});
  };
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-25, 25);
  for (int n = 0; n < 100;) {
    const Vec3 p{anywhere(random), anywhere(random), anywhere(random)};
    if (std::abs(field.bound(p)) >= 2) continue;
    ++n;
    // The best of a net of points, and from there downhill.
    constexpr int kNet = 100;
    double u = 0, v = 0, least = 1e9, step = 2 * std::numbers::pi / kNet;
    const auto look = [&](double a, double b) {
      const double distance = length(on_surface(a, b) - p);
      if (distance < least) least = distance, u = a, v = b;
    };
    for (int i = 0; i < kNet * kNet; ++i) look(step * (i % kNet), step * (i / kNet));
    for (int round = 0; round < 60; ++round) {
      const double a = u, b = v;
      for (int i = 0; i < 9; ++i) look(a + step * (i % 3 - 1), b + step * (i / 3 - 1));
      if (u == a && v == b) step /= 2;
    }
    const double found = field.distance(p).distance;
    ASSERT_NEAR(std::abs(found), least, least <= 1 ? 0.005 : 0.05) << p.x << ' ' << p.y << ' ' << p.z;
    ASSERT_EQ(found < 0, field.bound(p) < 0);
  }
}

TEST(PlacedField, PointsAwayFromTheNearestPoint) {
  const PlacedSolid plate = placed_solid(SphereShape{}, scaling({0.4, 9, 9}));
  const PlacedField field(plate);
  for (const Vec3 p : {Vec3{0.3, 2, 1}, Vec3{1.5, 2, 1}, Vec3{0.2, 9.8, 0.1}, Vec3{-2, -3, 4}}) {
    const Distance here = field.distance(p);
    EXPECT_NEAR(length(here.away), 1, 1e-9);
    EXPECT_NEAR(field.distance(p - here.distance * here.away).distance, 0, 0.005);
  }
}

}  // namespace
}  // namespace gicube::scene
