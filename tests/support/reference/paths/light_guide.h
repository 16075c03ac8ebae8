// Where light comes from that mirrors and glass have turned on its way from a lamp: few paths from the eye come upon
// the lamp behind them by chance. It is a choice of directions; the density with which they were chosen is divided out,
// so it changes the noise alone.
#pragma once

#include <cstdint>
#include <vector>

#include "extinction.h"
#include "path_scene.h"

namespace gicube::reference::paths {

class LightGuide {
 public:
  // Sends rays from the lights (physical) through mirrors and glass; none if the scene has neither, or no light with an
  // area.
  LightGuide(const PathScene& scene, const Extinction& extinction, const std::vector<Light>& lights);

  // The cell of a place, if light of this kind was found there.
  struct Cell {
    const std::uint32_t* sums = nullptr;  // over the bins of directions so far
  };
  Cell cell(Vec3 voxel) const;
  Vec3 sample(const Cell& cell, CounterRandom& random) const;
  double density(const Cell& cell, Vec3 direction) const;  // per solid angle, 1 over the sphere

 private:
  void send(const PathScene& scene, const Extinction& extinction, const Light& light, CounterRandom& random);
  void count(Vec3 voxel, Vec3 towards);
  std::size_t index(Vec3 voxel) const;

  std::array<int, 3> cells_{};
  Vec3 high_;                        // physical
  std::vector<std::uint32_t> bins_;  // counts, then their sums
};

}  // namespace gicube::reference::paths
