#include "gicube/scene/voxeliser.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scene/common/cells.h"
#include "scene/geometry/fog_balance.h"
#include "scene/geometry/placed_field.h"

namespace gicube::scene {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
// In fog, a voxel has a solid's tag if it is the nearest voxel of a sample within this distance of the surface, since
// such samples show the solid. In voxels.
constexpr double kSeenVoxels = 0.4;
constexpr double kBesideScansVoxels = 1.3;  // scans do not change voxels within this distance of a solid
constexpr int kParts =
    4;  // chosen: parts of a voxel's edge, for its covered share; errors of volumes fall with the square

double ramp(double distance, double width = kRampVoxels) { return std::clamp(0.5 - distance / width, 0.0, 1.0); }

// A solid in a cell, which it may fill completely.
struct Candidate {
  const PlacedField* seen;
  bool fills;
};

// The union of the solids of one kind at a voxel.
struct Found {
  double distance = kFar;  // of the union
  Vec3 away;
  double tag_distance = kFar;
  std::uint8_t tag = 0;

  void add(const Distance& d, std::uint8_t own) {
    if (d.distance < distance) distance = d.distance, away = d.away;
    if (d.distance <= 0 || d.distance < tag_distance) tag_distance = d.distance, tag = own;
  }
};

struct Voxeliser {
  const Dims& dims;
  std::vector<PlacedField> seen;
  const std::vector<PlacedScan>& scans;
  VoxelWorld& target;
  Densities densities;
  std::vector<std::uint16_t> fog_due = {};  // if solids may stand in fog; FogBalance

  void fill_cell(const Dims& first) {
    const double reach = kNearVoxels + (kCell - 1) * std::numbers::sqrt3 / 2;
    std::vector<Candidate> near;
    for (const PlacedField& solid : seen) {
      const double bound = solid.bound(middle_of_cell(first));
      if (bound < reach) near.push_back({&solid, bound < -reach});
    }
    if (near.empty() && scans.empty()) return;
    each_voxel(dims, first, [&](Vec3 p, std::size_t index) { fill_voxel(p, index, near); });
  }

  void fill_voxel(Vec3 p, std::size_t index, const std::vector<Candidate>& near) {
    Found solid, fog;
    for (const Candidate& candidate : near) {
      const Distance distance = candidate.fills ? Distance{-kFar, {}} : candidate.seen->distance(p);
      (candidate.seen->solid().fog ? fog : solid).add(distance, candidate.seen->solid().tag);
    }
    const double of_solid = densities == Densities::kRamp ? ramp(solid.distance) : share_of(p, solid.distance, near);
    const double of_fog = kFogDensity * ramp(fog.distance);
    const Vec3& n = solid.away;
    const double nearest = (std::abs(n.x) + std::abs(n.y) + std::abs(n.z)) / 2;  // of a voxel's samples to the surface
    const bool free = solid.distance >= (of_fog > 0 ? kSeenVoxels + nearest : kNearVoxels);
    double density = free ? std::max(of_solid, of_fog) : of_solid;
    if (!free) {
      target.tags[index] = solid.tag;
    } else if (fog.distance < kNearVoxels) {
      target.tags[index] = fog.tag;
    }
    if (std::abs(solid.distance) < kNearVoxels) set_gradient(index, -1 * solid.away);
    const bool scanned = solid.distance >= kBesideScansVoxels && take_scans(p, index, density);
    target.set_density(index, density);
    if (fog_due.empty() || of_fog == 0 || scanned || !(solid.distance < kNearVoxels)) return;
    const double open = 1 - share_of(p, solid.distance, near);
    fog_due[index] = static_cast<std::uint16_t>(std::lround(kMaxDensity * of_fog * open));
  }

  // The part of a voxel that is within solids; `distance`: of their union from its centre.
  static double share_of(Vec3 p, double distance, const std::vector<Candidate>& near) {
    constexpr double kHalfDiagonal = std::numbers::sqrt3 / 2;
    if (std::abs(distance) >= kHalfDiagonal) return distance < 0 ? 1 : 0;
    constexpr double kPart = 1.0 / kParts;
    double sum = 0;
    for (int i = 0; i < kParts * kParts * kParts; ++i) {
      const int x = i % kParts, y = i / kParts % kParts, z = i / (kParts * kParts);
      const Vec3 at = p + Vec3{(x + 0.5) * kPart - 0.5, (y + 0.5) * kPart - 0.5, (z + 0.5) * kPart - 0.5};
      double least = kFar;
      for (const Candidate& candidate : near) {
        if (candidate.seen->solid().fog) continue;
        least = std::min(least, candidate.fills ? -kFar : candidate.seen->distance(at, kPart / 2).distance);
      }
      sum += ramp(least, kPart);
    }
    return sum / (kParts * kParts * kParts);
  }

  // Returns whether a scan has the voxel.
  bool take_scans(Vec3 p, std::size_t index, double& density) {
    bool any = false;
    for (const PlacedScan& scan : scans) {
      if (p.x < scan.low.x || p.y < scan.low.y || p.z < scan.low.z || p.x > scan.high.x || p.y > scan.high.y ||
          p.z > scan.high.z) {
        continue;
      }
      const double value = scan.density(p);
      if (value < 0 || (value < scan.visible && density > 0)) continue;
      density = std::min(value, 1.0);
      target.tags[index] = scan.tag;
      set_gradient(index, sobel(scan, p));
      any = true;
    }
    return any;
  }

  // The gradient like the driver's, but of this scan alone.
  static Vec3 sobel(const PlacedScan& scan, Vec3 p) {
    constexpr double kWeight[] = {1, 2, 1};
    Vec3 sum;
    for (int k = -1; k <= 1; ++k) {
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          if (i == 0 && j == 0 && k == 0) continue;
          const double value = std::max(scan.density(p + Vec3{double(i), double(j), double(k)}), 0.0);
          sum.x += i * kWeight[j + 1] * kWeight[k + 1] * value;
          sum.y += j * kWeight[k + 1] * kWeight[i + 1] * value;
          sum.z += k * kWeight[i + 1] * kWeight[j + 1] * value;
        }
      }
    }
    constexpr double kFlat = 16.0 / 4095;  // chosen: half a density step per voxel, below which there is only noise
    return length(sum) > kFlat ? normalise(sum) : Vec3{};
  }

  void set_gradient(std::size_t index, Vec3 g) {
    if (std::isfinite(g.x + g.y + g.z)) target.set_gradient(index, g);
  }
};

}  // namespace

VoxelWorld voxelise(const WorldGrid& grid, const std::vector<PlacedSolid>& solids, const std::vector<PlacedScan>& scans,
                    int threads, Densities densities) {
  VoxelWorld world(grid.dims, "world", true);
  world.volume.range = ValueRange{0, kMaxDensity};
  Voxeliser voxeliser{grid.dims, {solids.begin(), solids.end()}, scans, world, densities};
  std::array<bool, 4> fogs{};
  bool any_fog = false, any_solid = false;
  for (const PlacedSolid& solid : solids) {
    (solid.fog ? any_fog : any_solid) = true;
    if (solid.fog) fogs[solid.tag] = true;
  }
  if (any_fog && any_solid) voxeliser.fog_due.assign(world.tags.size(), kNoFogDue);
  each_cell(grid.dims, threads, [&](const Dims& first) { voxeliser.fill_cell(first); });
  if (!voxeliser.fog_due.empty()) balance_fog(world, fogs, voxeliser.fog_due);
  return world;
}

}  // namespace gicube::scene
