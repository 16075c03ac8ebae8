#include "encode/near_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "encode/vectors.h"
#include "gicube/wire/pair.h"

namespace gicube {
namespace {

constexpr double kNear = 0.5;            // chosen: gap, in longest sides; beyond, eight runs show the scatter
constexpr std::uint32_t kFewRays = 4;    // chosen: per part, up to kFewParts parts
constexpr std::uint32_t kManyRays = 16;  // chosen: per part beyond; each costs the host some ten rays
constexpr std::uint32_t kFewParts = 32, kMaxParts = 1024;
constexpr double kUnseen = 4;  // pseudo-rays, two of which arrive (Agresti and Coull 1998)

Element physical(const Element& element, Vec3 spacing) {
  const bool box = element.kind == ElementKind::kBox, disc = element.kind == ElementKind::kDisc;
  return {element.kind, times(element.origin, spacing), times(element.u, spacing), times(element.v, spacing),
          box    ? times(element.w, spacing)
          : disc ? element.w
                 : Vec3{}};
}

// How an element is halved: across u, v, w or the edge between the ends of u and v; a disc at a radius or at an angle.
enum class Way { kU, kV, kW, kEdge, kRadius, kAngle };
struct Length {
  Way way;
  double length;
};

// The longest side of an element in physical coordinates. A disc's sides: from its hole to its rim, and the arc halfway
// between them.
Length longest(const Element& element) {
  std::array<Length, 3> all{{{Way::kU, length(element.u)}, {Way::kV, length(element.v)}, {Way::kW, length(element.w)}}};
  if (element.kind == ElementKind::kTriangle) all[2] = {Way::kEdge, length(element.v - element.u)};
  if (element.kind == ElementKind::kDisc) {
    const double radius = std::max(all[0].length, all[1].length), inner = std::sqrt(element.w.x);
    all[0] = {Way::kAngle, std::numbers::pi * radius * (1 + inner) * (1 - element.w.y)};
    all[1] = {Way::kRadius, radius * (1 - inner)};
    all[2].length = 0;
  }
  return *std::ranges::max_element(all, {}, &Length::length);
}

// Two halves of equal area or volume.
std::array<Element, 2> halves(const Element& whole, Way way) {
  Element first = whole, second = whole;
  const bool triangle = whole.kind == ElementKind::kTriangle;
  switch (way) {
    case Way::kU:
      first.u = second.u = 0.5 * whole.u;
      second.origin = whole.origin + second.u;
      if (triangle) second.v = whole.v - second.u;
      break;
    case Way::kV:
      first.v = second.v = 0.5 * whole.v;
      second.origin = whole.origin + second.v;
      if (triangle) second.u = whole.u - second.v;
      break;
    case Way::kW:
      first.w = second.w = 0.5 * whole.w;
      second.origin = whole.origin + second.w;
      break;
    case Way::kEdge: first.v = second.u = 0.5 * (whole.u + whole.v); break;
    case Way::kRadius: {
      const double middle = 0.5 * (1 + whole.w.x), radius = std::sqrt(middle);
      first.u = radius * whole.u, first.v = radius * whole.v, first.w.x = whole.w.x / middle;
      second.w.x = middle;
      break;
    }
    case Way::kAngle: {
      const double turn = 0.5 * (1 - whole.w.y);
      const auto [cosine, sine] = wire::cosine_sine(turn);
      second.u = cosine * whole.u + sine * whole.v;
      second.v = cosine * whole.v - sine * whole.u;
      first.w.y = second.w.y = 1 - turn;
      break;
    }
  }
  return {first, second};
}

// Nothing unless both elements are boxes along the axes.
std::optional<NearPairs::Placement> placement_of(const Element& a, const Element& b) {
  NearPairs::Placement placement{};
  for (const Element* box : {&a, &b}) {
    if (box->kind != ElementKind::kBox) return {};
    int components = 0;
    for (const Vec3& side : {box->u, box->v, box->w}) components += (side.x != 0) + (side.y != 0) + (side.z != 0);
    if (components != 3) return {};  // one side is oblique
  }
  const auto side = [](const Element& box, double Vec3::*axis) { return box.u.*axis + box.v.*axis + box.w.*axis; };
  std::size_t i = 0;
  for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    const double of_a = side(a, axis), of_b = side(b, axis);
    placement[i++] = {std::abs(b.origin.*axis - a.origin.*axis + 0.5 * (of_b - of_a)), std::abs(of_a), std::abs(of_b)};
  }
  std::ranges::sort(placement);
  return placement;
}

// A box of such a placement: its middle is `away` times the distance from the origin, and its lengths are at
// [axis][length].
Element placed(const NearPairs::Placement& at, double away, std::size_t length) {
  const auto low = [&](std::size_t axis) { return away * at[axis][0] - 0.5 * at[axis][length]; };
  return {
      ElementKind::kBox, {low(0), low(1), low(2)}, {at[0][length], 0, 0}, {0, at[1][length], 0}, {0, 0, at[2][length]}};
}

// The length that a gap is compared with: the longest side, edge or diameter.
double size_of(const Element& element) {
  if (element.kind != ElementKind::kDisc) return longest(element).length;
  const double radius = std::max(length(element.u), length(element.v));
  const double round = 2 * radius * std::min(1.0, std::numbers::pi * (1 - element.w.y));
  return std::max(round, radius * (1 - std::sqrt(element.w.x)));
}

double gap_along(double Vec3::*axis, const Element& a, const Element& b) {
  const auto bounds = [axis](const Element& e) {
    return wire::bounds_of(static_cast<wire::ElementKind>(e.kind), e.origin.*axis, e.u.*axis, e.v.*axis, e.w.*axis,
                           e.w.x, e.w.y);
  };
  const auto of_a = bounds(a), of_b = bounds(b);
  return std::max({of_a.low - of_b.high, of_b.low - of_a.high, 0.0});
}

// Priority for dividing a part: its light, plus four times the error of its light.
double weight_of(const PairPart& part) { return part.measure * (part.factor.mean + 4 * part.factor.error); }

double share_of(const PairFactor& found) {
  return found.geometric > 0 ? std::min(found.transported / found.geometric, 1.0) : 0;
}

// The share with the pseudo-rays added.
double likely_share(double share, double rays) { return (rays * share + kUnseen / 2) / (rays + kUnseen); }

}  // namespace

NearPairs::NearPairs(Vec3 spacing, std::uint32_t rays)
    : spacing_(spacing),
      parts_(std::clamp(rays / kManyRays, std::clamp(rays / kFewRays, 1u, kFewParts), kMaxParts)),
      rays_per_part_(rays / static_cast<std::uint32_t>(parts_)) {}

bool NearPairs::is_near(const Element& from, const Element& to) const {
  const Element a = physical(from, spacing_), b = physical(to, spacing_);
  const Vec3 gap{gap_along(&Vec3::x, a, b), gap_along(&Vec3::y, a, b), gap_along(&Vec3::z, a, b)};
  return length(gap) < kNear * std::max(size_of(a), size_of(b));
}

const Division* NearPairs::division_of(const Element& a, const Element& b) {
  if (!is_near(a, b) || measure_of(a) * measure_of(b) == 0) return nullptr;
  const Vec3 apart = b.origin - a.origin;
  std::vector<double> key{static_cast<double>(a.kind), static_cast<double>(b.kind)};
  for (const Vec3& v : {apart, a.u, a.v, a.w, b.u, b.v, b.w}) key.insert(key.end(), {v.x, v.y, v.z});
  const auto [at, fresh] = known_.try_emplace(std::move(key));
  if (fresh) {
    Element first = a, second = b;
    first.origin = {}, second.origin = apart;
    at->second = divide(first, second);
  }
  return &at->second;
}

GeometricFactor NearPairs::factor_of(const Element& a, const Element& b, bool near) {
  const auto placement = placement_of(a, b);
  if (!placement) return geometric_factor(a, b, near);
  const auto [at, fresh] = factors_.try_emplace(std::pair(*placement, near));
  if (fresh) at->second = geometric_factor(placed(*placement, 0, 1), placed(*placement, 1, 2), near);
  return at->second;
}

// Divides the part with the greatest weight across the longest side of its two elements, until there are parts_.
Division NearPairs::divide(const Element& a, const Element& b) {
  Division division{{a, b}, {}};
  auto& [elements, parts] = division;
  const auto add = [&](std::uint32_t of_a, std::uint32_t of_b, double measure) {
    const Element &x = elements[of_a], &y = elements[of_b];
    const bool near = is_near(x, y);
    parts.push_back({of_a, of_b, measure, factor_of(physical(x, spacing_), physical(y, spacing_), near), near});
  };
  const auto less = [](const PairPart& x, const PairPart& y) { return weight_of(x) < weight_of(y); };
  std::map<std::uint32_t, std::uint32_t>
      halves_of;  // of elements that were divided before: the first; the second follows
  add(0, 1, 1);
  while (parts.size() < parts_) {
    std::pop_heap(parts.begin(), parts.end(), less);
    const PairPart whole = parts.back();
    parts.pop_back();
    const Length length_a = longest(physical(elements[whole.a], spacing_));
    const Length length_b = longest(physical(elements[whole.b], spacing_));
    const bool first = length_a.length >= length_b.length;
    const auto [half, fresh] =
        halves_of.try_emplace(first ? whole.a : whole.b, static_cast<std::uint32_t>(elements.size()));
    if (fresh) {
      for (const Element& part : halves(elements[half->first], first ? length_a.way : length_b.way))
        elements.push_back(part);
    }
    for (std::uint32_t i = 0; i < 2; ++i) {
      first ? add(half->second + i, whole.b, 0.5 * whole.measure) : add(whole.a, half->second + i, 0.5 * whole.measure);
      std::push_heap(parts.begin(), parts.end(), less);
    }
  }
  return division;
}

// Each ray counts as if it either arrived wholly or not at all, the largest possible variation. Within a part that is
// still near, few rays are where most of its light is: so they count as an eighth, and their errors as correlated
// between such parts.
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
    const double even = sum.geometric * sum.geometric / squares;  // effective number of rays of equal weight
    const double share = sum.transported / sum.geometric, likely = likely_share(share, even);
    noise = sum.geometric * (std::sqrt(likely * (1 - likely) / (even + kUnseen)) + std::abs(likely - share) / 3);
  }
  sum.standard_error = noise + common;
  return sum;
}

double error_with_unseen(const PairFactor& found, std::uint32_t rays) {
  if (found.clear) return found.standard_error;
  const double unseen = std::numbers::sqrt2 / (rays + kUnseen);  // deviation of the share if all rays agree
  const double scatter =
      std::hypot(found.standard_error, unseen * (found.transported > 0 ? found.transported : found.geometric));
  // Where most rays are blocked, few runs have light, and a small scatter underestimates the error. So as far as the
  // scatter is that of rays that either arrive or not, half of the difference to the likely share is added (chosen: 99%
  // are then within three errors, from 8 rays on).
  const double share = share_of(found), yes_or_no = found.geometric * found.geometric * share * (1 - share) / rays;
  const double variance = std::pow(found.standard_error / wire::kStudent, 2);
  const double so_far = variance < yes_or_no ? variance / yes_or_no : 1;
  return scatter + so_far * std::max(0.0, likely_share(share, rays) - share) / 2 * found.geometric;
}

}  // namespace gicube
