#include "encode/near_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace gicube {
namespace {

constexpr double kNear = 0.5;            // chosen: gap in longest sides; at more, eight runs know the scatter
constexpr std::uint32_t kFewRays = 4;    // of a part, up to kFewParts parts; chosen
constexpr std::uint32_t kManyRays = 16;  // of a part beyond; chosen: a part takes the host as long as some ten rays
constexpr std::uint32_t kFewParts = 32, kMaxParts = 1024;
constexpr double kUnseen = 4;  // pseudo-rays, two of which arrive (Agresti and Coull 1998)

Vec3 in_space(Vec3 v, Vec3 spacing) { return {v.x * spacing.x, v.y * spacing.y, v.z * spacing.z}; }

Element physical(const Element& element, Vec3 spacing) {
  const Vec3 w = element.kind == ElementKind::kBox ? element.w : Vec3{};
  return {element.kind, in_space(element.origin, spacing), in_space(element.u, spacing), in_space(element.v, spacing),
          in_space(w, spacing)};
}

using Side = Vec3 Element::*;

Side longest_side(const Element& element) {
  Side longest = &Element::u;
  for (const Side side : {&Element::v, &Element::w}) {
    if (length(element.*side) > length(element.*longest)) longest = side;
  }
  return longest;
}

double gap_along(double Vec3::*axis, const Element& a, const Element& b) {
  const auto ends = [axis](const Element& element) {
    std::array<double, 2> end{element.origin.*axis, element.origin.*axis};
    for (const Side side : {&Element::u, &Element::v, &Element::w}) {
      const double step = (element.*side).*axis;
      end[step > 0 ? 1 : 0] += step;
    }
    return end;
  };
  const auto of_a = ends(a), of_b = ends(b);
  return std::max({of_a[0] - of_b[1], of_b[0] - of_a[1], 0.0});
}

// How much a part is to be divided for: its light, and more for light that is not known well.
double weight_of(const PairPart& part) { return part.measure * (part.factor.mean + 4 * part.factor.error); }

double share_of(const PairFactor& found) {
  return found.geometric > 0 ? std::min(found.transported / found.geometric, 1.0) : 0;
}

}  // namespace

NearPairs::NearPairs(Vec3 spacing, std::uint32_t rays)
    : spacing_(spacing),
      parts_(std::clamp(rays / kManyRays, std::clamp(rays / kFewRays, 1u, kFewParts), kMaxParts)),
      rays_per_part_(rays / static_cast<std::uint32_t>(parts_)) {}

bool NearPairs::is_near(const Element& from, const Element& to) const {
  const Element a = physical(from, spacing_), b = physical(to, spacing_);
  const Vec3 gap{gap_along(&Vec3::x, a, b), gap_along(&Vec3::y, a, b), gap_along(&Vec3::z, a, b)};
  return length(gap) < kNear * std::max(length(a.*longest_side(a)), length(b.*longest_side(b)));
}

const Division* NearPairs::division_of(const Element& a, const Element& b) {
  if (!is_near(a, b) || measure_of(a) * measure_of(b) == 0) return nullptr;
  const Vec3 apart = b.origin - a.origin;
  std::vector<double> key{a.kind == ElementKind::kBox ? 1.0 : 0, b.kind == ElementKind::kBox ? 1.0 : 0};
  for (const Vec3& v : {apart, a.u, a.v, a.w, b.u, b.v, b.w}) key.insert(key.end(), {v.x, v.y, v.z});
  const auto [at, fresh] = known_.try_emplace(std::move(key));
  if (fresh) {
    Element first = a, second = b;
    first.origin = {}, second.origin = apart;
    at->second = divide(first, second);
  }
  return &at->second;
}

// Always the part with the greatest weight, across the longest side of both its elements.
Division NearPairs::divide(const Element& a, const Element& b) const {
  Division division{{a, b}, {}};
  auto& [elements, parts] = division;
  const auto add = [&](std::uint32_t of_a, std::uint32_t of_b, double measure) {
    const Element &x = elements[of_a], &y = elements[of_b];
    const bool near = is_near(x, y);
    parts.push_back({of_a, of_b, measure, geometric_factor(physical(x, spacing_), physical(y, spacing_), near), near});
  };
  const auto less = [](const PairPart& x, const PairPart& y) { return weight_of(x) < weight_of(y); };
  std::map<std::uint32_t, std::uint32_t> halves;  // of elements that were divided before: the first; the second follows
  add(0, 1, 1);
  while (parts.size() < parts_) {
    std::pop_heap(parts.begin(), parts.end(), less);
    const PairPart whole = parts.back();
    parts.pop_back();
    const Element shape_a = physical(elements[whole.a], spacing_), shape_b = physical(elements[whole.b], spacing_);
    const Side side_a = longest_side(shape_a), side_b = longest_side(shape_b);
    const bool first = length(shape_a.*side_a) >= length(shape_b.*side_b);
    const Side side = first ? side_a : side_b;
    const auto [half, fresh] =
        halves.try_emplace(first ? whole.a : whole.b, static_cast<std::uint32_t>(elements.size()));
    for (std::uint32_t i = 0; i < 2; ++i) {
      if (fresh) {
        Element part = elements[half->first];
        part.*side = 0.5 * part.*side;
        part.origin = part.origin + static_cast<double>(i) * part.*side;
        elements.push_back(part);
      }
      first ? add(half->second + i, whole.b, 0.5 * whole.measure) : add(whole.a, half->second + i, 0.5 * whole.measure);
      std::push_heap(parts.begin(), parts.end(), less);
    }
  }
  return division;
}

// What arrives is taken as of yes and no: no transmittance varies more. Within a part that is still near few of its rays are near
// where most of its light is; so they count as an eighth, and their error as one that all such parts have in common.
PairFactor NearPairs::sum_up(const Division& division, std::span<const PairFactor> found) const {
  PairFactor sum{.clear = true};
  double squares = 0, common = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const PairPart& part = division.parts[i];
    const double light = part.measure * part.factor.mean, share = share_of(found[i]), rays = rays_per_part_;
    sum.geometric += light;
    sum.transported += light * share;
    sum.clear = sum.clear && found[i].clear;
    common += part.measure * part.factor.error;
    if (found[i].geometric == 0) common += light;
    if (found[i].clear) continue;
    squares += light * light / (part.near ? std::max(1.0, rays / 8) : rays);
    if (part.near) common += light * std::sqrt(share * (1 - share) / rays);
  }
  double noise = 0;
  if (squares > 0) {
    const double even = sum.geometric * sum.geometric / squares;  // rays that each carry as much light
    const double share = sum.transported / sum.geometric;
    const double likely = (even * share + kUnseen / 2) / (even + kUnseen);
    noise = sum.geometric * (std::sqrt(likely * (1 - likely) / (even + kUnseen)) + std::abs(likely - share) / 3);
  }
  sum.standard_error = noise + common;
  return sum;
}

double error_with_unseen(const PairFactor& found, std::uint32_t rays) {
  if (found.clear) return found.standard_error;
  const double unseen = std::numbers::sqrt2 / (rays + kUnseen);  // deviation of the share, if all rays found the same
  return std::hypot(found.standard_error, unseen * (found.transported > 0 ? found.transported : found.geometric));
}

}  // namespace gicube
