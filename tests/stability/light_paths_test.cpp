// Paths of light: lamps within media, light that mirrors and glass alone bring, and the blur of photon densities.
#include "../samples/apps/light/path/light_scenes.h"
#include "light/path/bidirectional.h"
#include "light/photon_map/photon_map.h"
#include "stability.h"
#include "test.h"

namespace gicube::stability {
namespace {

using samples::Rgb;

struct Seen {
  double mean = 0, brightest = 0;
  double noise = 0;  // root mean square of the pixels' standard errors over the mean
};

Seen seen_of(const samples::RadiancePicture& picture) {
  Seen out;
  double squares = 0;
  const auto n = static_cast<double>(picture.mean.size());
  for (std::size_t i = 0; i < picture.mean.size(); ++i) {
    out.mean += picture.mean[i][0] / n;
    out.brightest = std::max(out.brightest, picture.mean[i][0]);
    squares += picture.error[i][0] * picture.error[i][0] / n;
  }
  out.noise = std::sqrt(squares) / out.mean;
  return out;
}

struct Traced {
  explicit Traced(const std::string& text)
      : setup(samples::setup_of({"scene", text})),
        board(Board::open("emu:")),
        medium(board, setup),
        lights(setup, medium) {}
  samples::SceneSetup setup;
  Board board;
  samples::Medium medium;
  samples::Lights lights;

  Seen by_paths(int light_scatterings, int passes) {
    samples::Bidirectional paths(board, medium, lights, setup.view,
                                 {.light_scatterings = light_scatterings, .max_scatterings = 16});
    for (int i = 0; i < passes; ++i) paths.pass();
    return seen_of(paths.picture());
  }
  Seen by_photons(int neighbours, int passes) {
    samples::PhotonMapping photons(board, medium, lights, setup.view,
                                   {.photons = 30000, .neighbours = neighbours, .radius = 30});
    for (int i = 0; i < passes; ++i) photons.pass();
    return seen_of(photons.picture());
  }
};

// A connection is worth 1 / r^2, and places at r from the lamp are as many as r^2: the variance of 1 / r^2 has no
// bound.
TEST(StabilityOfPathTracing, ALampWithinFogNeedsPathsFromTheLamp) {
  Traced fog(
      "world { size: 16 node { material: \"fog\" box { low { x: -3 y: -3 z: -3 } high { x: 3 y: 3 z: 3 } } } }"
      "material { name: \"fog\" fog { extinction: 2 } scattering: 0.9 bsdf: \"isotropic\" }"
      "light { point { position { } } power: 10 }" +
      samples::kView);
  const Seen eye_alone = fog.by_paths(0, 8), both = fog.by_paths(3, 8);
  record("noise_of_eye_paths", eye_alone.noise);
  record("noise_of_both", both.noise);
  EXPECT_GT(eye_alone.noise, 2 * both.noise);
}

// Light of a point lamp, through glass, onto a wall, and through glass to the eye: no way to make such a path can be
// sampled. The same lamp with an area is met by chance.
TEST(StabilityOfPathTracing, APointLampThroughGlassIsNotSeenThroughGlass) {
  const auto room = [](const std::string& lamp) {
    return "world { size: 24 node { material: \"glass\" box { low { x: -0.9 y: -0.7 z: -0.9 } high { x: 0.9 y: -0.3 z: "
           "0.9 } } }"
           "node { material: \"white\" box { low { x: -3 y: 0.5 z: -3 } high { x: 3 y: 3 z: 3 } } } }" +
           samples::kWalls +
           "material { name: \"glass\" solid { } scattering: 1 bsdf: \"trap\" routine: \"fresnel\" surface: true }"
           "light { " +
           lamp +
           " power: 30 }"
           "camera { eye { y: -3 } look_at { } fov_degrees: 8 } image { width: 16 height: 16 }";
  };
  const Seen point = Traced(room("point { position { y: -2.5 z: 0.4 } }")).by_paths(3, 6);
  const Seen sphere = Traced(room("sphere { centre { y: -2.5 z: 0.4 } radius: 0.3 }")).by_paths(3, 40);
  record("of_a_point", point.mean / sphere.mean);
  EXPECT_LT(point.mean, 0.01 * sphere.mean);
  EXPECT_GT(sphere.mean, 0);
}

// A caustic under glass: more neighbours make it darker where it is brightest, and leave the light in all.
TEST(StabilityOfPhotonMaps, NeighboursBlurACausticAndKeepItsLight) {
  std::string text = samples::glass_scene().text;
  const std::size_t lamp = text.find("sphere { centre");
  text.replace(lamp, text.find("} power", lamp) + 1 - lamp, "point { position { x: 0.2 y: -0.3 z: 1.8 } }");
  Traced glass(text);
  const Seen sharp = glass.by_photons(20, 3), soft = glass.by_photons(1500, 3);
  record("brightest", soft.brightest / sharp.brightest);
  record("light", soft.mean / sharp.mean);
  record("noise", soft.noise / sharp.noise);
  EXPECT_LT(soft.brightest, 0.7 * sharp.brightest);
  EXPECT_NEAR(soft.mean, sharp.mean, 0.15 * sharp.mean);
  EXPECT_LT(soft.noise, sharp.noise);
}

TEST(StabilityOfPhotonMaps, AtAFaceOfAMediumADensityIsHalf) {
  samples::PathRandom random(3, 0);
  std::vector<samples::Photon> photons;
  for (int i = 0; i < 20000; ++i) {  // 20 in a unit of volume, x from 0 to 10
    photons.push_back({{10 * random.uniform(), 10 * random.uniform(), 10 * random.uniform()}, {}, {1, 1, 1}});
  }
  const samples::PhotonTree tree(photons);
  const auto density = [&](double x) {
    double sum = 0;
    for (int i = 0; i < 400; ++i) {
      const auto near = tree.nearest({x, 2 + 6 * random.uniform(), 2 + 6 * random.uniform()}, 40, 2);
      sum += static_cast<double>(near.photons.size()) / (4.0 / 3 * std::numbers::pi * std::pow(near.radius, 3)) / 400;
    }
    return sum;
  };
  record("at_the_face", density(0) / 20);
  EXPECT_NEAR(density(0), 10, 1.5);  // one cloud: 3% is chance
  EXPECT_NEAR(density(5), 20, 3);
}

}  // namespace
}  // namespace gicube::stability
