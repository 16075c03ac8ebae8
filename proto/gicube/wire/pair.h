// Pairs of elements between which the DSP makes rays: the heaviest part of a form factor [P §5.6], with one number a pair on
// the bus instead of two ray packets a ray.
//
// An element is a flat patch or a box of the volume:
//
//   byte  size  field
//      0     4  kind             0 patch: origin + s u + t v, with its front to the side of u x v; 1 box: + r w
//      4     4  reserved, 0
//      8  3x12  origin, u, v     three floats each, voxels
//     44    12  w                three floats; of a patch 0
//
// A pair, 12 bytes: u32 element a, u32 element b, u32 id, which picks its points.
//
// Sample i of a pair has a point on each element, from the first six dimensions of a Kronecker sequence, turned by a hash of
// (id, seed): points that fill the elements evenly for any number of them, and independently of other pairs. Its weight is
//
//   G = f_a f_b / (pi r^2),  f = the cosine at a patch, 0 behind it; 1 in a box
//
// with r physical, in reference voxel edges, and a ray between the two points finds the transmittance T.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

#include "gicube/wire/bytes.h"
#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"

namespace gicube::wire {

inline constexpr std::size_t kElementBytes = 56;
inline constexpr std::size_t kPairBytes = 12;
inline constexpr std::size_t kPairsHeaderBytes = 32;
inline constexpr std::size_t kPairResultBytes = 16;
inline constexpr std::uint32_t kMaxRaysPerPair = 65'536;
inline constexpr std::uint32_t kMaxPairRays = 1u << 22;  // of one command; chosen: a second of the DSP's work

using Vector = std::array<double, 3>;

enum class ElementKind : std::uint32_t { kPatch = 0, kBox = 1 };

struct Element {
  ElementKind kind = ElementKind::kPatch;
  std::array<float, 3> origin{}, u{}, v{}, w{};

  friend constexpr bool operator==(const Element&, const Element&) = default;
};

inline void encode(const Element& element, std::span<std::uint8_t, kElementBytes> out) {
  store(out, 0, static_cast<std::uint32_t>(element.kind));
  store(out, 4, std::uint32_t{0});
  std::size_t at = 8;
  for (const auto* vector : {&element.origin, &element.u, &element.v, &element.w}) {
    for (const float x : *vector) {
      store(out, at, std::bit_cast<std::uint32_t>(x));
      at += 4;
    }
  }
}

inline Element decode_element(std::span<const std::uint8_t, kElementBytes> in) {
  Element element;
  element.kind = static_cast<ElementKind>(load<std::uint32_t>(in, 0));
  std::size_t at = 8;
  for (auto* vector : {&element.origin, &element.u, &element.v, &element.w}) {
    for (float& x : *vector) {
      x = std::bit_cast<float>(load<std::uint32_t>(in, at));
      at += 4;
    }
  }
  return element;
}

struct PairsHeader {
  std::uint32_t elements = 0;
  std::uint32_t pairs = 0;
  std::uint32_t rays = 0;   // a pair
  std::uint32_t first = 0;  // the first of its samples
  std::uint32_t seed = 0;
  std::uint32_t opacity = kOpacityOne;  // 24 bits, not 0: at which a ray ends

  friend constexpr bool operator==(const PairsHeader&, const PairsHeader&) = default;
};

inline void encode(const PairsHeader& header, std::span<std::uint8_t, kPairsHeaderBytes> out) {
  const std::array words{static_cast<std::uint32_t>(Opcode::kPairs),
                         header.elements,
                         header.pairs,
                         header.rays,
                         header.first,
                         header.seed,
                         header.opacity,
                         0u};
  for (std::size_t i = 0; i < words.size(); ++i) store(out, 4 * i, words[i]);
}

inline PairsHeader decode_pairs(std::span<const std::uint8_t, kPairsHeaderBytes> in) {
  const auto word = [in](std::size_t i) { return load<std::uint32_t>(in, 4 * i); };
  return {word(1), word(2), word(3), word(4), word(5), word(6)};
}

struct Pair {
  std::uint32_t a = 0, b = 0;
  std::uint32_t id = 0;

  friend constexpr bool operator==(const Pair&, const Pair&) = default;
};

// What comes back of a pair.
struct PairResult {
  double transported = 0;    // mean of G T
  float geometric = 0;       // mean of G
  float standard_error = 0;  // of `transported`: from the means of eight runs of its samples; infinite for fewer than 8

  friend constexpr bool operator==(const PairResult&, const PairResult&) = default;
};

inline void encode(const Pair& pair, std::span<std::uint8_t, kPairBytes> out) {
  store(out, 0, pair.a);
  store(out, 4, pair.b);
  store(out, 8, pair.id);
}

inline Pair decode_pair(std::span<const std::uint8_t, kPairBytes> in) {
  return {load<std::uint32_t>(in, 0), load<std::uint32_t>(in, 4), load<std::uint32_t>(in, 8)};
}

inline void encode(const PairResult& result, std::span<std::uint8_t, kPairResultBytes> out) {
  store_double(out, 0, result.transported);
  store(out, 8, std::bit_cast<std::uint32_t>(result.geometric));
  store(out, 12, std::bit_cast<std::uint32_t>(result.standard_error));
}

inline PairResult decode_pair_result(std::span<const std::uint8_t, kPairResultBytes> in) {
  return {load_double(in, 0), std::bit_cast<float>(load<std::uint32_t>(in, 8)),
          std::bit_cast<float>(load<std::uint32_t>(in, 12))};
}

// What both sides work out alike, in IEEE operations alone: the same bits on every machine.

// Coordinate `dimension` of point `index`: fractions of the powers of 1/phi, phi^7 = phi + 1 (the generalised golden ratio
// of six dimensions), in 64-bit fixed point.
constexpr double pair_coordinate(std::uint32_t id, std::uint32_t seed, std::uint32_t index, std::uint32_t dimension) {
  constexpr std::array<std::uint64_t, 6> kSteps{0xe60e2b722b53aeec, 0xcebd76d9edb6a8ef, 0xb9c9aa3a51d00b65,
                                                0xa6f5777f6f889840, 0x9609c71eb7d03f7a, 0x86d516e50b04ab1b};
  const auto mix = [](std::uint64_t x) {  // SplitMix64 (Steele, Lea, Flood 2014)
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
    x = (x ^ x >> 27) * 0x94D049BB133111EBu;
    return x ^ x >> 31;
  };
  const std::uint64_t turn = mix(mix(id | std::uint64_t{seed} << 32) ^ dimension);
  return static_cast<double>((turn + (index + std::uint64_t{1}) * kSteps[dimension]) >> 11) * 0x1p-53;
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

// The samples of one pair, added up in their order.
class PairSum {
 public:
  explicit PairSum(std::uint32_t samples) : samples_(samples) {}

  // Of sample `i`, counted from 0.
  void add(std::uint32_t i, double weight, double transmittance) {
    geometric_ += weight;
    run_[std::uint64_t{i} * kRuns / samples_] += weight * transmittance;
  }

  PairResult result() const {
    PairResult out;
    double sum = 0;
    for (const double run : run_) sum += run;
    out.transported = sum / samples_;
    out.geometric = static_cast<float>(geometric_ / samples_);
    out.standard_error = std::numeric_limits<float>::infinity();
    if (samples_ < kRuns) return out;
    double squares = 0;
    for (std::uint64_t r = 0; r < kRuns; ++r) {
      const std::uint64_t begin = (r * samples_ + kRuns - 1) / kRuns, end = ((r + 1) * samples_ + kRuns - 1) / kRuns;
      const double off = run_[r] / static_cast<double>(end - begin) - out.transported;
      squares += off * off;
    }
    out.standard_error = static_cast<float>(std::sqrt(squares / (kRuns * (kRuns - 1))));
    return out;
  }

 private:
  static constexpr std::uint64_t kRuns = 8;  // chosen: whose means tell the standard error

  std::uint32_t samples_;
  double geometric_ = 0;
  std::array<double, kRuns> run_{};
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
