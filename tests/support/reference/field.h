// A volume as a continuous field: value, material tag and gradient at any position, in double precision.
#pragma once

#include <optional>
#include <vector>

#include "encode/volume/gradients.h"
#include "gicube/volume.h"
#include "scene.h"

namespace gicube::reference {

// One interpolated sample, in two units that name the same thing: the volume's own, and densities 0..4095.
struct Sample {
  double value = 0;
  double density = 0;
};

// The volume's own range, or the default that volume.h states for its type.
ValueRange value_range(const VolumeView& volume);

class Field {
 public:
  // The volume must be one that a board would take; its memory must outlive the field.
  Field(const VolumeView& volume, const Quantisers& quantisers);

  const VolumeView& volume() const { return volume_; }
  ValueRange range() const { return range_; }
  Vec3 spacing() const { return spacing_; }  // voxel edges over the smallest

  // Positions in voxels, 0..size - 1 on each axis.
  Sample sample(Vec3 position) const;  // trilinear, of values held to the range
  int tag(Vec3 position) const;        // the nearest voxel's
  Vec3 gradient(Vec3 position) const;  // trilinear, of the voxels' gradients
  // Unit direction in which the value grows at a voxel, physical; zero where there is none.
  Vec3 voxel_gradient(int x, int y, int z) const;

 private:
  double value(int x, int y, int z) const;  // as in the volume; beyond its faces that of the nearest voxel
  Vec3 true_gradient(int x, int y, int z) const;
  std::size_t index(int x, int y, int z) const;

  VolumeView volume_;
  Quantisers quantisers_;
  ValueRange range_;
  Vec3 spacing_;
  std::vector<float> values_;  // every sample type fits a float exactly
  std::optional<GradientCodebook> codebook_;
};

}  // namespace gicube::reference
