// Directions are drawn with the density that is said of them.
#include "scattering.h"

#include <numbers>

#include "path_tests.h"
#include "reference/bsdf.h"

namespace gicube::reference::paths {
namespace {

struct Case {
  const char* name;
  Material material;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"isotropic", isotropic(1)},
      {"diffuse", {.bsdf = Bsdf::kDiffuse}},
      {"gloss 1.2", {.bsdf = Bsdf::kDullReflection, .gloss = 1.2}},
      {"gloss 2", {.bsdf = Bsdf::kDullReflection, .gloss = 2}},
      {"dull scattering 1.5", {.bsdf = Bsdf::kDullScattering, .gloss = 1.5}},
      {"forward 0.75", forward(1, 0.75F)},
      {"backward 0.4", forward(1, -0.4F)},
      {"tabulated", {.bsdf = Bsdf::kTrap, .routine = kTabulatedRoutine, .parameters = {0, 1, 5, 2}}},
  };
  return all;
}

// Three functions of a direction, by which two densities are compared.
std::array<double, 4> moments(Vec3 out, Vec3 direction, Vec3 normal) {
  const Vec3 across = normalise(cross(direction, normal));
  return {1, dot(out, direction), dot(out, normal), dot(out, across) * dot(out, across)};
}

TEST(Scattering, DrawsDirectionsWithTheirDensity) {
  const Vec3 normal = normalise({0.2, 0.3, 1}), direction = normalise({0.8, 0.1, -0.7});
  for (const Case& one : cases()) {
    std::array<double, 4> truth{}, sums{}, squares{};
    constexpr int kPlaces = 400'000;  // a lattice
    for (int i = 0; i < kPlaces; ++i) {
      const double z = 1 - (2 * i + 1) / double{kPlaces}, angle = 2.399963229728653 * i, ring = std::sqrt(1 - z * z);
      const Vec3 out{ring * std::cos(angle), ring * std::sin(angle), z};
      const double weight = density(one.material, direction, normal, out) * 4 * std::numbers::pi / kPlaces;
      const auto f = moments(out, direction, normal);
      for (std::size_t k = 0; k < 4; ++k) truth[k] += weight * f[k];
    }
    EXPECT_NEAR(truth[0], 1, 2e-4) << one.name;
    constexpr int kDraws = 60000;
    CounterRandom random(21, 0);
    for (int i = 0; i < kDraws; ++i) {
      const auto f = moments(scatter(one.material, direction, normal, true, random), direction, normal);
      for (std::size_t k = 0; k < 4; ++k) sums[k] += f[k], squares[k] += f[k] * f[k];
    }
    for (std::size_t k = 1; k < 4; ++k) {
      const double mean = sums[k] / kDraws;
      expect_near({mean, std::sqrt((squares[k] / kDraws - mean * mean) / kDraws)}, truth[k], one.name, 2e-4);
    }
  }
}

// Of a gloss below 1 the density is infinite at its rim. The share within an angle has a closed form (bsdf.h).
TEST(Scattering, OfALittleGlossHasTheSharesOfItsDensity) {
  const Vec3 normal{0, 0, 1}, direction{0, 0, -1};
  for (const double gloss : {0.3, 0.7}) {
    const Material material{.bsdf = Bsdf::kDullScattering, .gloss = gloss};
    for (const double cosine : {std::sqrt(1 - 0.8 * gloss * gloss), std::sqrt(1 - 0.3 * gloss * gloss)}) {
      // From the rim at sine = gloss inward, in sine = gloss sin(t): the integrand is smooth.
      double integral = 0;
      constexpr int kSteps = 2000;
      const double first = std::asin(std::sqrt(1 - cosine * cosine) / gloss), last = std::numbers::pi / 2;
      for (int i = 0; i < kSteps; ++i) {
        const double t = first + (last - first) * (i + 0.5) / kSteps, sine = gloss * std::sin(t);
        const double c = std::sqrt(1 - sine * sine);
        const double ring = 2 * std::numbers::pi * sine * gloss * std::cos(t) / c;  // d(solid angle) / dt
        integral += (last - first) / kSteps * ring * density(material, direction, normal, {sine, 0, -c});
      }
      EXPECT_NEAR(integral, dull_share(gloss, cosine), 1e-5) << gloss << " " << cosine;
    }
  }
}

TEST(Scattering, OfHenyeyAndGreensteinHasTheMeanCosineG) {
  CounterRandom random(22, 0);
  for (const float g : {-0.6F, 0.0F, 0.9F}) {
    double sum = 0;
    constexpr int kDraws = 100000;
    for (int i = 0; i < kDraws; ++i) sum += scatter(forward(1, g), kAhead, {0, 0, -1}, true, random).z;
    EXPECT_NEAR(sum / kDraws, g, 3 * 0.58 / std::sqrt(kDraws)) << g;
  }
}

TEST(Glass, BendsRaysBySnellsLawAndReflectsByFresnels) {
  const Material glass{.bsdf = Bsdf::kTrap, .surface = true, .parameters = {1.5F}};
  EXPECT_NEAR(fresnel_reflectance(1, 1, 1.5), 0.04, 1e-12);
  EXPECT_NEAR(fresnel_reflectance(1, 1.5, 1), 0.04, 1e-12);
  EXPECT_EQ(fresnel_reflectance(std::cos(0.8), 1.5, 1), 1);             // beyond the critical angle, 0.7297
  const double brewster = std::atan(1.5), s = (1 - 2.25) / (1 + 2.25);  // there only one polarisation is left
  EXPECT_NEAR(fresnel_reflectance(std::cos(brewster), 1, 1.5), s * s / 2, 1e-12);
  CounterRandom random(23, 0);
  for (int i = 0; i < 100; ++i) {
    const Vec3 out = scatter(glass, {0.6, 0, 0.8}, {0, 0, -1}, true, random);
    EXPECT_NEAR(length(out), 1, 1e-12);
    EXPECT_NEAR(out.x, out.z > 0 ? 0.4 : 0.6, 1e-12);
    const Vec3 back = scatter(glass, {0.4, 0, std::sqrt(0.84)}, {0, 0, -1}, false, random);  // the same way out
    EXPECT_NEAR(back.x, back.z > 0 ? 0.6 : 0.4, 1e-12);
  }
}

TEST(Scattering, ByARoutineThatOnlyABoardHasIsRefused) {
  EXPECT_THROW(check({.bsdf = Bsdf::kTrap, .routine = kHostRoutine}), std::invalid_argument);
  EXPECT_NO_THROW(check({.bsdf = Bsdf::kTrap, .routine = kTabulatedRoutine}));
}

}  // namespace
}  // namespace gicube::reference::paths
