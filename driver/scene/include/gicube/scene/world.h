// The scenegraph [P §4.1]: a hierarchy of transforms whose leaves are solids, hypertextures and scanned volumes.
//
//   Node ring;
//   ring.transforms = {Rotate{{1, 0, 0}, 90}, Translate{{0, 0, 0.5}}};   // applied in this order
//   ring.content = TorusShape{0.8, 0.1};
//   ring.material = "gold";
//   scene.world->root.children.push_back(ring);
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "gicube/scene/affine.h"
#include "gicube/scene/hypertexture.h"
#include "gicube/scene/material.h"
#include "gicube/scene/shape.h"
#include "gicube/scene/volume_file.h"
#include "gicube/scene/voxeliser.h"

namespace gicube::scene {

struct Translate {
  Vec3 by;
  friend bool operator==(const Translate&, const Translate&) = default;
};

struct Rotate {  // counter-clockwise as seen against the axis
  Vec3 axis{0, 0, 1};
  double degrees = 0;
  friend bool operator==(const Rotate&, const Rotate&) = default;
};

struct Scale {  // none 0
  Vec3 by{1, 1, 1};
  friend bool operator==(const Scale&, const Scale&) = default;
};

using Transform = std::variant<Translate, Rotate, Scale>;

// A scan's physical box is centred on the node's origin, its longest edge 1 long.
struct ScanContent {
  VolumeSource source;
  friend bool operator==(const ScanContent&, const ScanContent&) = default;
};

struct Group {
  friend bool operator==(const Group&, const Group&) = default;
};

using Content = std::variant<Group, Shape, ScanContent, Hypertexture>;

struct Node {
  std::string name{};                   // for engines and messages
  std::vector<Transform> transforms{};  // applied to what the node holds, the first one first
  Content content{};
  std::string material{};  // a SceneMaterial's name; empty: the parent's
  std::vector<Node> children{};

  friend bool operator==(const Node&, const Node&) = default;
};

// Throws InputError: a zero axis or factor, or a number that is not finite.
GICUBE_API Affine map_of(const std::vector<Transform>& transforms);

constexpr int kMinWorldSize = 8, kMaxWorldSize = 1024;  // voxels an edge

// A box of space whose voxels are filled from a scenegraph.
struct World {
  Vec3 low{-1, -1, -1}, high{1, 1, 1};  // world units; the first and the last voxels' centres
  int size = 96;                        // voxels along the longest edge
  Densities densities = Densities::kRamp;
  Node root{};

  friend bool operator==(const World&, const World&) = default;
};

// Cubic voxels: the number along the shorter edges is the nearest to their length, at least 2. Throws InputError: a
// size out of range, an edge of the box that is not 1e-9 to 1e9 long.
GICUBE_API WorldGrid grid_of(const World& world);

struct BuiltWorld {
  WorldGrid grid;
  VoxelWorld voxels;
  std::vector<TransferFunctionFile> looks;  // by tag 0..3, in densities 0..4095; unused tags are invisible
};

// Voxelises all nodes. Throws InputError that names node and field: a missing material, several looks for one tag, a
// scan's transfer function used for another scan's range, a mesh or scan that cannot be read.
GICUBE_API BuiltWorld build(const World& world, const std::vector<SceneMaterial>& materials, int threads = 0);

}  // namespace gicube::scene
