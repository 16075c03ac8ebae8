#include "polygon_gi/polygon_gi.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "meshes/corner_means.h"

namespace gicube::samples {

void PolygonGi::spread() {
  at_corners_.assign(statistics_.sides, {});
  for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
    const Mesh& mesh = surfaces_[s].mesh;
    for (std::uint32_t side = 0; side < 2; ++side) {
      std::vector<Rgb> reflected;
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint32_t i = first_[s] + 2 * t + side;
        Rgb& one = reflected.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) one[c] = elements_[i].albedo[c] * incident_[i][c];
      }
      const auto means = corner_means(mesh, reflected);
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) at_corners_[first_[s] + 2 * t + side] = means[t];
    }
  }
}

// The radiosity there.
Rgb PolygonGi::seen(const End& end) const {
  if (!end.element) return {};
  const GiElement& element = elements_[*end.element];
  Rgb out = element.emission;
  if (!element.zone) {
    const Rgb reflected =
        between_corners(surfaces_[element.surface].mesh, element.triangle, at_corners_[*end.element], end.place);
    for (std::size_t c = 0; c < 3; ++c) out[c] += reflected[c];
    return out;
  }
  Rgb sum{};
  double weights = 0;
  zones_.around(end.place, [&](std::size_t zone, double weight) {
    const std::uint32_t i = zone_of_[zone];
    if (i == kNoElement || rows_[i].shares.empty()) return;
    weights += weight;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * radiosity_[i][c];
  });
  for (double& part : sum) part /= weights > 0 ? weights : 1;
  return sum;
}

RadiancePicture PolygonGi::picture(const View& view, int rays) {
  const Eye eye(view, medium_);
  RadianceSum sum(view.width, view.height);
  for (int ray = 0; ray < rays; ++ray) {
    std::vector<Rgb> pixels(sum.pixels());
    for (std::size_t first = 0; first < pixels.size(); first += kFlightsAtOnce) {
      std::vector<Flight> flights;
      for (std::size_t i = first; i < std::min(pixels.size(), first + kFlightsAtOnce); ++i)
        flights.push_back({eye.place(), eye.direction(i, ray, settings_.seed)});
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
