#include "subsurface/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "gicube/parallel_for.h"
#include "meshes/triangulate.h"

namespace gicube::samples {
namespace {

struct Facet {
  Vec3 middle, area;
};

std::vector<Facet> facets(const Mesh& mesh) {
  std::vector<Facet> out;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [p, q, r] = corners_of(mesh, t);
    out.push_back({1.0 / 3 * (p + q + r), area_of(mesh, t)});
  }
  return out;
}

}  // namespace

std::vector<Rgb> spread_beneath(const Mesh& mesh, const Irradiance& irradiance, const Profile& profile, double scale) {
  const std::vector<Facet> all = facets(mesh);
  const double reach = profile.rings.empty() ? 0 : scale * profile.rings.back().outer;
  std::vector<std::size_t> order(all.size());  // along x, so that only near ones are looked at
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](std::size_t i) { return all[i].middle.x; });
  std::vector<Rgb> out(all.size());
  parallel_for(order.size(), 0, [&](std::size_t at) {
    const std::size_t own = order[at];
    const auto add = [&](std::size_t other) {
      const double distance = length(all[other].middle - all[own].middle), size = length(all[other].area);
      if (distance >= reach) return;
      // On a unit of the mesh's area; within a triangle the profile may change much.
      const Rgb share =
          other == own ? profile.within(std::sqrt(size / std::numbers::pi) / scale) : profile.at(distance / scale);
      const double factor = other == own ? 1 : size / (scale * scale);
      for (std::size_t c = 0; c < 3; ++c) out[own][c] += factor * share[c] * irradiance[other][c];
    };
    for (std::size_t k = at; k < order.size() && all[order[k]].middle.x - all[own].middle.x < reach; ++k) add(order[k]);
    for (std::size_t k = at; k > 0 && all[own].middle.x - all[order[k - 1]].middle.x < reach; --k) add(order[k - 1]);
  });
  return out;
}

SubsurfacePicture::SubsurfacePicture(const Medium& medium, const Lights& lights, std::vector<PolygonSurface> surfaces,
                                     const Profile& profile, std::size_t with_profile, double scale, int lamp_rays,
                                     std::uint64_t seed)
    : medium_(medium), lights_(lights), surfaces_(std::move(surfaces)), caster_(meshes_of(surfaces_)), seed_(seed) {
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    const PolygonSurface& surface = surfaces_[s];
    irradiance_.push_back(lit(s, lamp_rays));
    std::vector<Rgb> radiosity = irradiance_.back();
    if (s == with_profile) {
      radiosity = spread_beneath(surface.mesh, irradiance_.back(), profile, scale);
    } else {
      for (Rgb& one : radiosity) {
        for (std::size_t c = 0; c < 3; ++c) one[c] *= surface.albedo[c];
      }
    }
    radiosity_.push_back(corner_means(surface.mesh, radiosity));
  }
}

Irradiance SubsurfacePicture::lit(std::size_t surface, int lamp_rays) const {
  const std::vector<Facet> all = facets(surfaces_[surface].mesh);
  Irradiance out(all.size());
  parallel_for(all.size(), 0, [&](std::size_t t) {
    PathRandom random(seed_ + surface, t);
    for (int i = 0; i < lamp_rays; ++i) {
      const LightPoint point = lights_.point(random);
      const bool distant = lights_.is_distant(point.light);
      const Vec3 way = distant ? 4 * medium_.radius() * point.place : point.place - all[t].middle;
      const double cosine = dot(all[t].area, way) / (length(all[t].area) * length(way));
      if (!(cosine > 0)) continue;
      const double clear = distant ? std::numeric_limits<double>::infinity() : length(way);
      if (caster_.blocked(all[t].middle, normalise(way), clear)) continue;
      const Rgb power = lights_.emitted(point, -1.0 * normalise(way));
      for (std::size_t c = 0; c < 3; ++c) out[t][c] += power[c] * cosine / (distant ? 1 : dot(way, way)) / lamp_rays;
    }
  });
  return out;
}

RadiancePicture SubsurfacePicture::picture(const View& view, int rays) const {
  const Eye eye(view, medium_);
  RadianceSum sum(view.width, view.height);
  for (int ray = 0; ray < rays; ++ray) {
    std::vector<Rgb> pixels(sum.pixels());
    parallel_for(pixels.size(), 0, [&](std::size_t i) {
      const Vec3 direction = eye.direction(i, ray, seed_);
      std::vector<Crossing> crossings;
      caster_.find(eye.place(), direction, crossings);
      if (crossings.empty()) return;
      const Crossing& met = crossings.front();
      pixels[i] = between_corners(surfaces_[met.mesh].mesh, met.triangle, radiosity_[met.mesh][met.triangle],
                                  eye.place() + met.distance * direction);
      for (double& part : pixels[i]) part /= std::numbers::pi;
    });
    sum.add(pixels);
  }
  return sum.picture();
}

}  // namespace gicube::samples
