#include "meshes/triangulate.h"

#include <algorithm>
#include <map>

namespace gicube::samples {

// Corner i has the higher x, y, z where bits 0, 1, 2 of i are set.
std::array<Vec3, 3> corners_of(const Mesh& mesh, std::size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return {mesh.points[a], mesh.points[b], mesh.points[c]};
}

Vec3 area_of(const Mesh& mesh, std::size_t triangle) {
  const auto [a, b, c] = corners_of(mesh, triangle);
  return 0.5 * cross(b - a, c - a);
}

Mesh mesh_of(const BoxShape& box) {
  constexpr std::array<std::array<int, 4>, 6> kSides{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  Mesh mesh;
  for (const auto& side : kSides) {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (const int i : side) {
      mesh.points.push_back({(i & 1) != 0 ? box.high.x : box.low.x, (i & 2) != 0 ? box.high.y : box.low.y,
                             (i & 4) != 0 ? box.high.z : box.low.z});
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
  return mesh;
}

Mesh refined(const Mesh& mesh, double edge) {
  Mesh out{mesh.points, mesh.triangles};
  double longest = 0;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, length(mesh.points[triangle[i]] - mesh.points[triangle[(i + 1) % 3]]));
  }
  for (; longest > edge; longest /= 2) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, added] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(out.points.size()));
      if (added) out.points.push_back(0.5 * (out.points[a] + out.points[b]));
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> next;
    for (const auto& [a, b, c] : out.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      next.insert(next.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    out.triangles = std::move(next);
  }
  return out;
}

}  // namespace gicube::samples
