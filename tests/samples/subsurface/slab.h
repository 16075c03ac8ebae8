// A slab of an even medium, and what random walks without a board say of it.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "gicube/scene/scene.h"
#include "subsurface/profile.h"

namespace gicube::samples {

// 49 voxels across x and y, `deep` across z; extinction per voxel edge.
struct Slab {
  Slab(Board opened, double extinction, double albedo, double g, int deep)
      : board(std::move(opened)), setup(set_up_of(extinction, albedo, g, deep)), medium(board, setup) {}
  static SceneSetup set_up_of(double extinction, double albedo, double g, int deep) {
    Scene scene =
        parse_scene("world { low { } high { x: 48 y: 48 z: " + std::to_string(deep - 1) +
                        " } size: 49 node { material: \"fog\" box { low { x: -9 y: -9 z: -9 } high { x: 99 y: "
                        "99 z: 99 } } } } material { name: \"fog\" fog { extinction: " +
                        std::to_string(extinction) + " } scattering: " + std::to_string(albedo) +
                        " scattering_colour { green: 0.9 blue: 0.5 } bsdf: \"trap\" routine: "
                        "\"henyey_greenstein\" parameter: " +
                        std::to_string(g) + " }",
                    "slab", ".");
    return set_up(scene, 1);
  }
  Board board;
  SceneSetup setup;
  Medium medium;
};

// Chandrasekhar's H function of isotropic scattering, by iteration (Radiative Transfer, 1950, chapter V). Of light that falls straight on a half
// space 1 - H(1) sqrt(1 - albedo) comes back.
inline double half_space_albedo(double albedo) {
  constexpr int kPoints = 400;
  std::vector<double> h(kPoints, 1);
  const auto place = [](int i) { return (i + 0.5) / kPoints; };
  const auto at = [&](double mu) {
    double integral = 0;
    for (int i = 0; i < kPoints; ++i) integral += place(i) * h[static_cast<std::size_t>(i)] / (mu + place(i));
    return 1 / (std::sqrt(1 - albedo) + albedo / 2 * integral / kPoints);
  };
  for (int round = 0; round < 300; ++round) {
    std::vector<double> next(kPoints);
    for (int i = 0; i < kPoints; ++i) next[static_cast<std::size_t>(i)] = at(place(i));
    h = next;
  }
  return 1 - at(1) * std::sqrt(1 - albedo);
}

// What of light that falls straight on an even half space of isotropic scattering comes out nearer than each radius, in mean free paths.
inline std::vector<double> half_space_within(double albedo, const std::vector<double>& radii, int walks) {
  PathRandom random(3, 0);
  std::vector<double> out(radii.size());
  for (int i = 0; i < walks; ++i) {
    Vec3 at{}, along{0, 0, -1};
    double weight = 1;
    while (true) {
      const Vec3 next = at - std::log(1 - random.uniform()) * along;
      if (next.z >= 0) {
        const Vec3 met = at + at.z / (at.z - next.z) * (next - at);
        for (std::size_t k = 0; k < radii.size(); ++k) out[k] += length(met) < radii[k] ? weight / walks : 0;
        break;
      }
      at = next;
      weight *= albedo;
      if (weight < 0.1) {
        if (random.uniform() < 0.5) break;
        weight *= 2;
      }
      along = random.direction();
    }
  }
  return out;
}

}  // namespace gicube::samples
