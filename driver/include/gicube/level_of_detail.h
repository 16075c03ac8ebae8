// Parts of a volume and coarser versions of it, for pictures that need no more, and how far these are from the
// original. Sources: [P §5.3], pixel-to-voxel ratios below one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gicube/export.h"
#include "gicube/transfer_function.h"
#include "gicube/vector.h"
#include "gicube/view.h"
#include "gicube/volume.h"

namespace gicube {

// Where a derived volume lies in the original: its voxel p is at low + edge p there.
struct GICUBE_API Placement {
  Vec3 low{};
  double edge = 1;  // of one of its voxels, in the original's

  // The view with the camera, cut planes and image for the derived volume. View::step remains a number of its voxels.
  View view(View original) const;
  // The transfer function for the derived volume, whose values lie in `range`. Opacities refer to a voxel length, which
  // is `edge` times as long there. Between the board's 4096 densities they are interpolated linearly.
  TransferFunction look(const TransferFunction& original, ValueRange range) const;
};

// Owns what its view() points to.
struct GICUBE_API DerivedVolume {
  std::vector<std::byte> samples;
  SampleType type = SampleType::kFloat32;
  Dims dims{};
  Vec3 spacing{1, 1, 1};
  ValueRange range;
  std::vector<float> gradients;
  std::vector<std::uint8_t> tags;
  Placement placement;
  std::vector<std::uint8_t> colours;

  VolumeView view() const;
};

// The voxels of a box, with the same values, range and type. Throws BadArgument (box).
GICUBE_API DerivedVolume cropped(const VolumeView& volume, const VoxelBox& box);

// One voxel for 2^level of them on each axis, at their centre. Its value is their mean, its tag that of most of them
// (the first of equals), its colour their mean, its gradient the sum of given ones; without given gradients the driver
// finds them from the means. Beyond the faces the values of the faces continue. Values are float32 in the original's
// range. Level 1..6; throws BadArgument (level; fewer than two voxels on an axis are left).
//
// Wider filters than this mean have less Moiré but more blur, and the blur of a surface is most of the error that rays
// see.
GICUBE_API DerivedVolume coarser(const VolumeView& volume, int level);

// The difference of a coarser volume from its original.
struct LevelError {
  double largest_density = 0;  // at any point between voxels, in density units (4095 = the value range): a bound
  double rms_density = 0;      // over the points where either can change slope: voxels, and the middles between them
  // Largest error of a sample's opacity of one original voxel length, 0..1, for values that differ by
  // largest_density, the worst tag: a bound, reached where something is thinner than a coarse voxel.
  double largest_opacity = 0;
};

// `coarse`: what coarser() made of `volume`. `functions`: by tag, in the volume's values.
GICUBE_API LevelError level_error(const VolumeView& volume, const DerivedVolume& coarse,
                                  std::span<const TransferFunction> functions);

// How many voxel edges (the smallest) one pixel is wide where the box is nearest to the eye; less than one: each voxel
// has several pixels. 0 if some of the box is beside or behind the eye.
GICUBE_API double voxels_a_pixel(const View& view, const VoxelBox& box, Vec3 spacing);
// The coarsest level whose voxels are not larger than that: the level of detail that a picture can show [P §5.3].
GICUBE_API int level_for(double voxels_a_pixel);

// Detail of the last picture of a volume in bricks (Board::set_brick_detail()).
struct BrickDetail {
  std::array<std::size_t, 4> blocks{};  // on the card: as they are, and in cells of 2^3, 4^3 and 8^3 voxels
  double largest_density = 0;           // by which a sample's density can be wrong, 4095 = the value range: a bound
  double largest_opacity = 0;           // and its opacity of one voxel length, 0..1, the worst tag: a bound
};

// The smallest box of whole 4^3 blocks in which any sample can have an opacity, and one voxel more on each side for the
// gradients; nothing outside shows in a picture. The whole volume if nothing is visible at all.
GICUBE_API VoxelBox visible_box(const VolumeView& volume, std::span<const TransferFunction> functions);

}  // namespace gicube
