#include "encode/pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "encode/argument.h"
#include "encode/host_ray.h"
#include "encode/vectors.h"
#include "encode/volume/samples.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/registers.h"

namespace gicube {
namespace {

std::array<float, 3> floats(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

struct Bounds {
  wire::Vector low{}, high{};
};

Bounds bounds_of(const wire::Element& element) {
  Bounds bounds;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [low, high] = wire::bounds_of(element, axis);
    bounds.low[axis] = low, bounds.high[axis] = high;
  }
  return bounds;
}

// An upper bound, in voxels on one axis, of a sample's distance from the straight line between the two points: the
// position, each component of the direction and each step are rounded to 1/16384 voxel, a step's length to 1/65536, and
// half of the first step separately.
double stray(const Bounds& a, const Bounds& b, double step) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double way = std::max(b.high[axis] - a.low[axis], a.high[axis] - b.low[axis]);
    square += way * way;
  }
  const double length = std::sqrt(square);
  return (4 + length + 2 * std::ceil(length / step)) / wire::kVoxel;
}

// An interval of the way from a to b, 0..1; empty if begin > end.
struct Part {
  double begin = 0, end = 1;
};

// The subset of the part in which a number that changes linearly from `at_a` to `at_b` is at most `limit`.
Part where_below(Part part, double at_a, double at_b, double limit) {
  const double slope = at_b - at_a;
  if (slope == 0) return at_a <= limit ? part : Part{1, 0};
  const double crossing = (limit - at_a) / slope;
  return slope > 0 ? Part{part.begin, std::min(part.end, crossing)} : Part{std::max(part.begin, crossing), part.end};
}

// The blocks of one axis that an interval of voxels touches.
struct Range {
  int begin = 0, end = 0;  // the last one
};

Range blocks_between(double low, double high, int block_voxels, int blocks) {
  return {std::clamp(static_cast<int>(std::floor(low / block_voxels)), 0, blocks - 1),
          std::clamp(static_cast<int>(std::floor(high / block_voxels)), 0, blocks - 1)};
}

bool all_empty(const std::array<Range, 3>& range, const BlockFlags& flags) {
  for (int z = range[2].begin; z <= range[2].end; ++z) {
    for (int y = range[1].begin; y <= range[1].end; ++y) {
      for (int x = range[0].begin; x <= range[0].end; ++x) {
        if (flags.empty[index_of(flags.blocks, x, y, z)] == 0) return false;
      }
    }
  }
  return true;
}

// The axis along which the elements are furthest apart: the hull has the smallest sections across it.
std::size_t main_axis(const Bounds& a, const Bounds& b) {
  std::size_t best = 0;
  double furthest = -1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double apart = std::abs(b.low[axis] + b.high[axis] - a.low[axis] - a.high[axis]);
    if (apart > furthest) best = axis, furthest = apart;
  }
  return best;
}

}  // namespace

void check(const PairRequest& request) {
  expect_within("request.rays", request.rays, 1, wire::kMaxRaysPerPair);
  expect_within("request.first", request.first, 0, 4294967295.0 - request.rays);
  if (!(request.opacity > 0 && request.opacity <= 1)) {
    throw BadArgument("request.opacity", "more than 0, at most 1", number_text(request.opacity));
  }
  expect_within("request.step", request.step, wire::kStepMin / double{wire::kStepOne},
                wire::kStepMax / double{wire::kStepOne});
}

void check(const Element& element, std::size_t index, Dims dims) {
  const std::string name = fmt::format("elements[{}]", index);
  if (element.kind == ElementKind::kDisc) {
    for (const double share : {element.w.x, element.w.y}) {
      if (share >= 0 && share < 1) continue;
      throw BadArgument(name + ".w", "a disc's shares of 0 or more and below 1", number_text(share));
    }
  }
  const wire::Element rounded = to_wire(element);
  if (wire::lies_within(rounded, {dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0})) return;
  const auto [low, high] = bounds_of(rounded);
  throw BadArgument(
      name, "an element in the volume",
      fmt::format("one from ({}, {}, {}) to ({}, {}, {})", low[0], low[1], low[2], high[0], high[1], high[2]));
}

void check(const ElementPair& pair, std::size_t index, std::size_t elements) {
  for (const std::uint32_t of : {pair.a, pair.b}) {
    if (of < elements) continue;
    throw BadArgument(fmt::format("pairs[{}]", index), fmt::format("elements below {}", elements), std::to_string(of));
  }
}

wire::Element to_wire(const Element& element) {
  const bool has_w = element.kind == ElementKind::kBox || element.kind == ElementKind::kDisc;
  return {static_cast<wire::ElementKind>(element.kind), floats(element.origin), floats(element.u), floats(element.v),
          has_w ? floats(element.w) : std::array<float, 3>{}};
}

std::vector<std::uint8_t> pairs_command(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                        const PairRequest& request) {
  std::unordered_map<std::uint32_t, std::uint32_t> place;
  std::vector<std::uint32_t> named;
  const auto local = [&](std::uint32_t element) {
    const auto [at, fresh] = place.emplace(element, static_cast<std::uint32_t>(named.size()));
    if (fresh) named.push_back(element);
    return at->second;
  };
  std::vector<wire::Pair> renamed;
  for (const ElementPair& pair : pairs) {
    const std::uint32_t a = local(pair.a), b = local(pair.b);
    renamed.push_back({a, b, pair.id});
  }
  const wire::PairsHeader header{.elements = static_cast<std::uint32_t>(named.size()),
                                 .pairs = static_cast<std::uint32_t>(pairs.size()),
                                 .rays = request.rays,
                                 .first = request.first,
                                 .seed = request.seed,
                                 .opacity = opacity_word(request.opacity)};
  std::vector<std::uint8_t> bytes = wire::encoded(header);
  for (const std::uint32_t element : named) wire::append(bytes, to_wire(elements[element]));
  for (const wire::Pair& pair : renamed) wire::append(bytes, pair);
  return bytes;
}

PairFactor from_wire(const wire::PairResult& result) {
  return {result.transported, static_cast<double>(result.geometric), static_cast<double>(result.standard_error), false};
}

PairRaysMade make_rays(std::span<const Element> elements, std::span<const ElementPair> pairs,
                       const PairRequest& request, Vec3 spacing, Dims dims) {
  const auto in_volume = [](double at, int size) { return std::clamp(at, 0.0, size - 1.0); };
  const wire::Vector edges{spacing.x, spacing.y, spacing.z};
  PairRaysMade made;
  for (const ElementPair& pair : pairs) {
    const wire::Element a = to_wire(elements[pair.a]), b = to_wire(elements[pair.b]);
    const std::array normals{wire::normal_of(a, edges), wire::normal_of(b, edges)};
    for (std::uint32_t i = 0; i < request.rays; ++i) {
      const auto sample = wire::pair_sample(a, b, normals, edges, pair.id, request.seed, request.first + i);
      made.weights.push_back(sample.weight);
      if (!(sample.weight > 0)) continue;
      HostRay ray = ray_between(pair.id, to_vec3(sample.from), to_vec3(sample.to));
      ray.position = {in_volume(ray.position.x, dims[0]), in_volume(ray.position.y, dims[1]),
                      in_volume(ray.position.z, dims[2])};  // as the board clamps it
      made.rays.push_back(ray);
    }
  }
  return made;
}

std::vector<PairFactor> sum_up(std::span<const double> weights, std::span<const TracedRay> rays,
                               std::uint32_t samples) {
  std::vector<PairFactor> factors;
  std::size_t ray = 0;
  for (std::size_t at = 0; at < weights.size(); at += samples) {
    wire::PairSum sum(samples);
    for (std::uint32_t i = 0; i < samples; ++i) {
      const double weight = weights[at + i];
      sum.add(i, weight, weight > 0 ? 1 - rays[ray++].opacity : 1);
    }
    factors.push_back(from_wire(sum.result()));
  }
  return factors;
}

// At the fraction t of the way all rays are within the bounds (1 - t) a + t b, which change linearly.
bool is_clear(const wire::Element& from, const wire::Element& to, const BlockFlags& flags, double step) {
  Bounds a = bounds_of(from), b = bounds_of(to);
  const double margin = stray(a, b, step);
  for (Bounds* bounds : {&a, &b}) {
    for (std::size_t axis = 0; axis < 3; ++axis) bounds->low[axis] -= margin, bounds->high[axis] += margin;
  }
  const int n = flags.block_voxels;
  const std::size_t main = main_axis(a, b);
  std::array<Range, 3> range{};
  const Range layers =
      blocks_between(std::min(a.low[main], b.low[main]), std::max(a.high[main], b.high[main]), n, flags.blocks[main]);
  for (int layer = layers.begin; layer <= layers.end; ++layer) {
    Part part;
    part = where_below(part, a.low[main], b.low[main], n * (layer + 1.0));
    part = where_below(part, -a.high[main], -b.high[main], -n * static_cast<double>(layer));
    part.begin = std::max(0.0, part.begin), part.end = std::min(1.0, part.end);
    if (part.begin > part.end) continue;
    range[main] = {layer, layer};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == main) continue;
      const double low =
          std::min(std::lerp(a.low[axis], b.low[axis], part.begin), std::lerp(a.low[axis], b.low[axis], part.end));
      const double high =
          std::max(std::lerp(a.high[axis], b.high[axis], part.begin), std::lerp(a.high[axis], b.high[axis], part.end));
      range[axis] = blocks_between(low, high, n, flags.blocks[axis]);
    }
    if (!all_empty(range, flags)) return false;
  }
  return true;
}

PairFactor clear_factor(const wire::Element& a, const wire::Element& b, std::uint32_t id, const PairRequest& request,
                        Vec3 spacing) {
  const wire::Vector edges{spacing.x, spacing.y, spacing.z};
  const std::array normals{wire::normal_of(a, edges), wire::normal_of(b, edges)};
  wire::PairSum sum(request.rays);
  for (std::uint32_t i = 0; i < request.rays; ++i) {
    sum.add(i, wire::pair_sample(a, b, normals, edges, id, request.seed, request.first + i).weight, 1);
  }
  PairFactor factor = from_wire(sum.result());
  factor.clear = true;
  return factor;
}

}  // namespace gicube
