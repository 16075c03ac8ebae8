#include "light/transport/paths.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gicube::samples {
namespace {

constexpr double kRouletteBelow = 0.1;  // chosen: share of a path's initial weight

}  // namespace

double density_at(double density, const Vertex& from, const Vertex& to) {
  const Vec3 way = to.place - from.place;
  const double squared = dot(way, way);
  if (to.distant || squared == 0) return density;
  const double cosine = to.normal == Vec3{} ? 1 : std::abs(dot(to.normal, way)) / std::sqrt(squared);
  return from.distant ? density * cosine : density * cosine / squared;
}

Vec3 beside(const Vertex& vertex, Vec3 direction) {
  return vertex.tag < 0 || vertex.normal == Vec3{} ? vertex.place
                                                   : off_surface({vertex.place, 0, 0, vertex.normal}, direction);
}

Path from_eye(const Eye& eye, std::size_t pixel, PathRandom random) {
  Path path;
  path.random = random;
  const double x = static_cast<double>(pixel % eye.width()) + path.random.uniform();
  const double y = static_cast<double>(pixel / eye.width()) + path.random.uniform();
  path.flight = {eye.place(), eye.direction(x, y)};
  path.density = eye.density(path.flight.direction) / static_cast<double>(eye.pixels());
  path.weight = {1, 1, 1};
  path.vertices.push_back({.place = eye.place(), .weight = path.weight});
  return path;
}

Path Paths::from_light(PathRandom random) const {
  Path path;
  path.random = random;
  const Lights::Emission emission = lights_.emit(path.random);
  Vertex& light = path.vertices.emplace_back();
  light.place = emission.place;
  light.normal = emission.point.normal;
  light.distant = lights_.is_distant(emission.point.light);
  light.forward = emission.point.density;
  path.flight = {emission.place, emission.direction};
  path.density = emission.density;
  path.weight = light.weight = emission.power;
  return path;
}

void Paths::walk(std::span<Path> paths, int max_scatterings,
                 const std::function<void(const Path&, double)>& seen) const {
  std::vector<double> heaviest;
  for (const Path& path : paths) heaviest.push_back(std::ranges::max(path.weight));
  for (int round = 0; round < max_scatterings; ++round) {
    std::vector<Flight> flights;
    std::vector<std::size_t> whose;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      if (paths[i].ended || !(std::ranges::max(paths[i].weight) > 0)) continue;
      flights.push_back(paths[i].flight);
      whose.push_back(i);
    }
    if (flights.empty()) return;
    const auto hits = flights_.first_hits(flights);
    for (std::size_t k = 0; k < hits.size(); ++k) {
      Path& path = paths[whose[k]];
      if (seen) seen(path, hits[k] ? hits[k]->distance : std::numeric_limits<double>::infinity());
      if (!hits[k]) {
        path.ended = true;
        continue;
      }
      const Hit& hit = *hits[k];
      const Optics& optics = medium_.optics(hit.tag);
      Vertex vertex{.place = hit.place,
                    .normal = hit.normal,
                    .direction = path.flight.direction,
                    .tag = hit.tag,
                    .sharp = optics.sharp(),
                    .weight = path.weight};
      vertex.forward = density_at(path.density, path.vertices.back(), vertex);
      for (std::size_t c = 0; c < 3; ++c) path.weight[c] *= optics.albedo[c];
      const double survives = std::min(1.0, std::ranges::max(path.weight) / (kRouletteBelow * heaviest[whose[k]]));
      const Vec3 out = scatter(optics, path.flight.direction, hit.normal, path.random);
      Vertex& before = path.vertices.back();
      before.backward =
          density_at(density(optics, -1.0 * out, hit.normal, -1.0 * path.flight.direction), vertex, before);
      path.density = density(optics, path.flight.direction, hit.normal, out);
      path.vertices.push_back(vertex);
      path.ended = path.random.uniform() >= survives;
      for (double& part : path.weight) part /= std::max(survives, 1e-300);
      const bool glass = optics.look == Look::kGlass;
      path.flight = {hit.normal == Vec3{} ? hit.place : off_surface(hit, out), out, glass && dot(out, hit.normal) < 0};
    }
  }
}

}  // namespace gicube::samples
