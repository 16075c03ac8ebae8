// The volumes that a plan tries: the whole one, the part of it that can be seen, and coarser ones of that part.
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
  // Beside the levels of detail, 0 and up: all of the caller's volume. It is level 0 too unless much of it is
  // invisible.
  static constexpr int kWhole = -1;

  // Without samples `volume` is what the board holds, and there is that one only. What `volume` and `looks` point to
  // must outlive this object.
  Levels(Board& board, const VolumeView& volume, std::span<const TransferFunction> looks, bool gradients);

  bool own() const { return own_; }
  const VoxelBox& seen() const { return seen_; }  // what can be seen, whether or not the rest is left out
  const VoxelBox& box() const { return box_; }    // of level 0
  const Placement& placement(int level) { return at(level).placement; }
  const Dims& dims(int level) { return at(level).dims; }
  const std::vector<LevelError>& errors() const { return errors_; }  // of level 1 and up
  // The levels that have at least eight voxels an edge.
  int max_level() const;

  // Has the board hold that level, with its looks. True if something had to be loaded.
  bool go_to(int level);

 private:
  struct OneVolume {
    VolumeView view;
    std::unique_ptr<DerivedVolume> derived;  // whose view it is; empty: the caller's
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

// Loads a volume and what it looks like.
void load_with_looks(Board& board, const VolumeView& volume, const Placement& placement,
                     std::span<const TransferFunction> looks);
// The volume as pictures without shading need it, if these are such.
VolumeView without_unused(VolumeView volume, bool gradients);

}  // namespace gicube
