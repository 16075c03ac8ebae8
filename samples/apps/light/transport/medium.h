// The host's model of the volume on the board: materials at a point, and positions of surfaces.
//
// Points are physical, in smallest voxel edges: a voxel's indices times the spacing.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/scene/scene.h"
#include "light/transport/optics.h"
#include "scene/names.h"

namespace gicube::samples {

class Medium {
 public:
  // Loads the scene's volume onto the board, with transfer functions by which first hits are where paths scatter: media
  // keep theirs, an opaque solid is opaque from half of its greatest opacity on, and so is a skin of glass. Throws
  // InputError: a material that paths can't follow, a cut plane.
  Medium(Board& board, const SceneSetup& setup, const Progress& progress = {});

  Vec3 voxel_of(Vec3 p) const { return {p.x / spacing_.x, p.y / spacing_.y, p.z / spacing_.z}; }
  Vec3 place_of(Vec3 v) const { return {v.x * spacing_.x, v.y * spacing_.y, v.z * spacing_.z}; }
  const Dims& dims() const { return dims_; }
  Vec3 middle() const { return 0.5 * high_; }
  double radius() const { return 0.5 * length(high_); }  // of a sphere round the volume

  const Optics& optics(int tag) const { return tags_[static_cast<std::size_t>(tag)].optics; }
  int tag(Vec3 place) const;            // of the nearest voxel
  double extinction(Vec3 place) const;  // of media, per length; 0 in solids
  // The tag of the solid at a place, if there is one.
  std::optional<int> solid(Vec3 place) const;
  // Whether the place is in glass, beneath its skin, where rays pass freely.
  bool in_body(Vec3 place) const;
  Vec3 normal(Vec3 place) const;  // unit vector towards lower values; zero where they are constant

  struct Span {
    double begin = 0, end = -1;  // begin < end: the part of a half line in the volume
  };
  Span inside(Vec3 place, Vec3 direction) const;

 private:
  struct Tag {
    Optics optics;
    TransferFunction function;     // of media
    double surface = 0, body = 0;  // of solids: values at the surface, and beneath the skin of glass
  };
  double value(Vec3 voxel) const;
  static Tag tag_of(const TransferFunction& look, const Optics& optics, const ValueRange& range,
                    const std::string& name);

  Vec3 spacing_{1, 1, 1}, high_;
  Dims dims_{};
  std::vector<float> values_;
  std::vector<std::uint8_t> materials_;  // empty: all 0
  std::array<Tag, 4> tags_{};
};

}  // namespace gicube::samples
