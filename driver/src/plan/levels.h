// The volumes that a plan tries: the whole volume, its visible part, and coarser versions of that part.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gicube/board.h"
#include "gicube/level_of_detail.h"

namespace gicube {

class Levels {
 public:
  // The caller's whole volume. Levels of detail are 0 and up; level 0 is the whole volume unless much of it is
  // invisible.
  static constexpr int kWhole = -1;

  // If `volume` has no samples, the board's volume is the only one. The memory of `volume` and `looks` must outlive
  // this object.
  Levels(Board& board, const VolumeView& volume, std::span<const TransferFunction> looks, bool gradients);

  bool own() const { return own_; }
  const VoxelBox& seen() const { return seen_; }  // the visible box, even if the rest is kept
  const VoxelBox& box() const { return box_; }    // of level 0
  const Placement& placement(int level) { return at(level).placement; }
  const Dims& dims(int level) { return at(level).dims; }
  const std::vector<LevelError>& errors() const { return errors_; }  // of level 1 and up
  // The coarsest level that has at least eight voxels along each edge.
  int max_level() const;

  // Loads that level and its looks, unless the board holds them. True if it was loaded.
  bool go_to(int level);

 private:
  struct OneVolume {
    VolumeView view;
    std::unique_ptr<DerivedVolume> derived;  // owns the view's memory; empty: the caller does
    Placement placement;
    Dims dims{};
  };
  OneVolume& at(int level);
  OneVolume derive(DerivedVolume volume, const Placement& outer) const;

  Board& board_;
  std::span<const TransferFunction> looks_;
  const bool own_, gradients_;
  VoxelBox seen_, box_;
  std::map<int, OneVolume> volumes_;
  std::vector<LevelError> errors_;
  std::optional<int> loaded_;
};

// Loads a volume and its transfer functions.
void load_with_looks(Board& board, const VolumeView& volume, const Placement& placement,
                     std::span<const TransferFunction> looks);
// The volume without gradients, unless `gradients`: pictures without shading need none.
VolumeView without_unused(VolumeView volume, bool gradients);

}  // namespace gicube
