#include "compose/shell.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"

namespace gicube::samples {
namespace {

// Normals of corners, weighted by the triangles' angles, so that they do not depend on the triangulation.
std::vector<Vec3> corner_normals(const Mesh& mesh) {
  std::vector<Vec3> sums(mesh.points.size());
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 at = mesh.points[triangle[i]], a = mesh.points[triangle[(i + 1) % 3]] - at,
                 b = mesh.points[triangle[(i + 2) % 3]] - at, area = cross(a, b);
      if (!(length(area) > 0)) continue;
      sums[triangle[i]] = sums[triangle[i]] + std::atan2(length(area), dot(a, b)) * normalise(area);
    }
  }
  for (Vec3& normal : sums) normal = length(normal) > 0 ? normalise(normal) : Vec3{};
  return sums;
}

// chosen: per triangle. A ray may have a segment for each copy.
constexpr double kMaxCopies = 1000;

void check_copies(const Mesh& mesh, const ShellSettings& settings) {
  for (const auto& triangle : mesh.texture_triangles) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto [low, high] = std::ranges::minmax(
          {mesh.texture[triangle[0]][axis], mesh.texture[triangle[1]][axis], mesh.texture[triangle[2]][axis]});
      const double copies = (high - low) * (axis == 0 ? settings.repeat_u : settings.repeat_v);
      require(copies <= kMaxCopies, axis == 0 ? "repeat_u" : "repeat_v",
              "at most 1000 copies of the volume on a triangle", copies);
    }
  }
}

// A prism's corner at the triangle's corner `which`, on the mesh or outside.
struct PrismCorner {
  std::size_t which;
  bool outside;
};

}  // namespace

Shell::Shell(const Mesh& mesh, const ShellSettings& settings, const Dims& dims)
    : voxels_{dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0} {
  if (mesh.texture_triangles.size() != mesh.triangles.size()) {
    throw InputError("file", "a mesh whose faces all have texture coordinates (.obj, vt)", "others");
  }
  check_copies(mesh, settings);
  const std::vector<Vec3> normals = corner_normals(mesh);
  Mesh faces;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& triangle = mesh.triangles[t];
    // The corners' order in the mesh determines the division, so that neighbours divide their common side equally.
    std::array<std::size_t, 3> order{0, 1, 2};
    std::ranges::sort(order, {}, [&](std::size_t i) { return triangle[i]; });
    const auto& [i, j, k] = order;
    const std::array<std::array<PrismCorner, 4>, 3> parts{{{{{i, false}, {j, false}, {k, false}, {k, true}}},
                                                           {{{i, false}, {j, false}, {j, true}, {k, true}}},
                                                           {{{i, false}, {i, true}, {j, true}, {k, true}}}}};
    for (const auto& part : parts) {
      Tetrahedron made;
      std::array<Vec3, 4> points;
      for (std::size_t c = 0; c < 4; ++c) {
        const std::uint32_t point = triangle[part[c].which];
        const auto& uv = mesh.texture[mesh.texture_triangles[t][part[c].which]];
        points[c] = mesh.points[point] + (part[c].outside ? settings.thickness : 0) * normals[point];
        made.places[c] = {settings.repeat_u * uv[0], settings.repeat_v * uv[1], part[c].outside ? 1.0 : 0.0};
        made.normals[c] = normals[point];
      }
      const Vec3 a = points[1] - points[0], b = points[2] - points[0], c = points[3] - points[0];
      Affine edges{.rows = {Vec3{a.x, b.x, c.x}, Vec3{a.y, b.y, c.y}, Vec3{a.z, b.z, c.z}}, .offset = points[0]};
      const double size = length(a) * length(b) * length(c);
      if (!(std::abs(determinant(edges)) > 1e-12 * size)) continue;  // flat
      made.weights = inverse(edges);
      tetrahedra_.push_back(made);
      const auto first = static_cast<std::uint32_t>(faces.points.size());
      faces.points.insert(faces.points.end(), points.begin(), points.end());
      for (const auto& face : {std::array{0u, 1u, 2u}, {0u, 1u, 3u}, {0u, 2u, 3u}, {1u, 2u, 3u}}) {
        faces.triangles.push_back({first + face[0], first + face[1], first + face[2]});
      }
    }
  }
  caster_ = std::make_unique<MeshCaster>(std::vector<Mesh>{std::move(faces)});
}

std::pair<std::array<double, 4>, std::array<double, 4>> Shell::Tetrahedron::weights_along(Vec3 from,
                                                                                          Vec3 direction) const {
  const Vec3 start = weights.point(from), slope = weights.vector(direction);
  return {{1 - start.x - start.y - start.z, start.x, start.y, start.z},
          {-slope.x - slope.y - slope.z, slope.x, slope.y, slope.z}};
}

void Shell::add_spans(Vec3 from, Vec3 direction, std::size_t volume, Vec3 towards_light, const Phong& phong,
                      std::vector<Span>& spans) const {
  thread_local std::vector<std::pair<std::uint32_t, std::uint32_t>> met;
  caster_->meet(from, direction, met);
  for (auto& [mesh, face] : met) face /= 4;  // now tetrahedra
  std::ranges::sort(met);
  met.erase(std::unique(met.begin(), met.end()), met.end());
  struct Part {
    double near, far;
    const Tetrahedron* tetrahedron;
  };
  thread_local std::vector<Part> parts;
  parts.clear();
  for (const auto& [mesh, which] : met) {
    const auto [at, by] = tetrahedra_[which].weights_along(from, direction);
    double near = 0, far = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 4; ++i) {  // where all weights are at least 0
      if (by[i] > 0) near = std::max(near, -at[i] / by[i]);
      if (by[i] < 0) far = std::min(far, -at[i] / by[i]);
      if (by[i] == 0 && at[i] < 0) far = -1;
    }
    if (far > near) parts.push_back({near, far, &tetrahedra_[which]});
  }
  // A ray in the common face of two tetrahedra, or where the shell overlaps, is in both: the one that it enters first
  // counts.
  std::ranges::stable_sort(parts, {}, &Part::near);
  double done = 0;
  for (const auto& [entry, far, own] : parts) {
    const double near = std::max(entry, done);
    if (!(far > near)) continue;
    done = far;
    const auto [at, by] = own->weights_along(from, direction);
    Vec3 origin, along, normal;
    for (std::size_t i = 0; i < 4; ++i) {
      origin = origin + at[i] * own->places[i], along = along + by[i] * own->places[i];
      normal = normal + (at[i] + 0.5 * (near + far) * by[i]) * own->normals[i];
    }
    const double facing = length(normal) > 0 ? std::max(dot(normalise(normal), towards_light), 0.0) : 0;
    const double shade = std::min(phong.ambient + phong.diffuse * facing, 1.0);
    // Divides at the ends of copies of the volume.
    for (double begin = near; begin < far;) {
      const double middle = std::nextafter(begin, far) + 1e-9 * (far - near);
      const double u = std::floor(origin.x + middle * along.x), v = std::floor(origin.y + middle * along.y);
      double end = far;
      for (const auto& [o, d, cell] : {std::array{origin.x, along.x, u}, {origin.y, along.y, v}}) {
        if (d != 0) end = std::min(end, ((d > 0 ? cell + 1 : cell) - o) / d);
      }
      end = std::max(end, middle);
      spans.push_back({volume,
                       begin,
                       std::min(end, far),
                       {(origin.x - u) * voxels_.x, (origin.y - v) * voxels_.y, origin.z * voxels_.z},
                       {along.x * voxels_.x, along.y * voxels_.y, along.z * voxels_.z},
                       shade});
      begin = end;
    }
  }
}

}  // namespace gicube::samples
