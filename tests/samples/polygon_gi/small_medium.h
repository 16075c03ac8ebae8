// A volume of even fog for polygons to stand in, in voxel edges.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "gicube/scene/scene.h"
#include "meshes/triangulate.h"
#include "polygon_gi/polygon_gi.h"
#include "transport/medium.h"

namespace gicube::samples {

// Extinction per voxel edge; 0: clear. `size` voxels across x and y, `height` or as many across z.
struct Fog {
  Fog(Board opened, double extinction, double albedo, int size = 33, int height = 33)
      : board(std::move(opened)),
        setup(set_up_of(extinction, albedo, size, std::min(size, height))),
        medium(board, setup) {}
  static SceneSetup set_up_of(double extinction, double albedo, int size, int height) {
    const std::string high = std::to_string(size - 1), where = extinction > 0 ? "-9" : "900";
    Scene scene =
        parse_scene("world { low { } high { x: " + high + " y: " + high + " z: " + std::to_string(height - 1) +
                        " } size: " + std::to_string(size) + " node { material: \"fog\" box { low { x: " + where +
                        " y: -9 z: -9 } high { x: 999 y: 999 z: 999 } } } }"
                        "material { name: \"fog\" fog { extinction: " +
                        std::to_string(extinction > 0 ? extinction : 1) + " } scattering: " + std::to_string(albedo) +
                        " bsdf: \"isotropic\" }",
                    "fog", ".");
    scene.lighting.on = true;
    return set_up(scene, 1);
  }
  Board board;
  SceneSetup setup;
  Medium medium;
};

// A parallelogram whose front is to the side of u x v.
inline PolygonSurface patch(Vec3 origin, Vec3 u, Vec3 v, double albedo = 0, double emission = 0) {
  PolygonSurface out;
  out.mesh = {{origin, origin + u, origin + u + v, origin + v}, {{0, 1, 2}, {0, 2, 3}}};
  out.albedo = {albedo, albedo, albedo};
  out.emission = {emission, emission, emission};
  return out;
}

// Of a surface's light the share that ends at another, by the rows of its fronts.
inline double factor(PolygonGi& light, std::uint32_t from, std::uint32_t to) {
  std::vector<std::uint32_t> fronts;
  double area = 0, sum = 0;
  const auto& elements = light.elements();
  for (std::uint32_t i = 0; i < elements.size(); ++i) {
    if (elements[i].zone || elements[i].back || elements[i].surface != from) continue;
    fronts.push_back(i);
    area += elements[i].weight;
  }
  const auto rows = light.rows(fronts);
  for (std::size_t k = 0; k < fronts.size(); ++k) {
    for (const auto& [element, share] : rows[k].shares) {
      if (elements[element].zone || elements[element].surface != to) continue;
      sum += elements[fronts[k]].weight / area * static_cast<double>(share);
    }
  }
  return sum;
}

// What arrives at the middle third of a black plate of what another sends out, through an optical depth of 1 that scatters all. The
// plates are `layers` voxels apart, 24 wide.
inline double plate_flux(Fog& filled, int layers, int zone, int rays) {
  const PolygonSurface low = patch({0, 0, 0}, {24, 0, 0}, {0, 24, 0}, 0, 1);
  PolygonSurface high = patch({0, 0, static_cast<double>(layers)}, {0, 24, 0}, {24, 0, 0});
  high.mesh = refined(high.mesh, 6);
  PolygonGi light(filled.board, filled.medium, {low, high}, {.rays = rays, .zone = zone});
  light.solve();
  double sum = 0, area = 0;
  for (std::size_t i = 0; i < light.elements().size(); ++i) {
    const GiElement& element = light.elements()[i];
    if (element.zone || element.surface != 1 || element.back) continue;
    const auto& [a, b, c] = high.mesh.triangles[element.triangle];
    const Vec3 middle = 1.0 / 3 * (high.mesh.points[a] + high.mesh.points[b] + high.mesh.points[c]);
    if (std::abs(middle.x - 12) > 4 || std::abs(middle.y - 12) > 4) continue;
    sum += element.weight * light.incident()[i][0];
    area += element.weight;
  }
  return sum / area;
}

// The same by random walks in the even box between them, with its standard error: no zones, no board.
inline std::pair<double, double> plate_truth(int layers, int walks) {
  PathRandom random(9, 0);
  int arrived = 0;
  for (int i = 0; i < walks; ++i) {
    Vec3 at{8 + 8 * random.uniform(), 8 + 8 * random.uniform(), static_cast<double>(layers)};
    Vec3 along = normalise(random.direction() + Vec3{0, 0, -1});  // Lambert's law
    const auto inside = [&] { return at.x > 0 && at.x < 24 && at.y > 0 && at.y < 24 && at.z > 0 && at.z < layers; };
    do {
      const Vec3 before = at;
      at = at - layers * std::log(1 - random.uniform()) * along;
      if (at.z <= 0) {
        const Vec3 met = before + before.z / (before.z - at.z) * (at - before);
        arrived += met.x > 0 && met.x < 24 && met.y > 0 && met.y < 24 ? 1 : 0;
      }
      along = random.direction();
    } while (inside());
  }
  const double share = static_cast<double>(arrived) / walks;
  return {share, std::sqrt(share * (1 - share) / walks)};
}

}  // namespace gicube::samples
