// Pairs of elements between which the DSP generates rays: the most expensive part of a form factor [P §5.6]. The bus
// carries one number per pair instead of two ray packets per ray. README.md defines the bytes.
//
// The samples of a pair are points of a Sobol' sequence in six dimensions, scrambled by a hash of (id, seed). They
// cover both elements evenly for any number of samples, best for a power of two, and independently of other pairs. The
// samples of a request form eight consecutive runs. Each run covers the elements evenly by itself, so the variance of
// the runs' means bounds the error of the total. The weight of a sample is
//
//   G = f_a f_b / (pi r^2),  f = the cosine at a flat element, 0 behind it; 1 in a box
//
// where r is physical, in reference voxel edges. A ray between the two points measures the transmittance T. Boards
// before 2.2 have other samples and error estimates, and only patches and boxes. Drivers generate the rays for them on
// the host.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "gicube/wire/command.h"
#include "gicube/wire/mix64.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/record.h"
#include "gicube/wire/sobol.h"

namespace gicube::wire {

inline constexpr std::uint32_t kMaxRaysPerPair = 65'536;
inline constexpr std::uint32_t kMaxPairRays = 1u << 22;  // per command; chosen: about one second of the DSP's work

inline constexpr std::uint16_t kPairsMinor = 2;

using Vector = std::array<double, 3>;

enum class ElementKind : std::uint32_t { kPatch = 0, kBox = 1, kTriangle = 2, kDisc = 3 };

// Coordinates in voxels. The front of a flat element is on the side of u x v.
//   patch     origin + s u + t v, 0..1 each; w = 0
//   box       origin + s u + t v + r w: a part of the volume
//   triangle  the half of a patch with s + t <= 1; w = 0
//   disc      origin + s u + t v, s^2 + t^2 <= 1: u and v are half-axes of a circle or an ellipse. w[0] is the share of
//             the area that a central hole removes, w[1] the share of the turn from u to v that is cut off at its end;
//             both 0..1, but not 1
struct Element {
  ElementKind kind = ElementKind::kPatch;
  std::array<float, 3> origin{}, u{}, v{}, w{};

  constexpr void fields(auto&& list) { list(kind, Reserved<4>{}, origin, u, v, w); }
  friend constexpr bool operator==(const Element&, const Element&) = default;
};
inline constexpr std::size_t kElementBytes = bytes_of<Element>();

struct PairsHeader {
  std::uint32_t elements = 0;
  std::uint32_t pairs = 0;
  std::uint32_t rays = 0;   // per pair
  std::uint32_t first = 0;  // index of the first sample
  std::uint32_t seed = 0;
  std::uint32_t opacity = kOpacityOne;  // 24 bits, not 0: opacity at which a ray ends

  constexpr void fields(auto&& list) {
    list(Opcode::kPairs, elements, pairs, rays, first, seed, opacity, Reserved<4>{});
  }
  friend constexpr bool operator==(const PairsHeader&, const PairsHeader&) = default;
};
inline constexpr std::size_t kPairsHeaderBytes = bytes_of<PairsHeader>();

struct Pair {
  std::uint32_t a = 0, b = 0;  // elements
  std::uint32_t id = 0;        // selects the sample points

  constexpr void fields(auto&& list) { list(a, b, id); }
  friend constexpr bool operator==(const Pair&, const Pair&) = default;
};
inline constexpr std::size_t kPairBytes = bytes_of<Pair>();

// Result of a pair.
struct PairResult {
  double transported = 0;    // mean of G T
  float geometric = 0;       // mean of G
  float standard_error = 0;  // of `transported`, from the means of its runs; infinite for fewer than 8 samples

  constexpr void fields(auto&& list) { list(transported, geometric, standard_error); }
  friend constexpr bool operator==(const PairResult&, const PairResult&) = default;
};
inline constexpr std::size_t kPairResultBytes = bytes_of<PairResult>();

// Driver and board both compute the following. Only IEEE operations are used, so all machines get the same bits.

// Number of runs. Chosen: more runs estimate the error better, but are shorter.
inline constexpr std::uint32_t kPairRuns = 8;

constexpr std::uint32_t bits_reversed(std::uint32_t x) {
  x = (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
  x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
  x = (x & 0x0F0F0F0Fu) << 4 | (x >> 4 & 0x0F0F0F0Fu);
  x = (x & 0x00FF00FFu) << 8 | (x >> 8 & 0x00FF00FFu);
  return x << 16 | x >> 16;
}

// Contribution of each index bit to each coordinate, with the bits reversed. Flat elements use the first four
// dimensions.
inline constexpr auto kPairColumns = [] {
  constexpr std::array<std::uint32_t, 6> kDimension{0, 1, 4, 2, 3, 5};
  std::array<std::array<std::uint32_t, 6>, 32> columns{};
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    for (std::size_t d = 0; d < 6; ++d) columns[bit][d] = bits_reversed(sobol(1u << bit, kDimension[d]));
  }
  return columns;
}();

// Scrambles a number whose bits are reversed. Each bit of the result depends only on those below it, as Owen's
// scrambling requires [Laine and Karras, "Stratified sampling for stochastic transparency", EGSR 2011; the constants
// are Vegdahl's, "Building a better LK hash", 2021].
constexpr std::uint32_t scrambled(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3D20ADEAu;
  x += seed;
  x *= seed >> 16 | 1;
  x ^= x * 0x05526C56u;
  x ^= x * 0x53A22864u;
  return x;
}

// Sample `index` of a pair, 0..1 on each axis: three coordinates for each of the two elements.
constexpr std::array<double, 6> pair_point(std::uint32_t id, std::uint32_t seed, std::uint32_t index) {
  std::array<std::uint32_t, 6> bits{};
  for (; index != 0; index &= index - 1) {
    const auto& column = kPairColumns[static_cast<std::size_t>(std::countr_zero(index))];
    for (std::size_t d = 0; d < 6; ++d) bits[d] ^= column[d];
  }
  const std::uint64_t of_pair = split_mix64(id | std::uint64_t{seed} << 32);
  std::array<double, 6> point{};
  for (std::size_t d = 0; d < 6; ++d) {
    point[d] = bits_reversed(scrambled(bits[d], static_cast<std::uint32_t>(split_mix64(of_pair ^ d)))) * 0x1p-32;
  }
  return point;
}

struct CosineSine {
  double cosine = 1, sine = 0;
};
// Cosine and sine of a fraction of a turn, 0..1: a Taylor series around the nearest quarter. The next terms are below
// 2e-14.
constexpr CosineSine cosine_sine(double turn) {
  const int quarter = (static_cast<int>(turn * 8) + 1) / 2;
  const double x = (turn - 0.25 * quarter) * (2 * std::numbers::pi), y = x * x;
  const double c =
      1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90 * (1 - y / 132 * (1 - y / 182))))));
  const double s = x * (1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72 * (1 - y / 110 * (1 - y / 156))))));
  switch (quarter & 3) {
    case 0: return {c, s};
    case 1: return {-s, c};
    case 2: return {-c, -s};
    default: return {s, -c};
  }
}

// Maps a point of the unit cube to the factors of u, v and w. Equal volumes of the cube map to equal areas of a flat
// element.
inline Vector place_in(const Element& element, const Vector& s) {
  if (element.kind == ElementKind::kTriangle) {  // Heitz 2019, "A low-distortion map between triangle and square"
    const double x = s[0] / 2, y = s[1] / 2;
    return y > x ? Vector{x, y + (y - x), 0} : Vector{x + (x - y), y, 0};
  }
  if (element.kind == ElementKind::kDisc) {
    const double hole = static_cast<double>(element.w[0]), cut = static_cast<double>(element.w[1]);
    const double radius = std::sqrt(hole + s[0] * (1 - hole));
    const auto [cosine, sine] = cosine_sine(s[1] * (1 - cut));
    return {radius * cosine, radius * sine, 0};
  }
  return s;
}

// Maps a point of the unit cube to a point of the element, in voxels.
inline Vector point_of(const Element& element, const Vector& s) {
  const Vector at = place_in(element, s);
  Vector point{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    point[axis] = static_cast<double>(element.origin[axis]) + at[0] * static_cast<double>(element.u[axis]) +
                  at[1] * static_cast<double>(element.v[axis]) + at[2] * static_cast<double>(element.w[axis]);
  }
  return point;
}

struct Bounds {
  double low = 0, high = 0;
};

// Range of s u + t v over a disc, for one coordinate of u and v.
inline Bounds disc_bounds(double u, double v, double hole, double cut) {
  const double inner = std::sqrt(hole);
  const auto [cosine, sine] = cosine_sine(1 - cut);
  Bounds bounds{std::min(u, inner * u), std::max(u, inner * u)};
  const double end = cosine * u + sine * v;
  bounds.low = std::min({bounds.low, end, inner * end});
  bounds.high = std::max({bounds.high, end, inner * end});
  const double most = std::sqrt(u * u + v * v);  // in the direction (u, v) of the unit circle, if on the arc
  const double before_end = u * sine - v * cosine;
  const auto comes_by = [&](double sign) {
    const bool after_begin = sign * v >= 0, left = sign * before_end >= 0;
    return cut == 0 || (cut >= 0.5 ? after_begin && left : after_begin || left);
  };
  if (comes_by(1)) bounds.high = std::max(bounds.high, most);
  if (comes_by(-1)) bounds.low = std::min(bounds.low, -most);
  return bounds;
}

// Range of an element along one axis, from its coordinates on that axis. `hole` and `cut` are w[0] and w[1] of a disc's
// record.
inline Bounds bounds_of(ElementKind kind, double origin, double u, double v, double w, double hole, double cut) {
  switch (kind) {
    case ElementKind::kDisc: {
      const auto [low, high] = disc_bounds(u, v, hole, cut);
      return {origin + low, origin + high};
    }
    case ElementKind::kTriangle:
      return {std::min({origin, origin + u, origin + v}), std::max({origin, origin + u, origin + v})};
    default:
      return {origin + std::min(u, 0.0) + std::min(v, 0.0) + std::min(w, 0.0),
              origin + std::max(u, 0.0) + std::max(v, 0.0) + std::max(w, 0.0)};
  }
}
inline Bounds bounds_of(const Element& element, std::size_t axis) {
  const auto at = [axis](const std::array<float, 3>& vector) { return static_cast<double>(vector[axis]); };
  return bounds_of(element.kind, at(element.origin), at(element.u), at(element.v), at(element.w),
                   static_cast<double>(element.w[0]), static_cast<double>(element.w[1]));
}

// Whether all points of the element are in a volume that ends at `last`, after rounding to positions. An element at a
// face may exceed it by a rounding error.
inline bool lies_within(const Element& element, const Vector& last) {
  constexpr double kRounding = 0.25 / kVoxel;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const auto& vector : {element.origin, element.u, element.v, element.w}) {
      if (!std::isfinite(vector[axis])) return false;
    }
    const auto [low, high] = bounds_of(element, axis);
    if (low < -kRounding || high > last[axis] + kRounding) return false;
  }
  return true;
}

// Unit normal of a flat element in physical space. `spacing`: voxel edges in reference lengths. Zero if the element has
// no area.
inline Vector normal_of(const Element& patch, const Vector& spacing) {
  Vector u{}, v{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    u[axis] = static_cast<double>(patch.u[axis]) * spacing[axis];
    v[axis] = static_cast<double>(patch.v[axis]) * spacing[axis];
  }
  Vector n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (length == 0) return {};
  for (double& x : n) x /= length;
  return n;
}

struct PairSample {
  Vector from{}, to{};  // voxels
  double weight = 0;    // G; 0: no ray is sent
};

// `normals`: normals of the flat elements.
inline PairSample pair_sample(const Element& a, const Element& b, const std::array<Vector, 2>& normals,
                              const Vector& spacing, std::uint32_t id, std::uint32_t seed, std::uint32_t index) {
  const std::array<double, 6> s = pair_point(id, seed, index);
  PairSample sample{point_of(a, {s[0], s[1], s[2]}), point_of(b, {s[3], s[4], s[5]}), 0};
  Vector way{};
  double square = 0, at_a = 0, at_b = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    way[axis] = (sample.to[axis] - sample.from[axis]) * spacing[axis];
    square += way[axis] * way[axis];
    at_a += way[axis] * normals[0][axis];
    at_b -= way[axis] * normals[1][axis];
  }
  if (square == 0) return sample;
  const double r = std::sqrt(square);
  const double f_a = a.kind == ElementKind::kBox ? 1 : at_a / r, f_b = b.kind == ElementKind::kBox ? 1 : at_b / r;
  if (f_a > 0 && f_b > 0) sample.weight = f_a * f_b / (std::numbers::pi * square);
  return sample;
}

// The means of few rays are skewed. With this factor, three standard errors should hold for 99.9%: the limit of
// Student's distribution with 7 degrees of freedom is 5.41.
inline constexpr double kStudent = 1.8;

// Accumulates the samples of one pair, in their order.
class PairSum {
 public:
  explicit PairSum(std::uint32_t samples) : samples_(samples) {}

  // Adds sample `i`, counted from 0.
  void add(std::uint32_t i, double weight, double transmittance) {
    geometric_ += weight;
    const std::size_t run = std::uint64_t{i} * kPairRuns / samples_;
    run_[run] += weight * transmittance;
    ++samples_of_[run];
  }

  PairResult result() const {
    PairResult out;
    double sum = 0;
    for (const double run : run_) sum += run;
    out.transported = sum / samples_;
    out.geometric = static_cast<float>(geometric_ / samples_);
    out.standard_error = std::numeric_limits<float>::infinity();
    if (samples_ < kPairRuns) return out;
    double squares = 0;
    for (std::uint32_t r = 0; r < kPairRuns; ++r) {
      const double off = run_[r] / samples_of_[r] - out.transported;
      squares += off * off;
    }
    out.standard_error = static_cast<float>(kStudent * std::sqrt(squares / (kPairRuns * (kPairRuns - 1))));
    return out;
  }

 private:
  std::uint32_t samples_;
  double geometric_ = 0;
  std::array<double, kPairRuns> run_{};
  std::array<std::uint32_t, kPairRuns> samples_of_{};
};

// The ray packet of a segment between two points of the volume, rounded like the board's values.
inline Ray segment_packet(const Vector& from, const Vector& to, std::uint32_t id) {
  Ray ray;
  ray.set_host_id(id);
  ray.flags = kHostRay;
  double square = 0;
  Vector way{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    way[axis] = to[axis] - from[axis];
    square += way[axis] * way[axis];
  }
  const double length = std::sqrt(square), scale = 1 / length;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.position[axis] = to_nearest(from[axis] * kVoxel);
    const double d = (length > 0 ? scale * way[axis] : axis == 2 ? 1.0 : 0.0) * (1 << kDirectionFractionBits);
    const auto size = static_cast<std::int16_t>(to_nearest(d < 0 ? -d : d));
    ray.direction[axis] = static_cast<std::int16_t>(d < 0 ? -size : size);
  }
  ray.set_colour_word(to_nearest(length * 65536));
  return ray;
}

}  // namespace gicube::wire
