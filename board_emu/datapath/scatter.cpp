#include "datapath/scatter.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "datapath/jitter.h"
#include "words/vectors.h"

namespace gicube::emu {

namespace {

using wire::unit;

Vector mirrored(const Vector& direction, const Vector& normal) {
  return along(direction, -2 * dot(direction, normal), normal);
}

// A Fibonacci lattice on the sphere (Gonzalez 2010), shuffled by the hash that indexes it.
std::vector<Vector> make_directions() {
  std::vector<Vector> out(kRandomDirections);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(kRandomDirections);
    const double radius = std::sqrt(1 - z * z);
    const double angle = 2 * std::numbers::pi * std::fmod(static_cast<double>(i) / std::numbers::phi, 1.0);
    out[i] = {radius * std::cos(angle), radius * std::sin(angle), z};
  }
  for (std::size_t i = out.size() - 1; i > 0; --i) std::swap(out[i], out[wire::mix64(i) % (i + 1)]);
  return out;
}

// The unit vector against the gradient; if that is zero, against the ray's direction.
Vector normal_of(const Point& gradient, const Vector& direction) {
  if (gradient == Point{}) return scaled(direction, -1);
  return unit(
      {-static_cast<double>(gradient[0]), -static_cast<double>(gradient[1]), -static_cast<double>(gradient[2])});
}

}  // namespace

const std::array<double, 3>& random_direction(std::size_t i) {
  static const std::vector<Vector> table = make_directions();
  return table[i % kRandomDirections];
}

Direction scattered(const wire::Material& material, const Direction& direction, const Point& gradient,
                    const std::array<std::uint32_t, 3>& spacing, std::uint64_t chance) {
  const Vector d = wire::physical_direction(direction, spacing);
  const Vector delta = random_direction(chance);
  const double gloss = static_cast<double>(material.gloss) / (1 << wire::kGlossFractionBits);
  Vector normal = normal_of(gradient, d);
  if (dot(normal, d) > 0) normal = scaled(normal, -1);
  Vector out = d;
  switch (material.bsdf) {
    case wire::Bsdf::kSpecular: out = mirrored(d, normal); break;
    case wire::Bsdf::kDullReflection: out = sum(unit(mirrored(d, normal)), scaled(delta, gloss)); break;
    case wire::Bsdf::kDullScattering: out = sum(d, scaled(delta, gloss)); break;
    case wire::Bsdf::kIsotropic: out = delta; break;
    case wire::Bsdf::kDiffuse: out = sum(normal, delta); break;
    default: break;
  }
  // If gloss turns the ray into the surface, the ray is reflected out of it.
  if (reflects(material.bsdf) && dot(out, normal) < 0) out = mirrored(out, normal);
  if (dot(out, out) < 1e-12) out = reflects(material.bsdf) ? normal : d;
  return wire::direction_words(unit(out), spacing);
}

}  // namespace gicube::emu
