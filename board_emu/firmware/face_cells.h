// The cells of the volume's faces, as seen from a light: unit squares between four face voxels [P §2.2].
#pragma once

#include <array>
#include <cstdint>

#include "words/vectors.h"
#include "words/words.h"

namespace gicube::emu {

// A rectangle seen from the origin, at `height` > 0 on the third axis. It spans [low, high] on the other two.
struct SeenRectangle {
  std::array<double, 2> low{};
  std::array<double, 2> high{};
  double height = 0;
};

// Solid angle in steradian, at most 2 pi. Accurate at any distance, because large numbers are not subtracted.
double solid_angle(const SeenRectangle& seen);

// Maps (s, t) in the unit square to a point of the rectangle, uniformly in solid angle [Ureña, Fajardo, King 2013]. If
// the solid angle is too small for that arithmetic (1e-4 sr), the mapping is uniform in area.
std::array<double, 2> point_seen(const SeenRectangle& seen, double s, double t);

struct FaceCell {
  std::size_t axis = 0;               // axis of the face's normal
  bool far = false;                   // true: the face at `extent`; false: at 0
  std::array<std::uint32_t, 2> at{};  // voxels along axis + 1 and axis + 2 (cyclic)
};

// All cells of the six faces of the box [0, extent], in the order -x, +x, -y, +y, -z, +z, by rows within a face.
class FaceCells {
 public:
  explicit FaceCells(const Point& extent);  // whole voxels in 10.14, at least one on each axis

  std::uint64_t count() const { return first_[6]; }
  FaceCell cell(std::uint64_t index) const;                      // index < count()
  double extent(std::size_t axis) const { return size_[axis]; }  // voxels

 private:
  std::size_t face(std::uint64_t index) const;

  std::array<std::uint32_t, 3> size_{};
  std::array<std::uint64_t, 7> first_{};  // first cell of each face, and the total
};

}  // namespace gicube::emu
