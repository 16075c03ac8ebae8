// Tomography on a board: line integrals of a volume for the pixels of flat detectors that stand anywhere, and the
// transpose of this map. Every iterative method is a few lines on the pair; samples/short/own_method.cpp writes one.
//
//   gicube::Projector projector(board, {.dims = {64, 64, 64}, .columns = 96, .rows = 80, .views = views});
//   std::vector<float> projections = projector.project(volume);       // [view][row][column]
//   std::vector<float> volume_again = projector.backproject(projections);
//
// Lengths have one unit of the caller's. The origin is the volume's middle, and x, y, z run along its axes.
// docs/guide/cone_beam_geometry.md draws the conventions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "gicube/board.h"
#include "gicube/export.h"
#include "gicube/ray.h"
#include "gicube/vector.h"

namespace gicube {

// One view: a source and a flat detector. Pixel (column, row) is at
//   centre + (column - (columns - 1) / 2) u + (row - (rows - 1) / 2) v.
struct ViewPose {
  Vec3 source;  // outside of the box of the volume's voxel centres
  Vec3 centre;  // of the detector
  Vec3 u, v;    // from a pixel to the next in its row, and in its column; not parallel

  friend bool operator==(const ViewPose&, const ViewPose&) = default;
};

struct ProjectorSetup {
  Dims dims{};                // voxels, at least 2 an axis
  Vec3 spacing{1, 1, 1};      // edges of a voxel, > 0
  int columns = 0, rows = 0;  // pixels of all detectors, at least 1
  std::vector<ViewPose> views{};
  double step = 1;  // between samples, at most, 1/64..16 voxels
};

// Counts of a Projector's rays since it was made.
struct ProjectorCounts {
  std::uint64_t rays = 0;        // of both directions
  std::uint64_t deposits = 0;    // of backprojections
  std::uint64_t overflowed = 0;  // sums that were full: the values are wrong there
};

// Uses the board's volume and sums, which its calls replace: nothing else may load a volume between them. The board
// must outlive it.
class GICUBE_API Projector {
 public:
  // Throws BadArgument that names the field of the setup.
  Projector(Board& board, ProjectorSetup setup);

  const ProjectorSetup& setup() const { return setup_; }
  const ProjectorCounts& counts() const { return counts_; }

  // Indices of views, in any order; empty: all of them.
  using Views = std::span<const std::size_t>;
  // One view's values, rows first.
  using TakeView = std::function<void(std::size_t i, const std::vector<float>& values)>;
  using ViewValues = std::function<std::vector<double>(std::size_t i)>;

  // Line integrals of `volume` (x fastest) from the source to each pixel, view after view, rows first. Values are
  // trilinear between the voxel centres, and zero outside of their box. The board holds the volume in 12 bits between
  // its least value, at most 0, and its greatest. Throws BadArgument (another number of values than voxels, one that is
  // not finite, a view that is not there), what the board throws.
  std::vector<float> project(std::span<const float> volume, Views views = {});
  // Projects view by view: take(i, values) for the i-th of `views`. Meanwhile the board works on the next view.
  void project(std::span<const float> volume, Views views, const TakeView& take);

  // The transpose of project(): each ray leaves its value, times its length in a voxel by the same interpolation, in
  // that voxel. One float per voxel, x fastest. `values`: as many as project() returns for these views. Throws
  // BadArgument (another number of values, one that is not finite), what the board throws.
  std::vector<float> backproject(std::span<const float> values, Views views = {});
  // Backprojects views that need not all be in memory: values(i) gives those of the i-th of `views`, and is asked in
  // this order. No value may be larger in size than `max`, which fixes the unit of the board's sums: half of a sum's
  // range holds `max` on all rays.
  std::vector<float> backproject(Views views, double max, const ViewValues& values);

  // Loads an empty volume, as backproject() does where nothing was projected before.
  void load_nothing();

  // The rays of a view's pixels, rows first, clipped to the volume, in voxels; a ray that misses it has no length.
  std::vector<HostRay> rays(std::size_t view) const;
  // The length of such a ray in the caller's unit.
  double length_of(const HostRay& ray) const;
  // An upper bound of what a voxel receives from one view whose rays all have the value 1.
  double max_of_a_voxel(std::size_t view) const;

 private:
  std::vector<std::size_t> checked(Views views) const;
  void load(std::span<const float> volume);

  Board& board_;
  ProjectorSetup setup_;
  ProjectorCounts counts_;
  bool loaded_ = false;  // whether the board has a volume of these dims
};

}  // namespace gicube
