// Gradients of a volume as codes: the codebook of unit directions [P §3.3], and each voxel's code by a 3x3x3 Sobel
// filter or from the caller's own vectors.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gicube/vector.h"
#include "gicube/volume.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/voxel.h"

namespace gicube {

// Code 0 is "no gradient"; the others decode to what the board's LUT holds: 3 x 10 bits. Any number of threads may use
// it.
class GradientCodebook {
 public:
  // 40 latitude rings with 2,038 codes (docs/reference/hardware.md).
  GradientCodebook();
  // 1..2048 directions; [0] is the zero vector, the others are unit vectors to 1e-3. Throws BadArgument naming the
  // entry.
  explicit GradientCodebook(std::span<const Vec3> directions);

  // The code whose decoded direction (10 bits a component, brought back to unit length) is at the smallest angle to
  // `direction`, of any length; of equal ones the lowest. 0 for the zero vector, one that is not finite, and without
  // directions.
  std::uint16_t nearest(Vec3 direction) const;

  // The vectors that it was made from; none: the default rings.
  std::span<const Vec3> given() const { return given_; }

  // The LUT's 2048 words; codes that stand for nothing are zero.
  std::span<const wire::GradientEntry> entries() const { return entries_; }

 private:
  struct Cell;

  void build_grid();
  void refine(const Cell& cell, std::span<const std::uint16_t> candidates,
              std::span<std::vector<std::uint16_t>> lists) const;

  std::vector<Vec3> given_;
  std::vector<wire::GradientEntry> entries_;
  std::vector<Vec3> directions_;  // the entries decoded to unit length, by code
  // A cube around the origin, its faces +x -x +y -y +z -z cut into kGridSize^2 cells: cell i's candidates, of which one
  // is the nearest to any direction through the cell, are candidates_[begins_[i] .. begins_[i + 1]).
  std::vector<std::uint32_t> begins_;
  std::vector<std::uint16_t> candidates_;
};

// The physical direction in which each voxel's value grows, as the codebook's nearest code; one a voxel, x fastest.
//
// Without view.gradients: central differences smoothed 1-2-1 along both other axes, samples beyond the volume's faces
// being those on them, divided by the voxel edges. Below 1/8 density unit a (smallest) voxel edge there is no gradient:
// code 0. With view.gradients: the supplied direction's code, 0 for the zero vector. With neither: no codes at all.
//
// For a view that passed check_volume(). `threads`: how many may work at once, 0 = as many as the machine has.
std::vector<std::uint16_t> gradient_codes(const VolumeView& view, ValueRange range, const GradientCodebook& codebook,
                                          unsigned threads);

}  // namespace gicube
