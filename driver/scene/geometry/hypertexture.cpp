#include "gicube/scene/hypertexture.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/noise.hpp>
#include <limits>
#include <numbers>

#include "scene/common/checks.h"
#include "scene/geometry/signed_distance.h"

namespace gicube::scene {
namespace {

constexpr int kMaxOctaves = 12;
constexpr double kPeriod = 289;  // cells after which GLM's noise repeats

// Gradient noise in space and time, -1..1, which depends on the seed.
class Noise {
 public:
  Noise(double frequency, std::uint32_t seed) : frequency_(frequency) {
    // Shifted by whole cells in three directions.
    const std::uint64_t hash = (seed + std::uint64_t{1}) * 0x9e3779b97f4a7c15;
    const auto cells = [hash](int shift) { return static_cast<double>((hash >> shift) % 289); };
    offset_ = seed == 0 ? Vec3{} : Vec3{cells(8), cells(24), cells(40)};
  }

  double at(Vec3 p, double time) const {
    const Vec3 q = frequency_ * p + offset_;
    const auto within = [](double v) { return v - kPeriod * std::floor(v / kPeriod); };
    return std::clamp(glm::perlin(glm::dvec4(within(q.x), within(q.y), within(q.z), within(time))), -1.0, 1.0);
  }
  // The sum of the octaves' absolute values, 0..2.
  double turbulence(Vec3 p, double time, int octaves) const {
    double sum = 0, scale = 1;
    for (int i = 0; i < octaves; ++i, scale *= 2) sum += std::abs(at(scale * p, time)) / scale;
    return sum;
  }
  // Three independent values.
  Vec3 vector(Vec3 p, double time) const {
    const double third = kPeriod / 3 / frequency_;
    return {at(p, time), at(p + Vec3{third, 0, 0}, time), at(p + Vec3{0, third, 0}, time)};
  }

 private:
  double frequency_;
  Vec3 offset_;
};

struct Texture {
  Hypertexture own;
  std::vector<Field> fields;
  Noise noise;

  Distance distance(Vec3 p) const {
    Distance nearest{std::numeric_limits<double>::infinity(), {}};
    for (const Field& field : fields) {
      const Distance d = field(p);
      if (d.distance < nearest.distance) nearest = d;
    }
    return nearest;
  }

  double soft(double distance) const {
    const double density = 0.5 - distance / own.softness;
    return density > 0 ? std::min(density, 1.0) : -1;
  }

  // Whether the density at this distance is constant, if the surface is moved by at most `reach`.
  bool far(double distance, double reach) const { return std::abs(distance) > reach + own.softness / 2; }

  double noisy(Vec3 p) const {
    const double d = distance(p).distance;
    if (far(d, own.amplitude)) return soft(d);
    return soft(d - own.amplitude * noise.at(p, own.time));
  }

  double turbulent(Vec3 p) const {
    const double d = distance(p).distance;
    if (far(d, 2 * own.amplitude)) return soft(d);
    return soft(d - own.amplitude * noise.turbulence(p, own.time, own.octaves));
  }

  // A point is in a hair if the noise at the root exceeds the height relative to the longest hair, so hairs are thinner
  // towards their tips.
  double furry(Vec3 p) const {
    const Distance d = distance(p);
    if (d.distance <= 0) return 1;
    const double height = d.distance / own.length;
    if (height >= 1) return -1;
    Vec3 root = p - d.distance * d.away;
    // chosen: curls are four hairs wide
    if (own.curl > 0) root = root + own.curl * height * height * noise.vector(0.25 * root, own.time);
    const double grown = 0.5 + 0.5 * noise.at(root, own.time) - height;
    return grown > 0 ? std::min(grown * own.length / own.softness, 1.0) : -1;
  }

  double flaming(Vec3 p) const {
    const double height = std::max(p.z / own.stretch, 0.0);
    const Vec3 rising{p.x, p.y, p.z / own.stretch - own.time / own.frequency};
    const Vec3 drawn{p.x, p.y, p.z > 0 ? height : p.z};
    const double reach = own.amplitude * height * 2 * std::numbers::sqrt3;
    if (far(distance(drawn).distance, reach)) return soft(distance(drawn).distance);
    Vec3 torn;
    double scale = 1;
    for (int i = 0; i < own.octaves; ++i, scale *= 2) torn = torn + (1 / scale) * noise.vector(scale * rising, 0);
    return soft(distance(drawn + own.amplitude * height * torn).distance);
  }
};

}  // namespace

HypertextureKind hypertexture_named(const std::string& name) {
  constexpr std::pair<const char*, HypertextureKind> kKinds[]{{"noise", HypertextureKind::kNoise},
                                                              {"turbulence", HypertextureKind::kTurbulence},
                                                              {"fur", HypertextureKind::kFur},
                                                              {"flame", HypertextureKind::kFlame}};
  return named("kind", name, kKinds);
}

void check(const Hypertexture& texture) {
  check(texture.shape);
  require_above_0("softness", texture.softness);
  require_above_0("frequency", texture.frequency);
  require(texture.octaves >= 1 && texture.octaves <= kMaxOctaves, "octaves", "1 to 12", texture.octaves);
  const auto not_below_0 = [](const char* field, double value) {
    require(value >= 0 && std::isfinite(value), field, "a number not below 0", value);
  };
  not_below_0("amplitude", texture.amplitude);
  require(std::isfinite(texture.time), "time", "a finite number", texture.time);
  require_above_0("length", texture.length);
  not_below_0("curl", texture.curl);
  require_above_0("stretch", texture.stretch);
}

std::function<double(Vec3)> density_of(const Hypertexture& texture) {
  check(texture);
  const auto own = std::make_shared<const Texture>(
      Texture{texture, fields_of(texture.shape), Noise(texture.frequency, texture.seed)});
  switch (texture.kind) {
    case HypertextureKind::kNoise: return [own](Vec3 p) { return own->noisy(p); };
    case HypertextureKind::kTurbulence: return [own](Vec3 p) { return own->turbulent(p); };
    case HypertextureKind::kFur: return [own](Vec3 p) { return own->furry(p); };
    case HypertextureKind::kFlame: break;
  }
  return [own](Vec3 p) { return own->flaming(p); };
}

}  // namespace gicube::scene
