#include "scene/geometry/placed_field.h"

#include <cmath>

namespace gicube::scene {
namespace {

constexpr double kSimilar = 1e-9;    // chosen: of factors; rotations leave their rounding
constexpr double kOnSurface = 1e-4;  // chosen, voxels: far below a density's last bit, 2 / 4095
constexpr int kNewtonSteps = 12;     // chosen: 3 to 5 do where they arrive
constexpr int kMarchSteps = 64;      // chosen: exact fields take a few steps, bounds of distances some more
constexpr int kSlides = 24;          // chosen: each gets nearer; smooth surfaces take 3 to 8
constexpr int kHalvings = 5;         // chosen: of a slide that got no nearer
constexpr double kWorthASlide =
    0.01;  // chosen, voxels: off by that much along the surface, a distance of a voxel errs by 5e-5
constexpr double kFarFromSurface = 0.25;  // chosen, voxels: nearer by, the surface's normal is the better direction

}  // namespace

PlacedField::PlacedField(const PlacedSolid& placed)
    : solid_(&placed), to_local_(inverse(placed.to_voxels)), stretches_(principal_stretches(placed.to_voxels)) {
  is_similar_ = stretches_[2].factor <= (1 + kSimilar) * stretches_[0].factor;
}

Distance PlacedField::first_order(const Distance& local) const {
  const Vec3 gradient = to_local_.transposed(local.away);
  const double slope = length(gradient);
  if (!(slope > 0)) return {stretches_.front().factor * local.distance, {}};
  return {local.distance / slope, (1 / slope) * gradient};
}

// Finds a point of the surface by Newton's method, along the gradient in voxel space or along that in the field's own
// space, where one step suffices for an exact distance.
std::optional<Vec3> PlacedField::onto_surface(Vec3 q, Space space) const {
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Vec3 own = to_local_.point(q);
    const Distance local = solid_->field(own), here = first_order(local);
    if (std::abs(here.distance) <= kOnSurface) return q;
    if (here.away == Vec3{}) return std::nullopt;
    q = space == Space::kVoxels
            ? q - here.distance * here.away
            : solid_->to_voxels.point(own - local.distance / dot(local.away, local.away) * local.away);
  }
  return std::nullopt;
}

// The nearer of both results to `p`: near the rim of a flat solid the first method does not converge, and near its
// sides the second one leads away.
std::optional<Vec3> PlacedField::onto_surface_near(Vec3 p, Vec3 q) const {
  const auto one = onto_surface(q, Space::kVoxels), other = onto_surface(q, Space::kOwn);
  if (!one || !other) return one ? one : other;
  return length(*one - p) <= length(*other - p) ? one : other;
}

// The distance of the surface from `p` in a principal direction, at most `limit`, by sphere tracing (J. C. Hart 1996):
// no surface is nearer than the field's distance, which the map multiplies by `factor` in this direction. `at_p`: the
// field's distance at `p`.
double PlacedField::along(Vec3 p, Vec3 direction, double factor, double at_p, double limit) const {
  double free = factor * std::abs(at_p), way = 0;
  for (int step = 0; step < kMarchSteps && free > kOnSurface; ++step) {
    way += free;
    if (way >= limit) return limit;
    free = factor * std::abs(solid_->field(to_local_.point(p + way * direction)).distance);
  }
  return free > kOnSurface ? limit : way;
}

// Moves `q` along the surface to the nearest point: to the foot of `p` on the tangent plane, and back onto the surface
// (E. Hartmann 1999), or half as far if that is not nearer.
void PlacedField::slide_towards(Vec3 p, Vec3& q) const {
  for (int slide = 0; slide < kSlides; ++slide) {
    const Vec3 normal = first_order(solid_->field(to_local_.point(q))).away, rest = p - q;
    Vec3 step = rest - dot(rest, normal) * normal;
    bool is_nearer = false;
    for (int halving = 0; halving < kHalvings && !is_nearer && length(step) > kWorthASlide; ++halving) {
      const auto next = onto_surface_near(p, q + step);
      is_nearer = next && length(p - *next) < length(rest);
      if (is_nearer) q = *next;
      step = 0.5 * step;
    }
    if (!is_nearer) return;
  }
}

Distance PlacedField::distance(Vec3 p, double reach) const {
  const Distance local = solid_->field(to_local_.point(p));
  const Distance first = first_order(local);
  if (is_similar_ || stretches_.front().factor * std::abs(local.distance) >= reach) return first;

  // A first point is searched in several ways, because the nearest point may be on another side than the field's
  // nearest, such as on the flat side of a flattened ball.
  const auto arrived = onto_surface_near(p, p);
  const double farthest = stretches_.back().factor * std::abs(local.distance) + kNearVoxels;
  Vec3 nearest = arrived.value_or(p);
  double limit = arrived ? length(nearest - p) : farthest;
  for (const auto& [direction, factor] : stretches_) {
    for (const Vec3 way : {direction, -1 * direction}) {
      const double reached = along(p, way, factor, local.distance, limit);
      if (reached < limit) limit = reached, nearest = p + reached * way;
    }
  }
  if (limit == 0 || limit == farthest) return first;  // on the surface, or no point was found
  slide_towards(p, nearest);
  const Vec3 offset = p - nearest;
  const double size = length(offset), side = local.distance < 0 ? -1 : 1;
  return {side * size,
          size > kFarFromSurface ? (side / size) * offset : first_order(solid_->field(to_local_.point(nearest))).away};
}

}  // namespace gicube::scene
