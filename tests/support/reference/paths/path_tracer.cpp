#include "path_tracer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <limits>
#include <stdexcept>
#include <thread>

#include "light_samples.h"
#include "scattering.h"

namespace gicube::reference::paths {

namespace {

constexpr double kRouletteBelow = 0.1;  // of the share that a path's scatterings let go on

void add(Rgb& sum, const Rgb& weight, double factor, const Rgb& colour) {
  for (std::size_t c = 0; c < 3; ++c) sum[c] += weight[c] * factor * colour[c];
}

class RgbTally {
 public:
  void add(const Rgb& value) {
    ++count_;
    for (std::size_t c = 0; c < 3; ++c) {  // Welford's: no cancellation
      const double off = value[c] - mean_[c];
      mean_[c] += off / static_cast<double>(count_);
      squares_[c] += off * (value[c] - mean_[c]);
    }
  }
  std::array<Estimate, 3> estimate() const {
    std::array<Estimate, 3> out;
    const auto n = static_cast<double>(count_);
    for (std::size_t c = 0; c < 3; ++c) out[c] = {mean_[c], count_ < 2 ? 0 : std::sqrt(squares_[c] / (n - 1) / n)};
    return out;
  }

 private:
  std::uint64_t count_ = 0;
  Rgb mean_{}, squares_{};
};

}  // namespace

PathTracer::PathTracer(const PathScene& scene, bool guided)
    : scene_(scene), field_(scene.scene.volume, {}), extinction_(scene, field_) {
  if (scene.lights.size() != scene.light_colours.size()) {
    throw std::invalid_argument("light_colours: expected " + std::to_string(scene.lights.size()) + ", got " +
                                std::to_string(scene.light_colours.size()));
  }
  for (const Material& material : scene.materials) check(material);
  for (const Light& light : scene.lights) lights_.push_back(to_physical(light, field_.spacing()));
  if (guided) guide_.emplace(scene, extinction_, lights_);
}

// Facing the ray.
Vec3 PathTracer::normal_at(const Collision& collision, Vec3 direction, bool& enters, bool& flat) const {
  const Vec3 gradient = collision.normal == Vec3{} ? extinction_.gradient(collision.position) : -1.0 * collision.normal;
  enters = true;
  flat = gradient == Vec3{};
  if (flat) return -1.0 * direction;
  const Vec3 normal = normalise(-1.0 * gradient);
  enters = dot(normal, direction) < 0;
  return enters ? normal : -1.0 * normal;
}

void PathTracer::add_seen_lights(Rgb& sum, const Rgb& weight, const Flight& flight, double reach, double most) const {
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const auto hit = hit_light(lights_[i], flight.origin, flight.direction);
    if (!hit || hit->distance >= reach) continue;
    for (std::size_t c = 0; c < 3; ++c)
      sum[c] += std::min(most, weight[c] * hit->radiance * scene_.light_colours[i][c]);
  }
}

void PathTracer::add_connections(Rgb& sum, const Rgb& weight, const Collision& collision, const Flight& flight,
                                 Vec3 normal, CounterRandom& random) const {
  const Material& material = scene_.materials[static_cast<std::size_t>(collision.tag)];
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const LightSample light = sample_light(lights_[i], collision.position, random);
    if (light.weight == 0) continue;
    const double towards = density(material, flight.direction, normal, light.direction) * light.weight;
    if (towards == 0) continue;
    const Flight back{collision.position, light.direction, true, material.bsdf == Bsdf::kTrap && material.surface};
    add(sum, weight, towards * extinction_.transmittance(back, light.distance, random), scene_.light_colours[i]);
  }
}

// By the material or by the guide, and weighed by the density of both together.
Vec3 PathTracer::go_on(const Material& material, const Collision& collision, Vec3 direction, Vec3 normal, Rgb& weight,
                       CounterRandom& random) const {
  const LightGuide::Cell cell = guide_ ? guide_->cell(extinction_.voxel_of(collision.position)) : LightGuide::Cell{};
  if (cell.sums == nullptr) return scatter(material, direction, normal, true, random);
  const bool guided = random.uniform() < 0.5;
  const Vec3 out = guided ? guide_->sample(cell, random) : scatter(material, direction, normal, true, random);
  const double own = density(material, direction, normal, out);
  if (own == 0) return {};
  for (double& part : weight) part *= own / (0.5 * own + 0.5 * guide_->density(cell, out));
  return out;
}

Rgb PathTracer::radiance(Vec3 origin, Vec3 direction, CounterRandom& random) const {
  Rgb sum{}, weight{1, 1, 1};
  // Shares of the light that continues: the weight without those of choices, which are small where much light comes
  // from.
  Rgb shares{1, 1, 1};
  Flight flight{extinction_.place_of(origin), normalise(direction)};
  bool sees_lights = scene_.sees_lights;
  double most_seen = scene_.max_seen;  // until the light has been scattered every way
  for (int scatterings = 0;; ++scatterings) {
    const auto collision = extinction_.collide(flight, std::numeric_limits<double>::infinity(), random);
    if (sees_lights) {
      add_seen_lights(sum, weight, flight, collision ? collision->distance : std::numeric_limits<double>::infinity(),
                      most_seen);
    }
    if (!collision) {
      if (scene_.environment) add(sum, weight, 1, scene_.environment(flight.direction));
      return sum;
    }
    const auto tag = static_cast<std::size_t>(collision->tag);
    const Material& material = scene_.materials[tag];
    if (material.bsdf == Bsdf::kNone || scatterings == scene_.max_scatterings) return sum;
    for (std::size_t c = 0; c < 3; ++c) {
      const double share = material.scattering * scene_.scattering_colours[tag][c];
      weight[c] *= share, shares[c] *= share;
    }
    const double most = *std::max_element(shares.begin(), shares.end());
    const double survives = std::min(1.0, most / kRouletteBelow);
    if (random.uniform() >= survives) return sum;
    for (std::size_t c = 0; c < 3; ++c) weight[c] /= survives, shares[c] /= survives;

    bool enters = true, flat = true;
    const Vec3 normal = normal_at(*collision, flight.direction, enters, flat);
    const bool sharp = is_sharp(material), trap = material.bsdf == Bsdf::kTrap;
    if (!sharp) add_connections(sum, weight, *collision, flight, normal, random);
    const bool straight = flat && trap && sharp;  // Fresnel's routine without a surface
    const Vec3 out = straight ? flight.direction
                     : sharp  ? scatter(material, flight.direction, normal, enters, random)
                              : go_on(material, *collision, flight.direction, normal, weight, random);
    if (out == Vec3{}) return sum;
    const bool solid = collision->normal != Vec3{};
    flight = {collision->position, out, true, trap && material.surface,
              solid && trap && dot(out, collision->normal) < 0};
    sees_lights = sharp;
    if (!sharp) most_seen = std::numeric_limits<double>::infinity();
  }
}

std::array<Estimate, 3> PathTracer::estimate(Vec3 origin, Vec3 direction, std::uint64_t paths,
                                             std::uint64_t seed) const {
  RgbTally tally;
  for (std::uint64_t i = 0; i < paths; ++i) {
    CounterRandom random(seed, i);
    tally.add(radiance(origin, direction, random));
  }
  return tally.estimate();
}

RadiancePicture PathTracer::render(std::uint64_t paths_per_pixel, std::uint64_t seed, unsigned threads) const {
  const View& view = scene_.scene.view;
  const Camera camera(view, field_.spacing());
  RadiancePicture picture{view.width, view.height, {}};
  picture.pixels.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
  const auto parts = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(paths_per_pixel)));  // along an edge
  std::atomic<int> next{0};
  const auto take_rows = [&] {
    for (int row = next++; row < view.height; row = next++) {
      for (int column = 0; column < view.width; ++column) {
        const auto pixel =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(column);
        RgbTally tally;
        for (std::uint64_t i = 0; i < paths_per_pixel; ++i) {
          CounterRandom random(seed, pixel * paths_per_pixel + i);
          // One path in each part of the pixel, and what is left over anywhere: the standard errors are a little too
          // large.
          const std::uint64_t part = i < parts * parts ? i : 0, of = i < parts * parts ? parts : 1;
          const double x = column + (static_cast<double>(part % of) + random.uniform()) / static_cast<double>(of);
          const double y = row + (static_cast<double>(part / of) + random.uniform()) / static_cast<double>(of);
          const Line line = camera.line(x, y);
          tally.add(radiance(line.origin, extinction_.place_of(line.direction), random));
        }
        picture.pixels[pixel] = tally.estimate();
      }
    }
  };
  std::vector<std::future<void>> others;
  const unsigned count = threads == 0 ? std::max(1u, std::thread::hardware_concurrency()) : threads;
  for (unsigned i = 1; i < count; ++i) others.push_back(std::async(std::launch::async, take_rows));
  take_rows();
  for (auto& other : others) other.get();
  return picture;
}

}  // namespace gicube::reference::paths
