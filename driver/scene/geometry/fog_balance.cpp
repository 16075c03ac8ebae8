#include "scene/geometry/fog_balance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "scene/common/cells.h"

namespace gicube::scene {
namespace {

constexpr int kFogReach = 3;   // chosen: distance in voxels over which missing fog is moved
constexpr int kFogRounds = 4;  // chosen: of moving on what a voxel has no room for

const double kFull = std::round(kFogDensity * kMaxDensity), kThin = std::round(kFogBesideSolids * kMaxDensity);

// Densities are in units of kThin.
class FogBalance {
 public:
  FogBalance(VoxelWorld& world, const std::array<bool, 4>& fogs, std::span<const std::uint16_t> due)
      : world_(world), fogs_(fogs), dims_(world.volume.dims), due_(due) {}

  bool shows_solids() const {
    for (std::size_t i = 0; i < due_.size(); ++i) {
      if (due_[i] != kNoFogDue && due_[i] > 0 && !is_fog(i)) return true;
    }
    return false;
  }

  void settle() {
    for (std::size_t i = 0; i < due_.size(); ++i) {
      if (is_fog(i)) set(i, density(i) * kThin / kFull);
    }
    std::vector<float> missing(due_.size());
    each_voxel(dims_, [&](const Dims& voxel, std::size_t index) {
      if (due_[index] == kNoFogDue) return;
      missing[index] = static_cast<float>(due_[index] * kThin / kFull - is_fog(index) * mean(voxel));
    });
    for (int round = 0; round < kFogRounds; ++round) {
      std::vector<float> more(due_.size());
      each_voxel(dims_, [&](const Dims& voxel, std::size_t index) {
        if (std::abs(missing[index]) >= 0.5F) hand_on(voxel, double{missing[index]}, more);
      });
      missing.assign(due_.size(), 0);
      each_voxel(dims_, [&](const Dims& voxel, std::size_t index) {
        if (more[index] == 0) return;
        const double share = seen(voxel), wanted = density(index) + double{more[index]} / share;
        set(index, wanted);
        missing[index] = static_cast<float>((wanted - density(index)) * share);
      });
    }
  }

 private:
  // visit(index, offset) for the voxels within `reach`.
  template <typename Visit>
  void around(const Dims& voxel, int reach, const Visit& visit) const {
    const auto inside = [](int at, int dim) { return at >= 0 && at < dim; };
    for (int z = -reach; z <= reach; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          const Dims other{voxel[0] + x, voxel[1] + y, voxel[2] + z};
          if (std::ranges::equal(other, dims_, inside)) visit(index_of(dims_, other), Dims{x, y, z});
        }
      }
    }
  }

  bool is_fog(std::size_t index) const { return fogs_[world_.tags[index]]; }
  double density(std::size_t index) const {
    std::uint16_t word = 0;
    std::memcpy(&word, &world_.volume.samples[2 * index], sizeof word);
    return word;
  }
  // Sets the nearest density in 0..kFull, which is below the densities at which a solid is visible.
  void set(std::size_t index, double density) {
    world_.set_density(index, std::clamp(density, 0.0, kFull) / kMaxDensity);
  }

  // The mean of the interpolated density over a voxel's cube.
  double mean(const Dims& voxel) const {
    return weighted(voxel, [&](std::size_t other) { return density(other); });
  }
  // The part of a voxel's interpolation weight that is in voxels of fog.
  double seen(const Dims& voxel) const {
    return weighted(voxel, [&](std::size_t other) { return is_fog(other) ? 1.0 : 0.0; });
  }
  template <typename Value>
  double weighted(const Dims& voxel, const Value& value) const {
    double sum = 0, weights = 0;
    around(voxel, 1, [&](std::size_t other, const Dims& offset) {
      double weight = 1;
      for (const int away : offset) weight *= away == 0 ? 0.75 : 0.125;
      sum += weight * value(other);
      weights += weight;
    });
    return sum / weights;
  }

  // Moves the missing density to near voxels of fog that have room; nearer ones get more. It is negative where a
  // solid's density is seen as fog.
  void hand_on(const Dims& voxel, double missing, std::vector<float>& more) const {
    const auto each = [&](const auto& give) {
      around(voxel, kFogReach, [&](std::size_t index, const Dims& offset) {
        if (!is_fog(index) || density(index) >= kFull) return;
        const int square = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
        give(index, 1.0 / (1 + square * square));
      });
    };
    double weights = 0;
    each([&](std::size_t, double weight) { weights += weight; });
    each([&](std::size_t index, double weight) { more[index] += static_cast<float>(missing * weight / weights); });
  }

  VoxelWorld& world_;
  const std::array<bool, 4>& fogs_;
  const Dims dims_;
  std::span<const std::uint16_t> due_;
};

}  // namespace

void balance_fog(VoxelWorld& world, const std::array<bool, 4>& fogs, std::span<const std::uint16_t> due) {
  FogBalance balance(world, fogs, due);
  if (!balance.shows_solids()) return;
  balance.settle();
  world.fog_density = kFogBesideSolids;
}

}  // namespace gicube::scene
