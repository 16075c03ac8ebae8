#include "meshes/corner_means.h"

#include "meshes/triangulate.h"

namespace gicube::samples {
std::vector<std::array<TriangleValue, 3>> corner_means(const Mesh& mesh, std::span<const TriangleValue> values) {
  constexpr double kAlike = 0.8;  // chosen: cosine
  std::vector<std::vector<std::size_t>> around(mesh.points.size());
  std::vector<Vec3> areas;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    areas.push_back(area_of(mesh, t));
    for (const std::uint32_t corner : mesh.triangles[t]) around[corner].push_back(t);
  }
  std::vector<std::array<TriangleValue, 3>> out(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      double weights = 0;
      for (const std::size_t other : around[mesh.triangles[t][k]]) {
        const double weight = length(areas[other]);
        if (dot(areas[t], areas[other]) < kAlike * length(areas[t]) * weight) continue;
        weights += weight;
        for (std::size_t c = 0; c < 3; ++c) out[t][k][c] += weight * values[other][c];
      }
      for (double& part : out[t][k]) part /= weights > 0 ? weights : 1;
    }
  }
  return out;
}

TriangleValue between_corners(const Mesh& mesh, std::size_t triangle, const std::array<TriangleValue, 3>& corners,
                              Vec3 place) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  const Vec3 from = mesh.points[a], u = mesh.points[b] - from, v = mesh.points[c] - from, area = cross(u, v);
  const double second = dot(cross(place - from, v), area) / dot(area, area);
  const double third = dot(cross(u, place - from), area) / dot(area, area);
  TriangleValue out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = (1 - second - third) * corners[0][i] + second * corners[1][i] + third * corners[2][i];
  return out;
}

}  // namespace gicube::samples
