// Pairs of elements between which the DSP makes rays: the heaviest part of a form factor [P §5.6], with one number per pair on
// the bus instead of two ray packets a ray. README.md has the bytes.
//
// The samples of a pair are dealt out to eight runs. Each run is a Kronecker sequence in six dimensions, turned by a hash of (id,
// seed, run): its points fill both elements evenly for any number of them, and independently of other runs and pairs. So the scatter of
// the runs' means tells the error. Along one sequence it would not: a part of the error can be the same in all pieces of it. The
// weight of a sample is
//
//   G = f_a f_b / (pi r^2),  f = the cosine at a patch, 0 behind it; 1 in a box
//
// with r physical, in reference voxel edges, and a ray between the two points finds the transmittance T.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/record.h"

namespace gicube::wire {

inline constexpr std::uint32_t kMaxRaysPerPair = 65'536;
inline constexpr std::uint32_t kMaxPairRays = 1u << 22;  // of one command; chosen: a second of the DSP's work

using Vector = std::array<double, 3>;

enum class ElementKind : std::uint32_t { kPatch = 0, kBox = 1 };

// A flat patch origin + s u + t v, its front to the side of u x v; or a box of the volume, + r w. Voxels; a patch has no w.
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
  std::uint32_t rays = 0;   // a pair
  std::uint32_t first = 0;  // the first of its samples
  std::uint32_t seed = 0;
  std::uint32_t opacity = kOpacityOne;  // 24 bits, not 0: at which a ray ends

  constexpr void fields(auto&& list) {
    list(Opcode::kPairs, elements, pairs, rays, first, seed, opacity, Reserved<4>{});
  }
  friend constexpr bool operator==(const PairsHeader&, const PairsHeader&) = default;
};
inline constexpr std::size_t kPairsHeaderBytes = bytes_of<PairsHeader>();

struct Pair {
  std::uint32_t a = 0, b = 0;  // elements
  std::uint32_t id = 0;        // picks its points

  constexpr void fields(auto&& list) { list(a, b, id); }
  friend constexpr bool operator==(const Pair&, const Pair&) = default;
};
inline constexpr std::size_t kPairBytes = bytes_of<Pair>();

// What comes back of a pair.
struct PairResult {
  double transported = 0;    // mean of G T
  float geometric = 0;       // mean of G
  float standard_error = 0;  // of `transported`, from the means of its runs; infinite for fewer than 8 samples

  constexpr void fields(auto&& list) { list(transported, geometric, standard_error); }
  friend constexpr bool operator==(const PairResult&, const PairResult&) = default;
};
inline constexpr std::size_t kPairResultBytes = bytes_of<PairResult>();

// What both sides work out alike, in IEEE operations alone: the same bits on every machine.

// SplitMix64 (Steele, Lea, Flood 2014).
constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
  x = (x ^ x >> 27) * 0x94D049BB133111EBu;
  return x ^ x >> 31;
}

// Chosen: more of them tell the error better, and fill the elements less evenly.
inline constexpr std::uint32_t kPairRuns = 8;

// Coordinate `dimension` of sample `index`: fractions of the powers of 1/phi, phi^7 = phi + 1 (the generalised golden ratio
// of six dimensions), in 64-bit fixed point.
constexpr double pair_coordinate(std::uint32_t id, std::uint32_t seed, std::uint32_t index, std::uint32_t dimension) {
  constexpr std::array<std::uint64_t, 6> kSteps{0xe60e2b722b53aeec, 0xcebd76d9edb6a8ef, 0xb9c9aa3a51d00b65,
                                                0xa6f5777f6f889840, 0x9609c71eb7d03f7a, 0x86d516e50b04ab1b};
  const std::uint32_t run = index % kPairRuns;
  const std::uint64_t turn = mix(mix(id | std::uint64_t{seed} << 32) ^ (dimension | run << 3));
  return static_cast<double>((turn + index / kPairRuns * kSteps[dimension]) >> 11) * 0x1p-53;
}

inline Vector point_of(const Element& element, const Vector& s) {
  Vector point{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    point[axis] = static_cast<double>(element.origin[axis]) + s[0] * static_cast<double>(element.u[axis]) +
                  s[1] * static_cast<double>(element.v[axis]) + s[2] * static_cast<double>(element.w[axis]);
  }
  return point;
}

// Of a patch, physical; `spacing`: voxel edges in reference lengths. Zero if it has no area.
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

// `normals`: of the elements that are patches.
inline PairSample pair_sample(const Element& a, const Element& b, const std::array<Vector, 2>& normals,
                              const Vector& spacing, std::uint32_t id, std::uint32_t seed, std::uint32_t index) {
  std::array<double, 6> s{};
  for (std::uint32_t d = 0; d < 6; ++d) s[d] = pair_coordinate(id, seed, index, d);
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
  const double f_a = a.kind == ElementKind::kPatch ? at_a / r : 1, f_b = b.kind == ElementKind::kPatch ? at_b / r : 1;
  if (f_a > 0 && f_b > 0) sample.weight = f_a * f_b / (std::numbers::pi * square);
  return sample;
}

// Means of few rays are skewed, so three standard errors are to hold for 99.9%: Student's of 7 degrees of freedom has them within 5.41.
inline constexpr double kStudent = 1.8;

// The samples of one pair, added up in their order.
class PairSum {
 public:
  explicit PairSum(std::uint32_t samples) : samples_(samples) {}

  // Of sample `i`, counted from 0.
  void add(std::uint32_t i, double weight, double transmittance) {
    geometric_ += weight;
    run_[i % kPairRuns] += weight * transmittance;
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
      const std::uint32_t of_run = (samples_ + kPairRuns - 1 - r) / kPairRuns;
      const double off = run_[r] / of_run - out.transported;
      squares += off * off;
    }
    out.standard_error = static_cast<float>(kStudent * std::sqrt(squares / (kPairRuns * (kPairRuns - 1))));
    return out;
  }

 private:
  std::uint32_t samples_;
  double geometric_ = 0;
  std::array<double, kPairRuns> run_{};
};

// The ray packet of a segment between two points of the volume, rounded as the board holds it.
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
