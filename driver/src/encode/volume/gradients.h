// Encodes gradients: the codebook of unit directions [P §3.3], and each voxel's code by a 3x3x3 Sobel filter or from
// the caller's vectors.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gicube/vector.h"
#include "gicube/volume.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/voxel.h"

namespace gicube {

// Code 0 is "no gradient"; the others decode to the entries of the board's LUT, 3 x 10 bits. Several threads may use it
// at once.
class GradientCodebook {
 public:
  // 40 latitude rings with 2,038 codes (docs/reference/hardware.md).
  GradientCodebook();
  // 1..2048 directions: [0] is the zero vector, the others have length 1 within 1e-3. Throws BadArgument naming the
  // entry.
  explicit GradientCodebook(std::span<const Vec3> directions);

  // The code whose decoded direction has the smallest angle to `direction`, of any length; the lowest of equals. 0 if
  // `direction` is zero or not finite, or the codebook has no direction.
  std::uint16_t nearest(Vec3 direction) const;

  // The vectors given to the constructor; empty: the default rings.
  std::span<const Vec3> given() const { return given_; }

  // The LUT's 2048 entries; unused ones are zero.
  std::span<const wire::GradientEntry> entries() const { return entries_; }

 private:
  struct Cell;

  void build_grid();
  void refine(const Cell& cell, std::span<const std::uint16_t> candidates,
              std::span<std::vector<std::uint16_t>> lists) const;

  std::vector<Vec3> given_;
  std::vector<wire::GradientEntry> entries_;
  std::vector<Vec3> directions_;  // the entries decoded to unit length, by code
  // The faces +x -x +y -y +z -z of a cube around the origin are divided into kGridSize^2 cells each. The nearest code
  // to any direction through cell i is one of candidates_[begins_[i] .. begins_[i + 1]).
  std::vector<std::uint32_t> begins_;
  std::vector<std::uint16_t> candidates_;
};

// The codes of the physical directions in which the values grow; one per voxel, x fastest.
//
// Without view.gradients: central differences, smoothed 1-2-1 along both other axes, divided by the voxel edges;
// samples beyond a face equal those on it. A gradient below 1/8 density unit per smallest voxel edge has code 0. With
// view.gradients: the code of the given direction, 0 for the zero vector. If view.find_gradients is false: no codes.
//
// The view must have passed check_volume(). `threads`: at most so many are used; 0: one per core.
std::vector<std::uint16_t> gradient_codes(const VolumeView& view, ValueRange range, const GradientCodebook& codebook,
                                          unsigned threads);

}  // namespace gicube
