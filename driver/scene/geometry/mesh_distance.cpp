#include "scene/geometry/mesh_distance.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "gicube/scene/mesh.h"

namespace gicube::scene {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;  // chosen: a box test costs about as much as one triangle

struct Nearest {
  double squared = std::numeric_limits<double>::infinity();
  Vec3 point, normal;  // the surface's pseudonormal there, of any length
};

// C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
void nearest_on(const SurfaceTriangle& t, Vec3 p, Nearest& best) {
  const auto& [a, b, c] = t.corners;
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp);
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  Vec3 point, normal;
  if (d1 <= 0 && d2 <= 0) {
    point = a, normal = t.corner_normals[0];
  } else if (d3 >= 0 && d4 <= d3) {
    point = b, normal = t.corner_normals[1];
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    point = a + (d1 / (d1 - d3)) * ab, normal = t.edge_normals[0];
  } else if (d6 >= 0 && d5 <= d6) {
    point = c, normal = t.corner_normals[2];
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    point = a + (d2 / (d2 - d6)) * ac, normal = t.edge_normals[2];
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    point = b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b), normal = t.edge_normals[1];
  } else {
    const double scale = 1 / (va + vb + vc);
    point = a + (vb * scale) * ab + (vc * scale) * ac, normal = t.normal;
  }
  const double squared = dot(p - point, p - point);
  if (squared < best.squared) best = {squared, point, normal};
}

}  // namespace

void MeshDistance::Bounds::add(Vec3 p) {
  low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
  high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

double MeshDistance::Bounds::squared_distance(Vec3 p) const {
  const Vec3 beyond{std::max({low.x - p.x, p.x - high.x, 0.0}), std::max({low.y - p.y, p.y - high.y, 0.0}),
                    std::max({low.z - p.z, p.z - high.z, 0.0})};
  return dot(beyond, beyond);
}

MeshDistance::MeshDistance(const Mesh& mesh, const std::string& name)
    : surface_(closed_surface(mesh, name)), boxes_(1) {
  build(0, 0, static_cast<std::uint32_t>(surface_.size()));
}

// Splits at the median along the longest side, so the depth is at most log2 of the count.
void MeshDistance::build(std::size_t index, std::uint32_t first, std::uint32_t last) {
  Bounds all, centres;
  for (std::uint32_t i = first; i < last; ++i) {
    const auto& [a, b, c] = surface_[i].corners;
    all.add(a), all.add(b), all.add(c), centres.add(a + b + c);
  }
  boxes_[index] = {all, first, last - first};
  if (last - first <= kLeafTriangles) return;
  const Vec3 side = centres.high - centres.low;
  const auto along = [&side](const SurfaceTriangle& t) {
    const Vec3 sum = t.corners[0] + t.corners[1] + t.corners[2];
    return side.x >= side.y && side.x >= side.z ? sum.x : side.y >= side.z ? sum.y : sum.z;
  };
  const std::uint32_t middle = first + (last - first) / 2;
  const auto begin = surface_.begin();
  std::nth_element(begin + first, begin + middle, begin + last,
                   [&](const SurfaceTriangle& a, const SurfaceTriangle& b) { return along(a) < along(b); });
  const auto child = static_cast<std::uint32_t>(boxes_.size());
  boxes_[index] = {all, child, 0};
  boxes_.resize(boxes_.size() + 2);
  build(child, first, middle);
  build(child + 1, middle, last);
}

Distance MeshDistance::at(Vec3 p) const {
  Nearest nearest;
  std::array<std::uint32_t, 64> stack{};  // the depth is at most log2 of kMaxTriangles, with two boxes per level
  std::size_t depth = 1;
  while (depth > 0) {
    const Box& box = boxes_[stack[--depth]];
    if (box.bounds.squared_distance(p) >= nearest.squared) continue;
    for (std::uint32_t i = 0; i < box.count; ++i) nearest_on(surface_[box.first + i], p, nearest);
    if (box.count != 0) continue;
    const bool swap = boxes_[box.first].bounds.squared_distance(p) < boxes_[box.first + 1].bounds.squared_distance(p);
    stack[depth++] = box.first + (swap ? 1 : 0);  // the nearer one is taken first
    stack[depth++] = box.first + (swap ? 0 : 1);
  }
  const Vec3 offset = p - nearest.point;
  const double distance = length(offset), side = dot(offset, nearest.normal) < 0 ? -1 : 1;
  // On the surface the offset has no direction.
  const Vec3 away = distance > 1e-9 ? (side / distance) * offset : normalise(nearest.normal);
  return {side * distance, away};
}

}  // namespace gicube::scene
