// The cells of the volume's faces, as a light sees them: unit squares between four face voxels [P §2.2].
#pragma once

#include <array>
#include <cstdint>

#include "firmware/vectors.h"
#include "words/words.h"

namespace gicube::emu {

// A rectangle seen from the origin: it lies at `height` > 0 along the third axis, spans [low, high] in the other two.
struct SeenRectangle {
  std::array<double, 2> low{};
  std::array<double, 2> high{};
  double height = 0;
};

// Steradian, exact at any distance: no difference of large numbers, 2 pi at most.
double solid_angle(const SeenRectangle& seen);

// The point that (s, t) of the unit square stands for, if the square is to be uniform in solid angle [Ureña, Fajardo,
// King 2013]. Where the solid angle is too small for that arithmetic (1e-4 sr), uniform on the rectangle.
std::array<double, 2> point_seen(const SeenRectangle& seen, double s, double t);

struct FaceCell {
  std::size_t axis = 0;               // of the face's normal
  bool far = false;                   // the face at `extent`, not at 0
  std::array<std::uint32_t, 2> at{};  // voxels along axis + 1 and axis + 2 (cyclic)
};

// All cells of the six faces of the box [0, extent] in one order: -x, +x, -y, +y, -z, +z, and rows in each.
class FaceCells {
 public:
  explicit FaceCells(const Point& extent);  // whole voxels in 10.14, at least one on each axis

  std::uint64_t count() const { return first_[6]; }
  FaceCell cell(std::uint64_t index) const;                      // index < count()
  double extent(std::size_t axis) const { return size_[axis]; }  // voxels

 private:
  std::size_t face(std::uint64_t index) const;

  std::array<std::uint32_t, 3> size_{};
  std::array<std::uint64_t, 7> first_{};  // cell of each face, and the end
};

}  // namespace gicube::emu
