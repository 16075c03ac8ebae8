#include "polygon_gi/polygon_gi.h"

#include <algorithm>
#include <cmath>

#include "gicube/scene/error.h"
#include "meshes/triangulate.h"

namespace gicube::samples {
PolygonGi::PolygonGi(Board& board, const Medium& medium, std::vector<PolygonSurface> surfaces,
                     const PolygonGiSettings& settings)
    : medium_(medium),
      surfaces_(std::move(surfaces)),
      settings_(settings),
      flights_(board, medium, settings.step, settings.seed),
      caster_(meshes_of(surfaces_)),
      zones_(medium, settings.zone) {
  for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
    first_.push_back(static_cast<std::uint32_t>(elements_.size()));
    const bool closed = is_closed(surfaces_[s].mesh);
    for (std::uint32_t t = 0; t < surfaces_[s].mesh.triangles.size(); ++t) {
      for (const bool back : {false, true}) {
        GiElement side{s, t, back, false, closed && back, 0, surfaces_[s].albedo, back ? Rgb{} : surfaces_[s].emission};
        side.weight = length(area_of(surfaces_[s].mesh, t));
        elements_.push_back(side);
        if (const double power = side.weight * std::ranges::max(side.emission); power > 0) {
          lamps_.push_back(static_cast<std::uint32_t>(elements_.size() - 1));
          chances_.push_back(power + (chances_.empty() ? 0 : chances_.back()));
        }
      }
    }
  }
  statistics_.sides = elements_.size();
  add_zones();
  statistics_.zones = elements_.size() - statistics_.sides;
  rows_.resize(elements_.size());
  for (const GiElement& element : elements_) radiosity_.push_back(element.emission);
  incident_.resize(elements_.size());
}

void PolygonGi::check(Vec3 place) const {
  const int tag = medium_.tag(place);
  const std::string name = "material of tag " + std::to_string(tag);
  if (medium_.solid(place)) throw InputError(name + ".bsdf", "none or isotropic within the volume", "a solid's");
  const double g = medium_.optics(tag).g;
  if (g != 0) throw InputError(name + ".parameter", "0: media scatter evenly here", std::to_string(g));
}

// A zone's extinction and albedo are means of its voxels' eighths.
void PolygonGi::add_zones() {
  const double eighth =
      std::abs(dot(medium_.place_of({1, 0, 0}), cross(medium_.place_of({0, 1, 0}), medium_.place_of({0, 0, 1})))) / 8;
  for (std::size_t i = 0; i < zones_.count(); ++i) {
    GiElement zone{.triangle = static_cast<std::uint32_t>(i), .zone = true};
    zones_.sample(i, [&](Vec3 place) {
      check(place);
      const double weight = 4 * medium_.extinction(place) * eighth;
      zone.weight += weight;
      const Rgb& albedo = medium_.optics(medium_.tag(place)).albedo;
      for (std::size_t c = 0; c < 3; ++c) zone.albedo[c] += albedo[c] * weight;
    });
    zone_of_.push_back(zone.weight > 0 ? static_cast<std::uint32_t>(elements_.size()) : kNoElement);
    if (!(zone.weight > 0)) continue;
    for (double& part : zone.albedo) part /= zone.weight;
    elements_.push_back(zone);
  }
}

Vec3 PolygonGi::normal(const GiElement& element) const {
  const Vec3 area = area_of(surfaces_[element.surface].mesh, element.triangle);
  return length(area) > 0 ? (element.back ? -1.0 : 1.0) * normalise(area) : Vec3{0, 0, 1};
}

void PolygonGi::solve(const Progress& told) {
  constexpr std::size_t kRowsAtOnce = 4096;  // chosen: for progress
  std::vector<std::uint32_t> lit;
  for (std::uint32_t i = 0; i < elements_.size(); ++i) {
    if (!elements_[i].dark) lit.push_back(i);
  }
  for (std::size_t first = 0; first < lit.size(); first += kRowsAtOnce) {
    const auto now = std::span(lit).subspan(first, std::min(kRowsAtOnce, lit.size() - first));
    std::vector<Row> made = rows(now);
    for (std::size_t k = 0; k < now.size(); ++k) {
      elements_[now[k]].weight *= made[k].outside;
      rows_[now[k]] = std::move(made[k]);
    }
    if (told) told(static_cast<std::uint32_t>(first + now.size()), static_cast<std::uint32_t>(lit.size()));
  }
  iterate();
  account();
  spread();
}

void PolygonGi::iterate() {
  constexpr int kMaxIterations = 1000;
  for (statistics_.iterations = 0; statistics_.iterations < kMaxIterations;) {
    double change = 0, most = 0;
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      Rgb sum = rows_[i].direct;
      for (const auto& [element, share] : rows_[i].shares) {
        for (std::size_t c = 0; c < 3; ++c)
          sum[c] += static_cast<double>(share) * (radiosity_[element][c] - elements_[element].emission[c]);
      }
      incident_[i] = sum;
    }
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double now = elements_[i].emission[c] + elements_[i].albedo[c] * incident_[i][c];
        change = std::max(change, std::abs(now - radiosity_[i][c]));
        most = std::max(most, now);
        radiosity_[i][c] = now;
      }
    }
    ++statistics_.iterations;
    if (change <= settings_.convergence * most) return;
  }
}

void PolygonGi::account() {
  PolygonGiStatistics& s = statistics_;
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const GiElement& e = elements_[i];
    double kept = 0;
    if (e.dark) continue;
    for (const auto& [element, share] : rows_[i].shares) kept += static_cast<double>(share);
    for (std::size_t c = 0; c < 3; ++c) {
      s.emitted[c] += e.weight * e.emission[c];
      (e.zone ? s.absorbed_by_medium : s.absorbed_by_surfaces)[c] += e.weight * (1 - e.albedo[c]) * incident_[i][c];
      s.escaped[c] += e.weight * radiosity_[i][c] * (1 - kept);
    }
  }
}

}  // namespace gicube::samples
