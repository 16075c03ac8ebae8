#include "gicube/scene/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "gicube/scene/error.h"
#include "scene/geometry/mesh_distance.h"
#include "scene/geometry/signed_distance.h"

namespace gicube::scene {
namespace {

constexpr double kMaxCoordinate = 1e9;  // chosen: squares and volumes of such meshes keep enough digits

using Triangle = std::array<std::uint32_t, 3>;

// Merges points at the same position, and omits triangles that thereby lose a corner.
std::vector<Triangle> weld(const Mesh& mesh, const std::string& name) {
  std::vector<std::uint32_t> first(mesh.points.size());
  std::map<std::array<double, 3>, std::uint32_t> places;
  for (std::uint32_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& p = mesh.points[i];
    first[i] = places.try_emplace({p.x + 0.0, p.y + 0.0, p.z + 0.0}, i).first->second;  // + 0.0: no negative zeros
  }
  std::vector<Triangle> triangles;
  for (const Triangle& triangle : mesh.triangles) {
    Triangle welded{};
    for (std::size_t i = 0; i < 3; ++i) {
      if (triangle[i] >= first.size()) {
        throw InputError(name, "points from 0 to " + std::to_string(first.size()), std::to_string(triangle[i]));
      }
      welded[i] = first[triangle[i]];
    }
    if (welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0]) triangles.push_back(welded);
  }
  if (triangles.empty()) throw InputError(name, "triangles", "none");
  return triangles;
}

std::uint64_t edge_key(std::uint32_t from, std::uint32_t to) { return std::uint64_t{from} << 32 | to; }

std::string shown(Vec3 p) { return fmt::format("({} {} {})", p.x, p.y, p.z); }

// Every directed edge must occur once, and its opposite once.
void check_closed(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles, const std::string& name) {
  std::unordered_map<std::uint64_t, int> uses;
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++uses[edge_key(t[i], t[(i + 1) % 3])];
  }
  std::size_t open = 0, crossed = 0;
  std::uint64_t example = 0;
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint64_t edge = edge_key(t[i], t[(i + 1) % 3]), back = edge_key(t[(i + 1) % 3], t[i]);
      const bool missing = !uses.contains(back), twice = uses[edge] > 1;
      if ((missing || twice) && open + crossed == 0) example = edge;
      crossed += twice ? 1 : 0;
      open += missing && !twice ? 1 : 0;
    }
  }
  if (open + crossed == 0) return;
  throw InputError(
      name, "a closed surface: each edge in two triangles that both look outwards",
      fmt::format("{} open edges and {} with triangles that branch or look to opposite sides (first from {} to {})",
                  open, crossed, shown(points[static_cast<std::size_t>(example >> 32)]),
                  shown(points[static_cast<std::size_t>(example & 0xffffffff)])));
}

double angle_at(Vec3 corner, Vec3 a, Vec3 b) {
  return std::acos(std::clamp(dot(unit_or_zero(a - corner), unit_or_zero(b - corner)), -1.0, 1.0));
}

double volume_of(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  double six = 0;
  const Vec3 origin = points[triangles.front()[0]];
  for (const Triangle& t : triangles) {
    six += dot(points[t[0]] - origin, cross(points[t[1]] - origin, points[t[2]] - origin));
  }
  return six / 6;
}

}  // namespace

std::vector<SurfaceTriangle> closed_surface(const Mesh& mesh, const std::string& name) {
  for (const Vec3& p : mesh.points) {
    if (!(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= kMaxCoordinate)) {
      throw InputError(name, fmt::format("coordinates up to {}", kMaxCoordinate), shown(p));
    }
  }
  std::vector<Triangle> triangles = weld(mesh, name);
  const std::vector<Vec3>& points = mesh.points;
  check_closed(points, triangles, name);
  const double volume = volume_of(points, triangles);
  if (volume == 0) throw InputError(name, "a volume inside", "none");
  if (volume < 0) {
    for (Triangle& t : triangles) std::swap(t[1], t[2]);
  }

  std::vector<Vec3> normals(triangles.size()), corner_normals(points.size());
  std::unordered_map<std::uint64_t, Vec3> of_edge;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    normals[i] = unit_or_zero(cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]));
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t here = t[k], next = t[(k + 1) % 3], last = t[(k + 2) % 3];
      of_edge[edge_key(here, next)] = normals[i];
      corner_normals[here] = corner_normals[here] + angle_at(points[here], points[next], points[last]) * normals[i];
    }
  }

  std::vector<SurfaceTriangle> surface;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (normals[i] == Vec3{}) continue;
    const Triangle& t = triangles[i];
    SurfaceTriangle triangle;
    triangle.normal = normals[i];
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.corners[k] = points[t[k]];
      triangle.corner_normals[k] = corner_normals[t[k]];
      triangle.edge_normals[k] = normals[i] + of_edge[edge_key(t[(k + 1) % 3], t[k])];
    }
    surface.push_back(triangle);
  }
  return surface;
}

}  // namespace gicube::scene
