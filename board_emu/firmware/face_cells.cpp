#include "firmware/face_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gicube::emu {

namespace {

constexpr double kMinSolidAngle = 1e-4;  // chosen: the arc cosines below are accurate to about 1e-8

// The angle between two planes through the origin, 0..pi. The normals need not be unit vectors.
double angle(const Vector& a, const Vector& b) {
  return std::acos(std::clamp(-dot(a, b) / (length(a) * length(b)), -1.0, 1.0));
}

// Solid angle of the triangle a b c whose triple product is `product` [Van Oosterom and Strackee 1983].
double triangle(const Vector& a, const Vector& b, const Vector& c, double product) {
  const double la = length(a), lb = length(b), lc = length(c);
  return 2 * std::atan2(product, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

std::array<Vector, 4> corners(const SeenRectangle& r, double z) {
  return {Vector{r.low[0], r.low[1], z}, Vector{r.high[0], r.low[1], z}, Vector{r.high[0], r.high[1], z},
          Vector{r.low[0], r.high[1], z}};
}

double mix(double a, double b, double t) { return a + t * (b - a); }

}  // namespace

double solid_angle(const SeenRectangle& seen) {
  const auto [a, b, c, d] = corners(seen, seen.height);
  // The triple product of both triangles is the height times twice their area.
  const double product = seen.height * (seen.high[0] - seen.low[0]) * (seen.high[1] - seen.low[1]);
  return triangle(a, b, c, product) + triangle(a, c, d, product);
}

std::array<double, 2> point_seen(const SeenRectangle& seen, double s, double t) {
  const std::array<double, 2> plain{mix(seen.low[0], seen.high[0], s), mix(seen.low[1], seen.high[1], t)};
  const auto corner = corners(seen, -seen.height);  // below the origin, as in the publication
  const Vector below = cross(corner[0], corner[1]), right = cross(corner[1], corner[2]),
               above = cross(corner[2], corner[3]), left = cross(corner[3], corner[0]);
  const double rest = 2 * std::numbers::pi - angle(above, left) - angle(left, below);
  const double whole = angle(below, right) + angle(right, above) - rest;
  if (!(whole > kMinSolidAngle)) return plain;
  // The part left of x has the solid angle s * whole.
  const double phi = s * whole + rest;
  const double b0 = below[2] / length(below), b1 = above[2] / length(above);
  const double f = (std::cos(phi) * b0 - b1) / std::sin(phi);
  const double c = std::clamp(std::copysign(1 / std::sqrt(f * f + b0 * b0), f), -1.0, 1.0);
  const double x = std::clamp(c * seen.height / std::sqrt(std::max(1 - c * c, 1e-14)), seen.low[0], seen.high[0]);
  // On that line, heights above the plane of x are uniform.
  const double across = std::sqrt(x * x + seen.height * seen.height);
  const double h =
      mix(seen.low[1] / std::hypot(across, seen.low[1]), seen.high[1] / std::hypot(across, seen.high[1]), t);
  const double y = std::clamp(h * across / std::sqrt(std::max(1 - h * h, 1e-14)), seen.low[1], seen.high[1]);
  return std::isfinite(x) && std::isfinite(y) ? std::array{x, y} : plain;
}

FaceCells::FaceCells(const Point& extent) {
  for (std::size_t axis = 0; axis < 3; ++axis) size_[axis] = static_cast<std::uint32_t>(extent[axis] / wire::kVoxel);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t axis = i / 2;
    first_[i + 1] = first_[i] + std::uint64_t{size_[(axis + 1) % 3]} * size_[(axis + 2) % 3];
  }
}

std::size_t FaceCells::face(std::uint64_t index) const {
  std::size_t face = 0;
  while (index >= first_[face + 1]) ++face;
  return face;
}

FaceCell FaceCells::cell(std::uint64_t index) const {
  const std::size_t i = face(index);
  const std::uint64_t in_face = index - first_[i], row = size_[(i / 2 + 1) % 3];
  return {i / 2, i % 2 == 1, {static_cast<std::uint32_t>(in_face % row), static_cast<std::uint32_t>(in_face / row)}};
}

}  // namespace gicube::emu
