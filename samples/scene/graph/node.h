// The scenegraph [P §4.1]: a hierarchy of transforms whose leaves are solids and scanned volumes.
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

#include "scene/formats/volume_file.h"
#include "scene/geometry/affine.h"
#include "scene/geometry/shape.h"

namespace gicube::samples {

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

using Content = std::variant<Group, Shape, ScanContent>;

struct Node {
  std::string name{};                   // for engines and messages
  std::vector<Transform> transforms{};  // applied to what the node holds, the first one first
  Content content{};
  std::string material{};  // a SceneMaterial's name; empty: the parent's
  std::vector<Node> children{};

  friend bool operator==(const Node&, const Node&) = default;
};

// Throws InputError: a zero axis or factor, or a number that is not finite.
Affine map_of(const std::vector<Transform>& transforms);

}  // namespace gicube::samples
