#include "polygon_gi/polygon_gi.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "meshes/triangulate.h"

namespace gicube::samples {
// The ray'th of a row's.
Flight PolygonGi::start(const GiElement& element, int ray, const std::array<double, 2>& shift,
                        PathRandom& random) const {
  const int along = static_cast<int>(std::sqrt(settings_.rays));
  const int strata = ray < along * along ? along : 1, cell = ray % (strata * strata);  // those of no square: anywhere
  const double u = (cell % strata + random.uniform()) / strata, v = (cell / strata + random.uniform()) / strata;
  if (!element.zone) {
    const auto [a, b, c] = corners_of(surfaces_[element.surface].mesh, element.triangle);
    auto [s, t] = spread_point(ray, shift);
    if (s + t > 1) s = 1 - s, t = 1 - t;
    const double ring = std::sqrt(u), turn = 2 * std::numbers::pi * v;
    return {a + s * (b - a) + t * (c - a),
            turned({ring * std::cos(turn), ring * std::sin(turn), std::sqrt(1 - u)}, normal(element))};
  }
  const double z = 1 - 2 * u, ring = std::sqrt(std::max(0.0, 1 - z * z)), turn = 2 * std::numbers::pi * v;
  return {zones_.place(element.triangle, random), {ring * std::cos(turn), ring * std::sin(turn), z}};
}

std::vector<PolygonGi::End> PolygonGi::ends(std::span<const Flight> flights) {
  const std::vector<std::optional<Hit>> hits = flights_.first_hits(flights);
  std::vector<End> out(flights.size());
  std::vector<Crossing> crossings;
  const auto side = [&](const Crossing& met) {
    return first_[met.mesh] + 2 * met.triangle + (met.from_outside ? 0 : 1);
  };
  for (std::size_t i = 0; i < flights.size(); ++i) {
    caster_.ahead(flights[i].place, flights[i].direction, crossings);
    if (hits[i] && (crossings.empty() || hits[i]->distance < crossings.front().distance)) {
      const std::uint32_t zone = zone_of_[zones_.at(hits[i]->place)];
      out[i] = {zone == kNoElement ? std::nullopt : std::optional(zone), hits[i]->place};
    } else if (!crossings.empty()) {
      const Crossing& met = crossings.front();
      out[i] = {side(met), flights[i].place + met.distance * flights[i].direction};
    }
    // Solids may overlap, so the ray may leave its own behind the nearest crossing.
    for (auto met = crossings.begin(); met != crossings.end() && !out[i].in_solid; ++met) {
      out[i].in_solid =
          elements_[side(*met)].dark && std::ranges::find(crossings.begin(), met, met->mesh, &Crossing::mesh) == met;
    }
  }
  return out;
}

double PolygonGi::density(const GiElement& element, Vec3 direction) const {
  return element.zone ? 1 / (4 * std::numbers::pi) : std::max(0.0, dot(normal(element), direction)) / std::numbers::pi;
}

// `weights`: of flights, 1 in the mean of a row.
void PolygonGi::add_direct(std::span<const std::uint32_t> of, std::span<const Flight> flights,
                           std::span<const End> ends, std::span<const double> weights, std::span<Row> rows) {
  const auto rays = static_cast<std::size_t>(settings_.rays), to_lamps = static_cast<std::size_t>(settings_.lamp_rays);
  // Over the sum of the densities of all ways to find it.
  const auto share = [&](const GiElement& from, const GiElement& lamp, Vec3 direction, double squared) {
    const double by_ray = density(from, direction), facing = -dot(normal(lamp), direction);
    if (!(facing > 0) || !(by_ray > 0)) return 0.0;
    return by_ray / (settings_.rays * by_ray +
                     settings_.lamp_rays * std::ranges::max(lamp.emission) / chances_.back() * squared / facing);
  };
  const auto add = [](Rgb& to, const Rgb& emission, double factor) {
    for (std::size_t c = 0; c < 3; ++c) to[c] += factor * emission[c];
  };
  std::vector<Segment> segments;
  std::vector<std::tuple<std::size_t, std::uint32_t, double>> found;  // row, lamp, value
  for (std::size_t k = 0; k < of.size(); ++k) {
    const GiElement& own = elements_[of[k]];
    PathRandom random(settings_.seed ^ 0x1A3B, of[k]);
    for (std::size_t i = k * rays; i < (k + 1) * rays; ++i) {
      if (!ends[i].element || elements_[*ends[i].element].zone) continue;
      const GiElement& lamp = elements_[*ends[i].element];
      const Vec3 way = ends[i].place - flights[i].place;
      if (std::ranges::max(lamp.emission) > 0)
        add(rows[k].direct, lamp.emission, weights[i] * share(own, lamp, flights[i].direction, dot(way, way)));
    }
    if (lamps_.empty()) continue;
    for (std::size_t j = 0; j < to_lamps; ++j) {
      const std::size_t i = k * rays + j * rays / to_lamps;
      const double chance = chances_.back() * (static_cast<double>(j) + random.uniform()) / settings_.lamp_rays;
      const auto which = std::ranges::upper_bound(chances_, chance) - chances_.begin();
      const std::uint32_t lamp = lamps_[std::min(static_cast<std::size_t>(which), lamps_.size() - 1)];
      double s = random.uniform(), t = random.uniform();
      if (s + t > 1) s = 1 - s, t = 1 - t;
      const auto [a, b, c] = corners_of(surfaces_[elements_[lamp].surface].mesh, elements_[lamp].triangle);
      const Vec3 place = a + s * (b - a) + t * (c - a), way = place - flights[i].place;
      const double value =
          dot(way, way) > 0 ? weights[i] * share(own, elements_[lamp], normalise(way), dot(way, way)) : 0;
      if (!(value > 0) || caster_.blocked(flights[i].place, normalise(way), length(way))) continue;
      segments.push_back({flights[i].place, place});
      found.emplace_back(k, lamp, value);
    }
  }
  const std::vector<double> through = flights_.transmittances(segments);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto& [row, lamp, value] = found[i];
    add(rows[row].direct, elements_[lamp].emission, value * through[i]);
  }
}

std::vector<PolygonGi::Row> PolygonGi::rows(std::span<const std::uint32_t> of) {
  std::vector<Row> out(of.size());
  const auto rays = static_cast<std::size_t>(settings_.rays);
  const std::size_t at_once = std::max<std::size_t>(1, kFlightsAtOnce / rays);
  for (std::size_t first = 0; first < of.size(); first += at_once) {
    const std::size_t count = std::min(at_once, of.size() - first);
    std::vector<Flight> flights;
    for (std::size_t k = first; k < first + count; ++k) {
      PathRandom random(settings_.seed, of[k]);
      const std::array<double, 2> shift{random.uniform(), random.uniform()};
      for (int ray = 0; ray < settings_.rays; ++ray) flights.push_back(start(elements_[of[k]], ray, shift, random));
    }
    const std::vector<End> all = ends(flights);
    std::vector<double> weights(flights.size());
    for (std::size_t k = 0; k < count; ++k) {
      Row& row = out[first + k];
      double sum = 0, in_solid = 0;
      for (std::size_t i = k * rays; i < (k + 1) * rays; ++i) {
        const double kappa = elements_[of[first + k]].zone ? medium_.extinction(flights[i].place) : 1;
        weights[i] = all[i].in_solid ? 0 : kappa;
        sum += weights[i];
        in_solid += kappa - weights[i];
      }
      row.outside = sum > 0 ? sum / (sum + in_solid) : 0;
      for (std::size_t i = k * rays; i < (k + 1) * rays; ++i) {
        weights[i] *= sum > 0 ? static_cast<double>(rays) / sum : 0;
        if (all[i].element) row.shares.emplace_back(*all[i].element, static_cast<float>(weights[i] / settings_.rays));
      }
      std::ranges::sort(row.shares);
      std::size_t kept = 0;
      for (std::size_t i = 1; i < row.shares.size(); ++i) {
        if (row.shares[i].first == row.shares[kept].first)
          row.shares[kept].second += row.shares[i].second;
        else
          row.shares[++kept] = row.shares[i];
      }
      if (!row.shares.empty()) row.shares.resize(kept + 1);
    }
    add_direct(of.subspan(first, count), flights, all, weights, std::span(out).subspan(first, count));
  }
  statistics_.rays = flights_.rays();
  return out;
}

}  // namespace gicube::samples
