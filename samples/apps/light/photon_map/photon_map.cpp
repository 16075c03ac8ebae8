#include "light/photon_map/photon_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gicube::samples {
namespace {

constexpr std::size_t kPathsAtOnce = 32768;  // chosen: paths that are in memory together

}  // namespace

PhotonMapping::PhotonMapping(Board& board, const Medium& medium, const Lights& lights, const View& view,
                             const PhotonSettings& settings)
    : medium_(medium),
      lights_(lights),
      eye_(view, medium),
      settings_(settings),
      flights_(board, medium, settings.step, settings.seed),
      paths_(medium, lights, flights_),
      surfaces_({}),
      media_({}),
      sum_(view.width, view.height) {}

void PhotonMapping::shoot() {
  std::vector<Photon> surfaces, media;
  for (std::uint64_t first = 0; first < settings_.photons; first += kPathsAtOnce) {
    std::vector<Path> paths;
    for (std::uint64_t i = first; i < std::min(first + kPathsAtOnce, settings_.photons); ++i) {
      const std::uint64_t number = sum_.passes() * settings_.photons + i;
      paths.push_back(paths_.from_light({settings_.seed, 2 * number}));
    }
    paths_.walk(paths, settings_.max_scatterings);
    for (const Path& path : paths) {
      // Shadow rays find the light of the first interaction.
      for (std::size_t i = 2; i < path.vertices.size(); ++i) {
        const Vertex& vertex = path.vertices[i];
        if (vertex.sharp) continue;
        Photon photon{vertex.place, vertex.direction, vertex.weight};
        for (double& part : photon.power) part /= static_cast<double>(settings_.photons);
        (vertex.normal == Vec3{} ? media : surfaces).push_back(photon);
      }
    }
  }
  statistics_.emitted += settings_.photons;
  statistics_.on_surfaces += surfaces.size();
  statistics_.in_media += media.size();
  surfaces_ = PhotonTree(std::move(surfaces));
  media_ = PhotonTree(std::move(media));
}

// Radiance towards the eye that is scattered from the photons' power, times the vertex's weight.
Rgb PhotonMapping::gathered(const Vertex& vertex) {
  using std::numbers::pi;
  const Optics& optics = medium_.optics(vertex.tag);
  const bool surface = vertex.normal != Vec3{};
  const auto near = (surface ? surfaces_ : media_)
                        .nearest(vertex.place, static_cast<std::size_t>(settings_.neighbours), settings_.radius);
  const double r = near.radius;
  if (!surface) {
    const Dims& dims = medium_.dims();
    const Vec3 low = vertex.place,
               high = medium_.place_of({dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0}) - vertex.place;
    ++statistics_.looks_in_media;
    statistics_.beyond_faces += std::min({low.x, low.y, low.z, high.x, high.y, high.z}) < r ? 1 : 0;
  }
  Rgb sum{};
  for (const Photon* photon : near.photons) {
    double share = density(optics, photon->direction, vertex.normal, -1.0 * vertex.direction);
    if (surface) {  // a density per area, and no light from behind the surface
      const double cosine = std::abs(dot(vertex.normal, vertex.direction));
      share = cosine > 0 ? share / cosine / (pi * r * r) : 0;
    } else {
      share /= 4.0 / 3 * pi * r * r * r;
    }
    add(sum, product(photon->power, optics.albedo, share));
  }
  // The eye's path interacts, as photons do, with a probability in proportion to the extinction.
  const double extinction = surface ? 1 : medium_.extinction(vertex.place);
  return extinction > 0 ? product(vertex.weight, sum, 1 / extinction) : Rgb{};
}

void PhotonMapping::look(std::size_t first, std::size_t count, std::vector<Rgb>& pixels) {
  std::vector<Path> paths;
  for (std::size_t pixel = first; pixel < first + count; ++pixel) {
    paths.push_back(from_eye(eye_, pixel, {settings_.seed, 2 * (sum_.passes() * sum_.pixels() + pixel) + 1}));
  }
  struct Shadow {
    Segment segment;
    std::size_t pixel = 0;
    Rgb value;
  };
  std::vector<Shadow> shadows;
  const auto see = [&](const Path& path, double reach) {
    if (!path.vertices.back().sharp) return;
    const auto pixel = first + static_cast<std::size_t>(&path - paths.data());
    lights_.meet(path.flight.place, path.flight.direction,
                 [&](const LightPoint&, double distance, const Rgb& radiance) {
                   if (distance < reach) add(pixels[pixel], product(path.weight, radiance, 1));
                 });
  };
  std::vector<char> found(paths.size(), 0);
  // Follows the paths through mirrors and glass to the first vertex that scatters in all directions.
  for (int i = 0; i < settings_.max_scatterings; ++i) {
    paths_.walk(paths, 1, see);
    for (std::size_t k = 0; k < paths.size(); ++k) {
      Path& path = paths[k];
      const Vertex& vertex = path.vertices.back();
      if (vertex.tag < 0 || vertex.sharp || found[k] != 0) continue;
      path.ended = true;
      found[k] = 1;
      add(pixels[first + k], gathered(vertex));
      const LightPoint point = lights_.point(path.random);
      const bool distant = lights_.is_distant(point.light);
      const Vec3 target = distant ? vertex.place + 4 * medium_.radius() * point.place : point.place;
      const Vec3 way = target - vertex.place, direction = normalise(way);
      const Optics& optics = medium_.optics(vertex.tag);
      const double towards = density(optics, vertex.direction, vertex.normal, direction);
      const Rgb share = product(vertex.weight, optics.albedo, towards / (distant ? 1 : dot(way, way)));
      const Rgb value = product(share, lights_.emitted(point, -1.0 * direction), 1);
      if (!(std::ranges::max(value) > 0)) continue;
      shadows.push_back({{beside(vertex, direction), target}, first + k, value});
    }
    if (std::ranges::all_of(paths, [](const Path& path) { return path.ended; })) break;
  }
  std::vector<Segment> segments;
  for (const Shadow& shadow : shadows) segments.push_back(shadow.segment);
  const std::vector<double> through = flights_.transmittances(segments);
  for (std::size_t i = 0; i < shadows.size(); ++i) add(pixels[shadows[i].pixel], shadows[i].value, through[i]);
}

void PhotonMapping::pass() {
  shoot();
  std::vector<Rgb> pixels(sum_.pixels());
  for (std::size_t first = 0; first < pixels.size(); first += kPathsAtOnce) {
    look(first, std::min(kPathsAtOnce, pixels.size() - first), pixels);
  }
  sum_.add(pixels);
  statistics_.rays = flights_.rays();
}

}  // namespace gicube::samples
