#include "light/transport/optics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gicube/scene/error.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

constexpr double kPi = std::numbers::pi, kGlassIndex = 1.5;

Vec3 mirrored(Vec3 v, Vec3 normal) { return v - 2 * dot(v, normal) * normal; }

double reflectance(double cosine, double from, double to) {
  const double eta = from / to, sine_squared = eta * eta * (1 - cosine * cosine);
  if (sine_squared >= 1) return 1;
  const double refracted = std::sqrt(1 - sine_squared);
  const double across = (from * cosine - to * refracted) / (from * cosine + to * refracted);
  const double parallel = (to * cosine - from * refracted) / (to * cosine + from * refracted);
  return (across * across + parallel * parallel) / 2;
}

Vec3 through_glass(double index, Vec3 direction, Vec3 outward, PathRandom& random) {
  const bool enters = dot(direction, outward) < 0;
  const Vec3 normal = enters ? outward : -1.0 * outward;
  const double from = enters ? 1 : index, to = enters ? index : 1, cosine = std::min(1.0, -dot(direction, normal));
  if (random.uniform() < reflectance(cosine, from, to)) return mirrored(direction, normal);
  const double eta = from / to;
  const double refracted = std::sqrt(std::max(0.0, 1 - eta * eta * (1 - cosine * cosine)));
  return normalise(eta * (direction + cosine * normal) - refracted * normal);
}

double henyey_greenstein_cosine(double g, double chance) {
  if (std::abs(g) < 1e-4) return 2 * chance - 1;
  const double root = (1 - g * g) / (1 - g + 2 * g * chance);
  return std::clamp((1 + g * g - root * root) / (2 * g), -1.0, 1.0);
}

}  // namespace

Optics optics_of(const Material& material, const std::array<double, 3>& colour, const std::string& name) {
  Optics out{.bsdf = material.bsdf};
  for (std::size_t c = 0; c < 3; ++c) out.albedo[c] = material.scattering * colour[c];
  const double parameter = material.parameters.empty() ? 0 : static_cast<double>(material.parameters.front());
  switch (material.bsdf) {
    case Bsdf::kNone:
    case Bsdf::kIsotropic: return out;
    case Bsdf::kDiffuse:
    case Bsdf::kSpecular: out.look = Look::kOpaque; return out;
    case Bsdf::kTrap:
      if (material.routine == kHenyeyGreensteinRoutine) {
        out.g = parameter;
        return out;
      }
      if (material.routine == kFresnelRoutine) {
        out.look = Look::kGlass;
        out.index = parameter > 0 ? parameter : kGlassIndex;
        return out;
      }
      throw InputError(name + ".routine", "fresnel or henyey_greenstein", std::to_string(material.routine));
    case Bsdf::kDullReflection:
    case Bsdf::kDullScattering: break;
  }
  throw InputError(name + ".bsdf", "none, isotropic, diffuse, specular or trap", "a dull one");
}

Vec3 scatter(const Optics& optics, Vec3 direction, Vec3 normal, PathRandom& random) {
  if (optics.look == Look::kGlass) return through_glass(optics.index, direction, normal, random);
  if (optics.bsdf == Bsdf::kSpecular) return mirrored(direction, normal);
  if (optics.bsdf == Bsdf::kDiffuse) {
    const Vec3 facing = dot(direction, normal) < 0 ? normal : -1.0 * normal;
    const double squared = random.uniform(), turn = 2 * kPi * random.uniform(), ring = std::sqrt(squared);
    return turned({ring * std::cos(turn), ring * std::sin(turn), std::sqrt(1 - squared)}, facing);
  }
  const double cosine = henyey_greenstein_cosine(optics.g, random.uniform());
  const double turn = 2 * kPi * random.uniform(), ring = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return turned({ring * std::cos(turn), ring * std::sin(turn), cosine}, direction);
}

double density(const Optics& optics, Vec3 direction, Vec3 normal, Vec3 out) {
  if (optics.sharp() || optics.bsdf == Bsdf::kNone) return 0;
  if (optics.bsdf == Bsdf::kDiffuse) {
    const double cosine = dot(out, normal);
    return cosine * dot(direction, normal) < 0 ? std::abs(cosine) / kPi : 0;
  }
  const double g = optics.g;
  return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * dot(direction, out), 1.5));
}

}  // namespace gicube::samples
