#include "polygon_gi/polygon_gi.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gicube::samples {

// Around each corner the mean, by area, over triangles of nearly the same facing.
void PolygonGi::spread() {
  constexpr double kSmooth = 0.8;  // chosen: cosine, 37 degrees
  at_corners_.assign(statistics_.sides, {});
  for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
    const Mesh& mesh = surfaces_[s].mesh;
    std::vector<std::vector<std::uint32_t>> around(mesh.points.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const std::uint32_t corner : mesh.triangles[t]) around[corner].push_back(t);
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::uint32_t side = 0; side < 2; ++side) {
        const std::uint32_t own = first_[s] + 2 * t + side;
        for (std::size_t k = 0; k < 3; ++k) {
          double weights = 0;
          for (const std::uint32_t other : around[mesh.triangles[t][k]]) {
            const std::uint32_t i = first_[s] + 2 * other + side;
            if (elements_[i].dark || dot(normal(elements_[own]), normal(elements_[i])) < kSmooth) continue;
            weights += elements_[i].weight;
            for (std::size_t c = 0; c < 3; ++c)
              at_corners_[own][k][c] += elements_[i].weight * elements_[i].albedo[c] * incident_[i][c];
          }
          for (double& part : at_corners_[own][k]) part /= weights > 0 ? weights : 1;
        }
      }
    }
  }
}

// The radiosity there.
Rgb PolygonGi::seen(const End& end) const {
  if (!end.element) return {};
  const GiElement& element = elements_[*end.element];
  Rgb out = element.emission;
  if (!element.zone) {
    const auto [a, b, c] = corners(element);
    const Vec3 area = cross(b - a, c - a);
    const double v = dot(cross(end.place - a, c - a), area) / dot(area, area);
    const double w = dot(cross(b - a, end.place - a), area) / dot(area, area);
    const auto& [at_a, at_b, at_c] = at_corners_[*end.element];
    for (std::size_t i = 0; i < 3; ++i) out[i] += (1 - v - w) * at_a[i] + v * at_b[i] + w * at_c[i];
    return out;
  }
  const Vec3 voxel = medium_.voxel_of(end.place);
  std::array<double, 3> at{voxel.x, voxel.y, voxel.z}, way{};
  std::array<int, 3> low{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double centre = at[axis] / settings_.zone - 0.5;
    low[axis] = static_cast<int>(std::floor(centre));
    way[axis] = centre - low[axis];
  }
  Rgb sum{};
  double weights = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::size_t index = 0;
    for (std::size_t axis = 3; axis-- > 0;) {
      const bool high = (corner >> axis & 1) != 0;
      const int zone = low[axis] + (high ? 1 : 0);
      weight *= zone < 0 || zone >= zones_[axis] ? 0 : high ? way[axis] : 1 - way[axis];
      index = index * static_cast<std::size_t>(zones_[axis]) +
              static_cast<std::size_t>(std::clamp(zone, 0, zones_[axis] - 1));
    }
    const std::uint32_t i = zone_of_[index];
    if (i == kNoElement || rows_[i].shares.empty() || weight == 0) continue;
    weights += weight;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * radiosity_[i][c];
  }
  for (double& part : sum) part /= weights > 0 ? weights : 1;
  return sum;
}

RadiancePicture PolygonGi::picture(const View& view, int rays) {
  const Eye eye(view, medium_);
  RadianceSum sum(view.width, view.height);
  const auto width = static_cast<std::size_t>(view.width);
  for (int ray = 0; ray < rays; ++ray) {
    std::vector<Rgb> pixels(sum.pixels());
    for (std::size_t first = 0; first < pixels.size(); first += kFlightsAtOnce) {
      std::vector<Flight> flights;
      for (std::size_t i = first; i < std::min(pixels.size(), first + kFlightsAtOnce); ++i) {
        PathRandom random(settings_.seed ^ 0xE7E, i);
        const auto [u, v] = spread_point(ray, {random.uniform(), random.uniform()});
        flights.push_back(
            {eye.place(), eye.direction(static_cast<double>(i % width) + u, static_cast<double>(i / width) + v)});
      }
      const std::vector<End> all = ends(flights);
      for (std::size_t k = 0; k < all.size(); ++k) {
        const Rgb radiosity = seen(all[k]);
        for (std::size_t c = 0; c < 3; ++c) pixels[first + k][c] = radiosity[c] / std::numbers::pi;
      }
    }
    sum.add(pixels);
  }
  statistics_.rays = flights_.rays();
  return sum.picture();
}

}  // namespace gicube::samples
