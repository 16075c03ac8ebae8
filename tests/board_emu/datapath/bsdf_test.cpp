// Each BSDF of the hardware against its closed form: direction, width, evenness. All 4,096 random directions are tried
// once, so that nothing here is left to chance; what remains are the lattice's steps and the rounding of the words.
#include "reference/bsdf.h"
#include "datapath/scatter.h"
#include "test.h"

namespace gicube::emu {
namespace {

using std::numbers::pi;
using Vector = std::array<double, 3>;

constexpr std::array<std::uint32_t, 3> kCubes{65536, 65536, 65536};
// The z of the lattice's points are 1/2048 apart; a word is 1/16384.
constexpr double kMeanError = 2e-4;

double inner(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector unit(const Vector& a) {
  const double length = std::sqrt(inner(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vector mirrored(const Vector& d, const Vector& n) {
  const double twice = 2 * inner(d, n);
  return {d[0] - twice * n[0], d[1] - twice * n[1], d[2] - twice * n[2]};
}

wire::Material material(wire::Bsdf bsdf, double beta = 0) {
  wire::Material out;
  out.bsdf = bsdf;
  out.gloss = static_cast<std::uint16_t>(std::lround(beta * 4096));
  return out;
}

// Where a ray along `in` goes at a surface with this normal, for each entry of the table of random directions.
std::vector<Vector> directions(const wire::Material& of, const Vector& in, const Vector& normal) {
  Point gradient{};
  for (std::size_t axis = 0; axis < 3; ++axis) gradient[axis] = -static_cast<int>(std::lround(normal[axis] * 16000));
  std::vector<Vector> out;
  for (std::uint64_t i = 0; i < kRandomDirections; ++i) {
    const Direction words = scattered(of, wire::direction_words(in, kCubes), gradient, kCubes, i);
    out.push_back(unit({double(words[0]), double(words[1]), double(words[2])}));
  }
  return out;
}

Vector mean_of(const std::vector<Vector>& all) {
  Vector mean{};
  for (const Vector& v : all) {
    for (std::size_t axis = 0; axis < 3; ++axis) mean[axis] += v[axis] / static_cast<double>(all.size());
  }
  return mean;
}

double mean_cosine(const std::vector<Vector>& all, const Vector& to) { return inner(mean_of(all), to); }

// Chi-square over eight even classes of `share`, a number that is even over 0..1, and eight of the angle about `axis`:
// per degree of freedom. Independent draws give 1 ± 0.18; a lattice less.
double chi_square(const std::vector<Vector>& all, const Vector& axis,
                  const std::function<double(const Vector&)>& share) {
  const Vector b = unit(cross(axis, std::abs(axis[0]) < 0.5 ? Vector{1, 0, 0} : Vector{0, 1, 0})), c = cross(axis, b);
  std::array<double, 64> counts{};
  for (const Vector& v : all) {
    const double turn = std::atan2(inner(v, c), inner(v, b)) / (2 * pi) + 0.5;
    const int i = std::clamp(static_cast<int>(share(v) * 8), 0, 7), j = std::clamp(static_cast<int>(turn * 8), 0, 7);
    ++counts[static_cast<std::size_t>(8 * i + j)];
  }
  const double expected = static_cast<double>(all.size()) / 64;
  double sum = 0;
  for (const double count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum / 63;
}
constexpr double kEven = 0.5;  // chosen: what is even has 0.1; a tenth of the width less has more than 2

const Vector kSkew = unit({0.48, -0.6, 0.64}), kUp{0, 0, 1};

TEST(Bsdf, TheRandomDirectionsAreUnitVectorsEvenOverTheSphere) {
  std::vector<Vector> all;
  Vector second{};
  for (std::size_t i = 0; i < kRandomDirections; ++i) {
    all.push_back(random_direction(i));
    ASSERT_NEAR(inner(all[i], all[i]), 1, 1e-12);
    for (std::size_t axis = 0; axis < 3; ++axis) second[axis] += all[i][axis] * all[i][axis] / kRandomDirections;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(mean_of(all)[axis], 0, 1e-4);
    EXPECT_NEAR(second[axis], 1.0 / 3, 1e-4);
  }
  for (const Vector& axis : {kUp, kSkew, Vector{1, 0, 0}}) {
    EXPECT_LT(chi_square(all, axis, [&](const Vector& v) { return (1 + inner(v, axis)) / 2; }), kEven);
  }
}

// Their order has nothing to do with their place: neighbours in the table are not neighbours on the sphere.
TEST(Bsdf, TheRandomDirectionsAreShuffled) {
  double together = 0;
  for (std::size_t i = 1; i < kRandomDirections; ++i) together += inner(random_direction(i - 1), random_direction(i));
  EXPECT_NEAR(together / kRandomDirections, 0, 3 / std::sqrt(3.0 * kRandomDirections));
  EXPECT_EQ(random_direction(kRandomDirections + 5), random_direction(5));
}

TEST(Bsdf, AMirrorHasNoWidthAndTheDirectionOfReflection) {
  for (const Vector& normal : {kUp, kSkew}) {
    for (const Vector& in : {unit({0.1, 0.2, -1}), unit({-0.7, 0.3, -0.5}), unit({0.3, -0.5, -0.2})}) {
      if (inner(in, normal) > 0) continue;
      const Vector expected = mirrored(in, normal);
      for (const Vector& out : directions(material(wire::Bsdf::kSpecular, 1), in, normal)) {
        for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_NEAR(out[axis], expected[axis], 2e-4);
      }
    }
  }
}

TEST(Bsdf, AMirrorTakesEitherSideOfItsSurface) {
  const Vector in = unit({0.6, 0, 0.8});
  for (const Vector& normal : {Vector{0, 0, 1}, Vector{0, 0, -1}}) {
    const Vector out = directions(material(wire::Bsdf::kSpecular), in, normal)[0];
    EXPECT_NEAR(out[0], 0.6, 2e-4);
    EXPECT_NEAR(out[2], -0.8, 2e-4);
  }
}

TEST(Bsdf, IsotropicScatteringIsEvenWhateverTheDirectionAndTheNormal) {
  for (const Vector& in : {kUp, kSkew}) {
    const auto all = directions(material(wire::Bsdf::kIsotropic, 1), in, kSkew);
    EXPECT_NEAR(mean_cosine(all, in), 0, kMeanError);
    EXPECT_LT(chi_square(all, in, [&](const Vector& v) { return (1 + inner(v, in)) / 2; }), kEven);
  }
}

TEST(Bsdf, DiffuseReflectionFollowsLambertsCosine) {
  for (const Vector& normal : {kUp, kSkew}) {
    const Vector in = unit({-normal[0] + 0.3, -normal[1] - 0.2, -normal[2]});
    const auto all = directions(material(wire::Bsdf::kDiffuse, 1), in, normal);
    EXPECT_NEAR(mean_cosine(all, normal), 2.0 / 3, kMeanError);
    for (const Vector& v : all) ASSERT_GE(inner(v, normal), -2e-4);
    // The square of the cosine is even.
    EXPECT_LT(chi_square(all, normal, [&](const Vector& v) { return std::pow(inner(v, normal), 2); }), kEven);
  }
}

TEST(Bsdf, DullScatteringHasTheMeanAndTheWidthOfItsGlossAboutTheRay) {
  for (const double beta : {0.05, 0.3, 0.5, 0.9, 1.0, 1.5, 4.0, 15.5}) {
    for (const Vector& in : {kUp, kSkew}) {
      const auto all = directions(material(wire::Bsdf::kDullScattering, beta), in, {1, 0, 0});
      const double tolerance = std::min(kMeanError, beta * beta / 3 * 0.02);  // where the width is small, 2% of it
      EXPECT_NEAR(mean_cosine(all, in), reference::dull_mean(beta), tolerance) << beta;
      const Vector mean = mean_of(all);  // along the ray
      EXPECT_NEAR(std::sqrt(inner(mean, mean)), reference::dull_mean(beta), 3 * kMeanError) << beta;
      if (beta > 1 || beta < 0.1) continue;  // or the words' steps show
      EXPECT_LT(chi_square(all, in, [&](const Vector& v) { return reference::dull_share(beta, inner(v, in)); }), kEven)
          << beta;
    }
  }
}

TEST(Bsdf, DullReflectionHasTheMeanAndTheWidthOfItsGlossAboutTheMirrorsDirection) {
  // At 20 degrees from the normal a gloss of up to sin 70 degrees goes into no surface.
  const double angle = 20 * pi / 180;
  for (const double beta : {0.05, 0.3, 0.5, 0.9}) {
    for (const Vector& normal : {kUp, kSkew}) {
      const Vector across = unit(cross(normal, {1, 0, 0}));
      Vector in{};
      for (std::size_t i = 0; i < 3; ++i) in[i] = across[i] * std::sin(angle) - normal[i] * std::cos(angle);
      const Vector mirror = mirrored(in, normal);
      const auto all = directions(material(wire::Bsdf::kDullReflection, beta), in, normal);
      const double tolerance = std::min(kMeanError, beta * beta / 3 * 0.02);
      EXPECT_NEAR(mean_cosine(all, mirror), reference::dull_mean(beta), tolerance) << beta;
      if (beta < 0.1) continue;
      EXPECT_LT(chi_square(all, mirror, [&](const Vector& v) { return reference::dull_share(beta, inner(v, mirror)); }),
                kEven)
          << beta;
    }
  }
}

TEST(Bsdf, DullReflectionThatWouldEnterTheSurfaceIsReflectedOutOfIt) {
  for (const double beta : {1.0, 1.5, 3.0, 15.5}) {
    const auto all = directions(material(wire::Bsdf::kDullReflection, beta), {0, 0, -1}, kUp);
    EXPECT_NEAR(mean_cosine(all, kUp), reference::folded_dull_mean(beta), 2 * kMeanError) << beta;
    for (const Vector& v : all) ASSERT_GE(v[2], 0);
  }
}

TEST(Bsdf, WithoutGlossTheDullOnesHaveNoWidth) {
  const Vector in = unit({0.6, 0, -0.8}), mirror = unit({0.6, 0, 0.8});
  for (const Vector& v : directions(material(wire::Bsdf::kDullScattering), in, kUp)) ASSERT_GT(inner(v, in), 1 - 1e-7);
  for (const Vector& v : directions(material(wire::Bsdf::kDullReflection), in, kUp))
    ASSERT_GT(inner(v, mirror), 1 - 1e-7);
}

TEST(Bsdf, AMaterialThatDoesNotScatterKeepsTheDirection) {
  const Vector in = unit({0.6, 0, -0.8});
  for (const Vector& v : directions(material(wire::Bsdf::kNone, 2), in, kUp)) ASSERT_GT(inner(v, in), 1 - 1e-7);
}

TEST(Bsdf, WhereNothingIsLeftOfASumTheNormalOrTheRayIsTaken) {
  // beta 1 against the ray: a sum of length 0 needs a random direction just opposite, so it is asked for.
  const Vector delta = random_direction(7), against{-delta[0], -delta[1], -delta[2]};
  const Direction in = wire::direction_words(against, kCubes);
  const Direction out = scattered(material(wire::Bsdf::kDullScattering, 1), in, {}, kCubes, 7);
  EXPECT_NEAR(std::hypot(out[0], out[1], out[2]), 16384, 2);
}

// A ray that just grazes leaves on the side that the gradient tells.
TEST(Bsdf, ARayAlongTheSurfaceIsReflectedAgainstTheGradient) {
  for (const Vector& v : directions(material(wire::Bsdf::kDiffuse), {1, 0, 0}, kUp)) ASSERT_GE(v[2], 0);
}

// Golden entries: the lattice and its shuffle, computed apart from this tree.
TEST(Bsdf, TheTableOfRandomDirectionsHasTheseWords) {
  const std::array<std::pair<std::size_t, Vector>, 4> golden{{{0, {-0.130881, 0.419665, -0.898193}},
                                                              {1, {0.189098, 0.125721, -0.973877}},
                                                              {2047, {0.906470, 0.399441, 0.136963}},
                                                              {4095, {-0.762573, -0.638287, -0.105225}}}};
  for (const auto& [i, expected] : golden) {
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(random_direction(i)[axis], expected[axis], 1e-6) << i;
  }
}

// In a volume of long voxels a direction word is not a physical direction.
TEST(Bsdf, LongVoxelsLeaveThePhysicalDistributionAsItIs) {
  const std::array<std::uint32_t, 3> spacing{65536, 2 * 65536, 3 * 65536};
  Vector mean{};
  for (std::uint64_t i = 0; i < kRandomDirections; ++i) {
    const Direction out =
        scattered(material(wire::Bsdf::kDullScattering, 0.5), wire::direction_words(kSkew, spacing), {}, spacing, i);
    const Vector physical = wire::physical_direction(out, spacing);
    for (std::size_t axis = 0; axis < 3; ++axis) mean[axis] += physical[axis] / kRandomDirections;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(mean[axis], kSkew[axis] * reference::dull_mean(0.5), 5e-4);
}

}  // namespace
}  // namespace gicube::emu
