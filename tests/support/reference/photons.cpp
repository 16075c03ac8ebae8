#include "photons.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace gicube::reference {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRouletteBelow = 0.01, kSurvivors = 0.1;

enum Outcome : std::size_t { kAbsorbed, kBack, kThrough, kSideways };

struct Exit {
  double distance = kInfinity;
  Outcome face = kSideways;
};

Exit find_exit(const Medium& medium, const Photon& photon) {
  Exit exit;
  const auto wall = [&exit](double distance, Outcome face) {
    if (distance < exit.distance) exit = {distance, face};
  };
  const auto [p, d] = photon;
  if (d.x != 0) wall(((d.x > 0 ? medium.high.x : medium.low.x) - p.x) / d.x, kSideways);
  if (d.y != 0) wall(((d.y > 0 ? medium.high.y : medium.low.y) - p.y) / d.y, kSideways);
  if (d.z != 0) wall(((d.z > 0 ? medium.high.z : medium.low.z) - p.z) / d.z, d.z > 0 ? kThrough : kBack);
  return exit;
}

class Tally {
 public:
  void add(double score) {
    sum_ += score;
    squares_ += score * score;
  }
  Estimate estimate(double n) const {
    const double mean = sum_ / n;
    return {mean, std::sqrt(std::max(0.0, squares_ / n - mean * mean) / n)};
  }

 private:
  double sum_ = 0, squares_ = 0;
};

}  // namespace

Vec3 Random::direction() {
  const double z = 1 - 2 * uniform(), phi = 2 * std::numbers::pi * uniform();
  const double ring = std::sqrt(std::max(0.0, 1 - z * z));
  return {ring * std::cos(phi), ring * std::sin(phi), z};
}

Vec3 Random::diffuse(Vec3 normal) {
  // The sum of the normal and a uniform direction; it is 0 with probability 0.
  Vec3 sum = normal + direction();
  while (dot(sum, sum) == 0) sum = normal + direction();
  return normalise(sum);
}

Fates follow(const Medium& medium, std::uint64_t photons, std::uint64_t seed, const Emit& emit,
             const Collide& collide) {
  Random random(seed);
  std::array<Tally, 4> tallies;
  double collisions = 0;
  for (std::uint64_t i = 0; i < photons; ++i) {
    Photon photon = emit(random);
    std::array<double, 4> score{};
    double weight = 1;
    while (weight > 0) {
      const double free = -std::log(1 - random.uniform()) / medium.extinction;
      const Exit exit = find_exit(medium, photon);
      if (free >= exit.distance) {
        score[exit.face] += weight;
        break;
      }
      photon.position = photon.position + free * photon.direction;
      if (collide) collide(photon.position, weight);
      collisions += weight;
      score[kAbsorbed] += weight * (1 - medium.albedo);
      weight *= medium.albedo;
      if (weight < kRouletteBelow) {
        const bool survives = random.uniform() < kSurvivors;
        // Energy that the roulette takes or gives is zero in the mean; booked as absorbed, the sum stays 1.
        const double after = survives ? weight / kSurvivors : 0;
        score[kAbsorbed] += weight - after;
        weight = after;
      }
      photon.direction = random.direction();
    }
    for (std::size_t outcome = 0; outcome < tallies.size(); ++outcome) tallies[outcome].add(score[outcome]);
  }
  const auto n = static_cast<double>(photons);
  return {tallies[kAbsorbed].estimate(n), tallies[kBack].estimate(n), tallies[kThrough].estimate(n),
          tallies[kSideways].estimate(n), collisions / n};
}

Fates slab(double optical_thickness, double albedo, std::uint64_t photons, std::uint64_t seed) {
  const Medium medium{{-kInfinity, -kInfinity, 0}, {kInfinity, kInfinity, optical_thickness}, 1, albedo};
  return follow(medium, photons, seed, [](Random&) { return Photon{{0, 0, 0}, {0, 0, 1}}; });
}

}  // namespace gicube::reference
