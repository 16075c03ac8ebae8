// Rays through all pixels of a view into the board's sums.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cone_beam/geometry.h"
#include "gicube/board.h"

namespace gicube::samples {

// What a voxel near the source may get of one view that leaves a density of 1: of fine x fine rays a pixel.
double max_of_a_voxel(const ConeGeometry& geometry, int fine);

// Doubles the sums of voxels on the volume's faces (edges, corners: 4, 8 times), which only rays on one side of them reach.
void make_up_for_faces(std::vector<float>& sums, const Dims& dims);

class Backprojector {
 public:
  // `fine` x `fine` rays a pixel, deposits `step` voxels apart. `most`: the largest |density| that a ray will leave, and
  // `views` how many there are: they fix the unit of the sums, which are cleared.
  Backprojector(Board& board, const ConeGeometry& geometry, int fine, double step, double most, std::size_t views);

  // Leaves densities[i] times each ray's length, (fine rows) x (fine columns) of them, in the voxels on its way. Returns before
  // the board is done.
  void add(double angle, std::span<const double> densities);
  // Waits for all, and reads the sums; those of voxels on the volume's faces, which only rays on one side of them reach,
  // are made up for.
  std::vector<float> finish();

  std::uint64_t rays() const { return rays_; }
  std::uint64_t deposits() const { return deposits_; }
  std::uint64_t overflowed() const { return overflowed_; }

 private:
  void receive();

  Board& board_;
  const ConeGeometry& geometry_;
  int fine_;
  double step_;
  std::vector<Ticket> under_way_;
  std::uint64_t rays_ = 0, deposits_ = 0, overflowed_ = 0;
};

}  // namespace gicube::samples
