// A box of space that is filled from a scenegraph and cut into voxels.
#pragma once

#include <vector>

#include "scene/geometry/voxel_world.h"
#include "scene/graph/material.h"
#include "scene/graph/node.h"

namespace gicube::samples {

constexpr int kMinWorldSize = 8, kMaxWorldSize = 1024;  // voxels an edge

struct World {
  Vec3 low{-1, -1, -1}, high{1, 1, 1};  // world units; the first and the last voxels' centres
  int size = 96;                        // voxels along the longest edge
  Node root;

  friend bool operator==(const World&, const World&) = default;
};

// Cubic voxels: the shorter edges get as many as come nearest to their length, at least 2.
// Throws InputError: a size out of range, an edge of the box that is not 1e-9 to 1e9 long.
WorldGrid grid_of(const World& world);

struct BuiltWorld {
  WorldGrid grid;
  VoxelWorld voxels;
  std::vector<TransferFunctionFile> looks;  // by tag 0..3, in densities 0..4095; unused tags are invisible
};

// Voxelises all nodes. Throws InputError that names node and field: a material that is not there, several looks for one
// tag, a scan's transfer function used for another scan's range, a mesh or scan that can't be read.
BuiltWorld build(const World& world, const std::vector<SceneMaterial>& materials, int threads = 0);

}  // namespace gicube::samples
