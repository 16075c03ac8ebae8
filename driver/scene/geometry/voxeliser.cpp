#include "gicube/scene/voxeliser.h"
#include "scene/common/cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gicube::scene {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
// Inside fog a solid's tag ends here: visible samples of the solid, within half a ramp of the surface, have no nearer voxel.
constexpr double kTagInFogVoxels = 1.3;

double ramp(double distance) { return std::clamp(0.5 - distance / kRampVoxels, 0.0, 1.0); }

// A solid as seen from the voxels.
struct Seen {
  const PlacedSolid* solid;
  Affine to_local;
  double stretch;  // voxels a local unit, at least

  explicit Seen(const PlacedSolid& placed)
      : solid(&placed), to_local(inverse(placed.to_voxels)), stretch(min_stretch(placed.to_voxels)) {}

  // Never further from 0 than the distance in voxels.
  double bound(Vec3 p) const { return stretch * solid->field(to_local.point(p)).distance; }
  // The distance to first order: exact for similar maps of exact fields, and always at the surface.
  Distance distance(Vec3 p) const {
    const Distance local = solid->field(to_local.point(p));
    const Vec3 gradient = to_local.transposed(local.away);
    const double slope = length(gradient);
    if (!(slope > 0)) return {stretch * local.distance, {}};
    return {local.distance / slope, (1 / slope) * gradient};
  }
};

// A solid in a cell: evaluated voxel by voxel, or known to fill it.
struct Candidate {
  const Seen* seen;
  bool fills;
};

// What solids of one kind do at a voxel.
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
  std::vector<Seen> seen;
  const std::vector<PlacedScan>& scans;
  VoxelWorld& target;

  void fill_cell(const Dims& first) {
    const double reach = kNearVoxels + (kCell - 1) * std::numbers::sqrt3 / 2;
    std::vector<Candidate> near;
    for (const Seen& solid : seen) {
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
      (candidate.seen->solid->fog ? fog : solid).add(distance, candidate.seen->solid->tag);
    }
    const double of_solid = ramp(solid.distance), of_fog = kFogDensity * ramp(fog.distance);
    double density = std::max(of_solid, of_fog);
    const bool free = solid.distance >= (of_fog > 0 ? kTagInFogVoxels : kNearVoxels);
    if (!free) {
      target.tags[index] = solid.tag;
    } else if (fog.distance < kNearVoxels) {
      target.tags[index] = fog.tag;
    }
    if (std::abs(solid.distance) < kNearVoxels) set_gradient(index, -1 * solid.away);
    if (solid.distance >= kTagInFogVoxels) take_scans(p, index, density);
    target.set_density(index, density);
  }

  void take_scans(Vec3 p, std::size_t index, double& density) {
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
    }
  }

  // As the driver would find it, but of this scan alone.
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
    constexpr double kFlat = 16.0 / 4095;  // chosen: half a density step a voxel; below it noise alone would be shaded
    return length(sum) > kFlat ? normalise(sum) : Vec3{};
  }

  void set_gradient(std::size_t index, Vec3 g) {
    if (std::isfinite(g.x + g.y + g.z)) target.set_gradient(index, g);
  }
};

}  // namespace

VoxelWorld voxelise(const WorldGrid& grid, const std::vector<PlacedSolid>& solids, const std::vector<PlacedScan>& scans,
                    int threads) {
  VoxelWorld world(grid.dims, "world", true);
  world.volume.range = ValueRange{0, kMaxDensity};
  Voxeliser voxeliser{grid.dims, {solids.begin(), solids.end()}, scans, world};
  each_cell(grid.dims, threads, [&](const Dims& first) { voxeliser.fill_cell(first); });
  return world;
}

}  // namespace gicube::scene
