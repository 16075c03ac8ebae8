#include "light_guide.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scattering.h"

namespace gicube::reference::paths {

namespace {

constexpr double kPi = std::numbers::pi;
// Chosen: bins of five degrees, as wide as a small lamp, and cells that are small against the distance of a mirror.
constexpr int kEdge = 6;                   // voxels of a cell
constexpr int kHeights = 32, kTurns = 64;  // of the direction's z, and about it: of equal solid angle
constexpr std::size_t kBins = kHeights * kTurns;
constexpr std::uint64_t kRays = 1'000'000;     // of a light
constexpr std::uint32_t kFound = 64;           // a ray's count in its bin, of 1 in each of the eight around it
constexpr std::uint32_t kFewest = 8 * kFound;  // of a cell
constexpr int kMaxTurned = 16;                 // mirrors in a row

int bin_of_height(double z) { return std::clamp(static_cast<int>((1 - z) / 2 * kHeights), 0, kHeights - 1); }
int bin_of_turn(Vec3 direction) {
  const double turn = std::atan2(direction.y, direction.x) / (2 * kPi);
  return std::clamp(static_cast<int>((turn < 0 ? turn + 1 : turn) * kTurns), 0, kTurns - 1);
}

Vec3 start_of(const PointLight& light, Vec3, double, CounterRandom&) { return light.position; }
Vec3 start_of(const DirectionalLight& light, Vec3 target, double far, CounterRandom&) {
  return target + far * normalise(light.towards);
}
Vec3 start_of(const RectangleLight& light, Vec3, double, CounterRandom& random) {
  const double u = random.uniform();
  return light.corner + u * light.edge_u + random.uniform() * light.edge_v;
}
Vec3 start_of(const SphereLight& light, Vec3, double, CounterRandom& random) {
  return light.centre + light.radius * random.direction();
}

}  // namespace

LightGuide::LightGuide(const PathScene& scene, const Extinction& extinction, const std::vector<Light>& lights) {
  const auto has_area = [](const Light& light) {
    return std::holds_alternative<RectangleLight>(light) || std::holds_alternative<SphereLight>(light);
  };
  if (std::none_of(scene.materials.begin(), scene.materials.end(), is_sharp)) return;
  if (std::none_of(lights.begin(), lights.end(), has_area)) return;
  const Dims& dims = scene.scene.volume.dims;
  std::size_t all = kBins;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cells_[axis] = (dims[axis] + kEdge - 1) / kEdge;
    all *= static_cast<std::size_t>(cells_[axis]);
  }
  bins_.assign(all, 0);
  high_ = extinction.place_of({dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0});
  std::uint64_t stream = 0;
  for (const Light& light : lights) {
    if (!has_area(light)) continue;
    for (std::uint64_t i = 0; i < kRays; ++i) {
      CounterRandom random(7, stream++);
      send(scene, extinction, light, random);
    }
  }
  for (std::size_t first = 0; first < bins_.size(); first += kBins) {
    for (std::size_t i = 1; i < kBins; ++i) bins_[first + i] += bins_[first + i - 1];
  }
}

// Towards any place in the volume: which rays are sent makes no light.
void LightGuide::send(const PathScene& scene, const Extinction& extinction, const Light& light, CounterRandom& random) {
  const Vec3 target{random.uniform() * high_.x, random.uniform() * high_.y, random.uniform() * high_.z};
  const Vec3 from = std::visit([&](const auto& kind) { return start_of(kind, target, length(high_), random); }, light);
  Flight flight{from, normalise(target - from)};
  const auto* sheet = std::get_if<RectangleLight>(&light);
  if (sheet != nullptr && !(dot(cross(sheet->edge_u, sheet->edge_v), flight.direction) > 0)) return;
  for (int turned = 0; turned <= kMaxTurned; ++turned) {
    const auto met = extinction.collide(flight, std::numeric_limits<double>::infinity(), random);
    if (!met) return;
    const Material& material = scene.materials[static_cast<std::size_t>(met->tag)];
    if (!is_sharp(material)) {
      if (turned > 0) count(extinction.voxel_of(met->position), -1.0 * flight.direction);
      return;
    }
    if (met->normal == Vec3{}) return;  // soft mirrors are left out
    const bool enters = dot(met->normal, flight.direction) < 0, trap = material.bsdf == Bsdf::kTrap;
    const Vec3 out = scatter(material, flight.direction, enters ? met->normal : -1.0 * met->normal, enters, random);
    flight = {met->position, out, true, trap && material.surface, trap && dot(out, met->normal) < 0};
  }
}

// A bin and, with less, its neighbours: what was not found there may be.
void LightGuide::count(Vec3 voxel, Vec3 towards) {
  std::uint32_t* bins = &bins_[index(voxel) * kBins];
  const int height = bin_of_height(towards.z), turn = bin_of_turn(towards);
  for (int up = -1; up <= 1; ++up) {
    for (int round = -1; round <= 1; ++round) {
      const int h = std::clamp(height + up, 0, kHeights - 1), t = (turn + round + kTurns) % kTurns;
      bins[h * kTurns + t] += up == 0 && round == 0 ? kFound : 1;
    }
  }
}

std::size_t LightGuide::index(Vec3 voxel) const {
  const auto part = [](double at, int cells) { return std::clamp(static_cast<int>(at / kEdge), 0, cells - 1); };
  return static_cast<std::size_t>((part(voxel.z, cells_[2]) * cells_[1] + part(voxel.y, cells_[1])) * cells_[0] +
                                  part(voxel.x, cells_[0]));
}

LightGuide::Cell LightGuide::cell(Vec3 voxel) const {
  if (bins_.empty()) return {};
  const std::uint32_t* sums = &bins_[index(voxel) * kBins];
  return sums[kBins - 1] < kFewest ? Cell{} : Cell{sums};
}

Vec3 LightGuide::sample(const Cell& cell, CounterRandom& random) const {
  const auto chosen = static_cast<std::uint32_t>(random.uniform() * cell.sums[kBins - 1]);
  const auto bin = std::upper_bound(cell.sums, cell.sums + kBins - 1, chosen) - cell.sums;
  const double height = (static_cast<double>(bin / kTurns) + random.uniform()) / kHeights;
  const double turn = 2 * kPi * (static_cast<double>(bin % kTurns) + random.uniform()) / kTurns;
  const double z = 1 - 2 * height, ring = std::sqrt(std::max(0.0, 1 - z * z));
  return {ring * std::cos(turn), ring * std::sin(turn), z};
}

double LightGuide::density(const Cell& cell, Vec3 direction) const {
  const auto bin = static_cast<std::size_t>(bin_of_height(direction.z) * kTurns + bin_of_turn(direction));
  const std::uint32_t before = bin == 0 ? 0 : cell.sums[bin - 1];
  return static_cast<double>(cell.sums[bin] - before) / cell.sums[kBins - 1] * kBins / (4 * kPi);
}

}  // namespace gicube::reference::paths
