// The viewing rays of a picture, and the part of a ray that lies in what is kept of the volume.
#pragma once

#include <optional>
#include <span>

#include "gicube/view.h"
#include "gicube/volume.h"

namespace gicube::reference {

// From `origin` (voxels) along `direction` (unit length in voxels).
struct Line {
  Vec3 origin;
  Vec3 direction;

  Vec3 at(double t) const { return origin + t * direction; }
};

// `spacing`: voxel edges over the smallest. The camera stands in physical space, spacing * voxels.
class Camera {
 public:
  Camera(const View& view, Vec3 spacing);

  // The ray through image point (x, y), pixels from the top left corner.
  Line line(double x, double y) const;
  // Physical unit vector from look_at to the eye.
  Vec3 towards_eye() const { return -1.0 * forward_; }

 private:
  bool perspective_;
  Vec3 spacing_;
  Vec3 eye_;  // physical
  Vec3 forward_, right_, up_;
  double middle_x_, middle_y_;  // pixels
  double pixel_;                // edge of a pixel: orthographic physical, perspective at distance 1
};

struct Interval {
  double begin = 0;
  double end = 0;
};

// Where, from its origin on, a line is inside the box [0, size - 1] and on the kept side of every plane; voxels.
std::optional<Interval> clip(const Line& line, Dims dims, std::span<const CutPlane> planes);

}  // namespace gicube::reference
