// The words of the board's pipeline, computed exactly from the tables of docs/reference/hardware.md: whole numbers
// where a table says how a word is rounded, doubles where it gives an error bound. Nothing here is shared with the
// board.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace gicube::reference {

// The whole number nearest to a / b, halves up; b > 0.
constexpr std::int64_t nearest(std::int64_t a, std::int64_t b) {
  const std::int64_t twice = 2 * a + b, whole = twice / (2 * b);
  return whole - (twice % (2 * b) < 0 ? 1 : 0);
}

// "Interpolation weights": a + ((b - a) w + 2^14 >> 15), the shift towards minus infinity.
constexpr std::int64_t interpolated(std::int64_t a, std::int64_t b, std::int64_t weight) {
  return a + nearest((b - a) * weight, std::int64_t{1} << 15);
}

// Eight voxels of a cell, x fastest, at 14-bit fractions: seven interpolators, along x, then y, then z.
constexpr std::int64_t trilinear(const std::array<std::int64_t, 8>& cell, const std::array<std::int64_t, 3>& fraction) {
  std::array<std::int64_t, 4> row{};
  for (std::size_t i = 0; i < 4; ++i) row[i] = interpolated(cell[2 * i], cell[2 * i + 1], 2 * fraction[0]);
  return interpolated(interpolated(row[0], row[1], 2 * fraction[1]), interpolated(row[2], row[3], 2 * fraction[1]),
                      2 * fraction[2]);
}

// "Products with full scale = 1": a b / (2^24 - 1), rounded.
constexpr std::int64_t product24(std::int64_t a, std::int64_t b) {
  constexpr std::int64_t kOne = (std::int64_t{1} << 24) - 1;
  return nearest(a * b, kOne);
}

// Opacity of a sample that stands for `lengths` voxel lengths, 0..1.
inline double corrected(double alpha, double lengths) {
  return alpha >= 1 ? 1 : -std::expm1(lengths * std::log1p(-alpha));
}

// "Reflectance map": corner-aligned bilinear intensity of the normal (x, y, z), 1 = diffuse plus specular of 128.
// Texels are at the 1/256 that the map's unit takes.
template <typename Texels>
double reflected(const Texels& texels, const std::array<double, 3>& normal) {
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
  }
  std::array<double, 2> place{};  // of the two other axes in order, in texels
  for (std::size_t i = 0, other = 0; i < 3; ++i) {
    if (i != axis) place[other++] = std::round((normal[i] / std::abs(normal[axis]) + 1) * 63.5 * 256) / 256;
  }
  const std::size_t face = 2 * axis + (normal[axis] < 0 ? 1 : 0);
  const double column = std::min(std::floor(place[0]), 126.0), row = std::min(std::floor(place[1]), 126.0);
  const double s = place[0] - column, t = place[1] - row;
  const auto texel = [&](double i, double j) {
    return texels[(face * 128 + static_cast<std::size_t>(j)) * 128 + static_cast<std::size_t>(i)] / 128.0;
  };
  return (1 - t) * ((1 - s) * texel(column, row) + s * texel(column + 1, row)) +
         t * ((1 - s) * texel(column, row + 1) + s * texel(column + 1, row + 1));
}

// SplitMix64's finaliser: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014.
constexpr std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

// "What a ray keeps, low albedo": of opacity a (24 bits), what is absorbed, (1 - Ks) a, Ks in 1/65535.
constexpr std::int64_t absorbed(std::int64_t a, std::int64_t ks) { return nearest(a * (65535 - ks), 65535); }

// And what of the rest is scattered, Ks a / (1 - (1 - Ks) a).
inline double scattered_share(double a, double ks) { return ks == 0 ? 0 : ks * a / (1 - (1 - ks) * a); }

}  // namespace gicube::reference
