#include "encode/pairs.h"

#include <fmt/format.h>

#include <cmath>
#include <unordered_map>

#include "encode/argument.h"
#include "encode/host_ray.h"

namespace gicube {
namespace {

std::array<float, 3> floats(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

Vec3 to_vec3(const wire::Vector& v) { return {v[0], v[1], v[2]}; }

}  // namespace

void check(const PairRequest& request) {
  expect_within("request.rays", request.rays, 1, wire::kMaxRaysPerPair);
  expect_within("request.first", request.first, 0, 4294967295.0 - request.rays);
  if (!(request.opacity > 0 && request.opacity <= 1)) {
    throw BadArgument("request.opacity", "more than 0, at most 1", number_text(request.opacity));
  }
}

void check(const Element& element, std::size_t index, Dims dims) {
  const wire::Element rounded = to_wire(element);
  for (int corner = 0; corner < 8; ++corner) {
    const wire::Vector at =
        wire::point_of(rounded, {corner & 1 ? 1.0 : 0.0, corner & 2 ? 1.0 : 0.0, corner & 4 ? 1.0 : 0.0});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (at[axis] >= 0 && at[axis] <= dims[axis] - 1) continue;
      throw BadArgument(fmt::format("elements[{}]", index), "its corners in the volume",
                        fmt::format("one at ({}, {}, {})", at[0], at[1], at[2]));
    }
  }
}

void check(const ElementPair& pair, std::size_t index, std::size_t elements) {
  for (const std::uint32_t of : {pair.a, pair.b}) {
    if (of < elements) continue;
    throw BadArgument(fmt::format("pairs[{}]", index), fmt::format("elements below {}", elements), std::to_string(of));
  }
}

wire::Element to_wire(const Element& element) {
  const bool box = element.kind == ElementKind::kBox;
  return {box ? wire::ElementKind::kBox : wire::ElementKind::kPatch, floats(element.origin), floats(element.u),
          floats(element.v), box ? floats(element.w) : std::array<float, 3>{}};
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
                       const PairRequest& request, Vec3 spacing) {
  const wire::Vector edges{spacing.x, spacing.y, spacing.z};
  PairRaysMade made;
  for (const ElementPair& pair : pairs) {
    const wire::Element a = to_wire(elements[pair.a]), b = to_wire(elements[pair.b]);
    const std::array normals{wire::normal_of(a, edges), wire::normal_of(b, edges)};
    for (std::uint32_t i = 0; i < request.rays; ++i) {
      const auto sample = wire::pair_sample(a, b, normals, edges, pair.id, request.seed, request.first + i);
      made.weights.push_back(sample.weight);
      if (sample.weight > 0) made.rays.push_back(ray_between(pair.id, to_vec3(sample.from), to_vec3(sample.to)));
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

}  // namespace gicube
