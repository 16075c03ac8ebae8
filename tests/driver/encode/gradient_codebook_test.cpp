#include "encode/volume/gradients.h"

#include "refusal.h"
#include "test.h"

namespace gicube {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

Vec3 decode(const wire::GradientEntry& entry) {
  return normalise({double(entry[0]), double(entry[1]), double(entry[2])});
}

std::vector<Vec3> random_directions(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Vec3> directions;
  for (std::size_t i = 0; i < count; ++i)
    directions.push_back(normalise({normal(random), normal(random), normal(random)}));
  return directions;
}

// A codebook beside all that it decodes to, to be tried one by one.
class Book {
 public:
  explicit Book(GradientCodebook codebook) : codebook_(std::move(codebook)) {
    for (const auto& entry : codebook_.entries()) {
      if (entry != wire::GradientEntry{}) directions_.push_back(decode(entry));
    }
  }

  // nearest() may take either of two codes that are equally near to within rounding, but nothing farther.
  void expect_nearest(Vec3 direction) const {
    double best = -2;
    for (const Vec3 candidate : directions_) best = std::max(best, dot(direction, candidate));
    const std::uint16_t code = codebook_.nearest(direction);
    ASSERT_NE(code, 0);
    ASSERT_GE(dot(direction, decode(codebook_.entries()[code])), best - 1e-14 * length(direction))
        << direction.x << ' ' << direction.y << ' ' << direction.z;
  }

 private:
  GradientCodebook codebook_;
  std::vector<Vec3> directions_;
};

TEST(GradientCodebook, TheDefaultHas2038UnitDirections) {
  const GradientCodebook codebook;
  ASSERT_EQ(codebook.entries().size(), 2048u);
  EXPECT_EQ(codebook.entries()[0], (wire::GradientEntry{}));
  for (std::size_t code = 1; code < 2048; ++code) {
    const auto& e = codebook.entries()[code];
    const double size = std::sqrt(double(e[0]) * e[0] + double(e[1]) * e[1] + double(e[2]) * e[2]);
    if (code <= 2038)
      EXPECT_NEAR(size, 511, 1) << code;
    else
      EXPECT_EQ(size, 0) << code;
  }
}

// The errors that the design expects, over a Fibonacci sphere: an even cover, so the mean is the mean over all
// directions.
TEST(GradientCodebook, TheDefaultsErrorsAreThoseOfTheDesign) {
  const GradientCodebook codebook;
  constexpr int count = 400'000;
  double sum = 0, greatest = 0;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z),
                 angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vec3 direction{r * std::cos(angle), r * std::sin(angle), z};
    const Vec3 decoded = decode(codebook.entries()[codebook.nearest(direction)]);
    const double error = std::atan2(length(cross(direction, decoded)), dot(direction, decoded)) * kDegrees;
    sum += error;
    greatest = std::max(greatest, error);
  }
  RecordProperty("mean_degrees", std::to_string(sum / count));
  RecordProperty("max_degrees", std::to_string(greatest));
  EXPECT_NEAR(sum / count, 1.71, 0.005);
  EXPECT_LE(greatest, 3.35);
  EXPECT_GE(greatest, 2.8);  // no arrangement of so many codes covers better
}

TEST(GradientCodebook, NearestIsTheNearestByTryingAll) {
  const Book book{GradientCodebook()};
  for (const Vec3 direction : random_directions(20'000, 1)) book.expect_nearest(direction);
}

TEST(GradientCodebook, NearestHoldsOnEdgesCornersAndAxes) {
  const Book book{GradientCodebook()};
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double z : {-1.0, 0.0, 1.0}) {
        if (x == 0 && y == 0 && z == 0) continue;
        book.expect_nearest({x, y, z});
        book.expect_nearest({x, y + 1e-16, z - 1e-16});
        book.expect_nearest({x, y, z / 64 + 1.0 / 3});
      }
    }
  }
}

TEST(GradientCodebook, EveryCodeIsItsOwnNearest) {
  const GradientCodebook codebook;
  for (std::uint16_t code = 1; code <= 2038; ++code) {
    const auto& e = codebook.entries()[code];
    EXPECT_EQ(codebook.nearest({double(e[0]), double(e[1]), double(e[2])}), code);
  }
}

TEST(GradientCodebook, NearestHoldsForAnyCodebook) {
  const auto scattered = random_directions(2047, 2);
  std::vector<std::vector<Vec3>> books(4, {Vec3{}});
  books[0].insert(books[0].end(), scattered.begin(), scattered.end());
  for (std::size_t i = 0; i < 2000; ++i) {  // all in one small region, and all on one great circle
    const Vec3 v = scattered[i];
    books[1].push_back(normalise(Vec3{1, 0.3, 0.2} + 0.05 * v));
    books[2].push_back({std::cos(0.003 * double(i)), std::sin(0.003 * double(i)), 0});
  }
  books[3].push_back({0, 0, 1});
  for (const auto& directions : books) {
    const Book book{GradientCodebook(directions)};
    for (const Vec3 direction : random_directions(1000, 3)) book.expect_nearest(direction);
    for (std::size_t i = 0; i < 500; ++i) book.expect_nearest(scattered[i] + 20.0 * books[1][i + 1]);
  }
}

TEST(GradientCodebook, OfEqualCodesTheLowestIsTaken) {
  const std::vector<Vec3> book{{}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}};
  const GradientCodebook codebook(book);
  EXPECT_EQ(codebook.nearest({5, 1, 0}), 1);
  EXPECT_EQ(codebook.nearest({1, 5, 0}), 2);
  EXPECT_EQ(codebook.nearest({1, 1, 0}), 1);
}

TEST(GradientCodebook, LengthDoesNotCount) {
  const GradientCodebook codebook;
  for (const Vec3 direction : random_directions(1000, 4)) {
    const std::uint16_t code = codebook.nearest(direction);
    EXPECT_EQ(codebook.nearest(1e-300 * direction), code);
    EXPECT_EQ(codebook.nearest(1e300 * direction), code);
  }
}

TEST(GradientCodebook, WhatIsNoDirectionHasCodeZero) {
  const GradientCodebook codebook;
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const Vec3 v : {Vec3{}, Vec3{nan, 0, 0}, Vec3{1, nan, 0}, Vec3{1, 0, nan}, Vec3{inf, 0, 0}, Vec3{1, -inf, 0}}) {
    EXPECT_EQ(codebook.nearest(v), 0);
  }
  const std::vector<Vec3> only_none{Vec3{}};
  EXPECT_EQ(GradientCodebook(only_none).nearest({1, 0, 0}), 0);
}

TEST(GradientCodebook, RefusesAWrongCodebookByEntry) {
  const auto refused = [](std::vector<Vec3> book) { return refusal([&] { const GradientCodebook codebook(book); }); };
  EXPECT_EQ(refused({}), "codebook: expected 1..2048 entries, got 0");
  EXPECT_EQ(refused(std::vector<Vec3>(2049)), "codebook: expected 1..2048 entries, got 2049");
  EXPECT_EQ(refused({{0, 0, 1}}), "codebook[0]: expected the zero vector, got (0, 0, 1)");
  EXPECT_EQ(refused({{}, {0, 0, 1}, {0, 0.5, 0}}), "codebook[2]: expected a unit vector, got one of length 0.5");
  EXPECT_EQ(refused({{}, {0, 0, std::nan("")}}), "codebook[1]: expected a unit vector, got one of length nan");
  EXPECT_EQ(refused({{}, {0, 0, 1.0009}}), "accepted");
}

}  // namespace
}  // namespace gicube
