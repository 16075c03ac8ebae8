#include "scattering.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace gicube::reference::paths {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kGlass = 1.5;  // of Fresnel's routine without a parameter

double parameter(const Material& material, double otherwise) {
  return material.parameters.empty() ? otherwise : static_cast<double>(material.parameters.front());
}

Vec3 mirrored(Vec3 v, Vec3 normal) { return v - 2 * dot(v, normal) * normal; }

// At an angle of this cosine round `axis`, turned by `turn` of a whole turn.
Vec3 around(Vec3 axis, double cosine, double turn) {
  const Vec3 across = normalise(cross(axis, std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine)), phi = 2 * kPi * turn;
  return cosine * axis + sine * std::cos(phi) * across + sine * std::sin(phi) * cross(axis, across);
}

// Density of the direction of m + gloss d, d even over the sphere: the ray along `out` meets that sphere at up to two
// lengths s.
double dull_density(Vec3 m, double gloss, Vec3 out) {
  const double c = dot(m, out), root = c * c - 1 + gloss * gloss;
  if (root <= 0) return 0;
  double sum = 0;
  for (const double s : {c - std::sqrt(root), c + std::sqrt(root)}) {
    if (s > 0) sum += s * s / (4 * kPi * gloss * std::sqrt(root));
  }
  return sum;
}

Vec3 dull(Vec3 m, double gloss, CounterRandom& random) { return normalise(m + gloss * random.direction()); }

double henyey_greenstein(double g, double cosine) {
  return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

double henyey_greenstein_cosine(double g, double chance) {
  if (std::abs(g) < 1e-6) return 2 * chance - 1;
  const double root = (1 - g * g) / (1 - g + 2 * g * chance);
  return std::clamp((1 + g * g - root * root) / (2 * g), -1.0, 1.0);
}

// Piecewise linear between equal steps of the cosine from -1 to 1; any scale.
double interpolated(const std::vector<float>& values, double cosine) {
  const auto last = static_cast<double>(values.size() - 1);
  const double place = std::clamp((cosine + 1) / 2 * last, 0.0, last);
  const auto i = std::min(static_cast<std::size_t>(place), values.size() - 2);
  const double way = place - static_cast<double>(i);
  return (1 - way) * values[i] + way * values[i + 1];
}

double tabulated(const std::vector<float>& values, double cosine) {
  if (values.size() < 2) return 1 / (4 * kPi);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < values.size(); ++i) sum += (double{values[i]} + double{values[i + 1]}) / 2;
  return interpolated(values, cosine) / (2 * kPi * sum * 2 / static_cast<double>(values.size() - 1));
}

// By rejection: simple, and exact.
double tabulated_cosine(const std::vector<float>& values, CounterRandom& random) {
  const double most = values.size() < 2 ? 0 : *std::max_element(values.begin(), values.end());
  while (true) {
    const double cosine = 2 * random.uniform() - 1;
    if (most == 0 || random.uniform() * most < interpolated(values, cosine)) return cosine;
  }
}

Vec3 refract_or_reflect(double index, Vec3 direction, Vec3 normal, bool enters, CounterRandom& random) {
  const double from = enters ? 1 : index, to = enters ? index : 1, cosine = std::min(1.0, -dot(direction, normal));
  if (random.uniform() < fresnel_reflectance(cosine, from, to)) return mirrored(direction, normal);
  const double eta = from / to;
  const double refracted = std::sqrt(std::max(0.0, 1 - eta * eta * (1 - cosine * cosine)));
  return normalise(eta * (direction + cosine * normal) - refracted * normal);
}

}  // namespace

double fresnel_reflectance(double cosine, double from, double to) {
  const double eta = from / to, sine_squared = eta * eta * (1 - cosine * cosine);
  if (sine_squared >= 1) return 1;
  const double refracted = std::sqrt(1 - sine_squared);
  const double across = (from * cosine - to * refracted) / (from * cosine + to * refracted);
  const double parallel = (to * cosine - from * refracted) / (to * cosine + from * refracted);
  return (across * across + parallel * parallel) / 2;
}

bool is_sharp(const Material& material) {
  if (material.bsdf == Bsdf::kTrap) return material.routine == kFresnelRoutine;
  const bool dull = material.bsdf == Bsdf::kDullReflection || material.bsdf == Bsdf::kDullScattering;
  return material.bsdf == Bsdf::kSpecular || (dull && material.gloss == 0);
}

void check(const Material& material) {
  if (material.bsdf != Bsdf::kTrap || material.routine <= kTabulatedRoutine) return;
  throw std::invalid_argument("routine: expected one that every board has, got " + std::to_string(material.routine));
}

Vec3 scatter(const Material& material, Vec3 direction, Vec3 normal, bool enters, CounterRandom& random) {
  switch (material.bsdf) {
    case Bsdf::kNone: return direction;
    case Bsdf::kSpecular: return mirrored(direction, normal);
    case Bsdf::kDullReflection: {
      const Vec3 out = dull(mirrored(direction, normal), material.gloss, random);
      return dot(out, normal) < 0 ? mirrored(out, normal) : out;
    }
    case Bsdf::kDullScattering: return dull(direction, material.gloss, random);
    case Bsdf::kIsotropic: return random.direction();
    case Bsdf::kDiffuse: return dull(normal, 1, random);
    case Bsdf::kTrap: break;
  }
  if (material.routine == kFresnelRoutine) {
    return refract_or_reflect(parameter(material, kGlass), direction, normal, enters, random);
  }
  const double cosine = material.routine == kTabulatedRoutine
                            ? tabulated_cosine(material.parameters, random)
                            : henyey_greenstein_cosine(parameter(material, 0), random.uniform());
  return around(direction, cosine, random.uniform());
}

double density(const Material& material, Vec3 direction, Vec3 normal, Vec3 out) {
  const double up = dot(normal, out);
  switch (material.bsdf) {
    case Bsdf::kNone:
    case Bsdf::kSpecular: return 0;
    case Bsdf::kDullReflection: {
      const Vec3 mirror = mirrored(direction, normal);
      if (up < 0) return 0;
      return dull_density(mirror, material.gloss, out) + dull_density(mirror, material.gloss, mirrored(out, normal));
    }
    case Bsdf::kDullScattering: return dull_density(direction, material.gloss, out);
    case Bsdf::kIsotropic: return 1 / (4 * kPi);
    case Bsdf::kDiffuse: return std::max(0.0, up) / kPi;
    case Bsdf::kTrap: break;
  }
  if (material.routine == kTabulatedRoutine) return tabulated(material.parameters, dot(direction, out));
  return henyey_greenstein(parameter(material, 0), dot(direction, out));
}

}  // namespace gicube::reference::paths
