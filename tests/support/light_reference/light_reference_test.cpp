#include <gtest/gtest.h>

#include <cmath>

#include "gicube/scene/error.h"
#include "light_reference/path_scene_of.h"
#include "light_reference/tiles.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

TEST(LightReference, TellsHowSureTheMeansOfTilesAre) {
  reference::paths::RadiancePicture picture{3, 2, {}};
  picture.pixels.assign(6, {{{2, 0.1}, {0, 0}, {0, 0}}});
  EXPECT_NEAR(light_reference::relative_error(picture, 1), 0.05, 1e-12);
  // A tile of four pixels and one of two: (4 * 0.05^2 + 2 * 0.1^2 / 2) / (6 * 2^2).
  EXPECT_NEAR(light_reference::relative_error(picture, 2), std::sqrt((4 * 0.0025 + 2 * 0.005) / 24), 1e-12);
}

TEST(LightReference, HasSurfacesWhereTheOpacityIsHalfOfItsGreatest) {
  const Scene scene = parse_scene(
      "world { size: 16 node { material: \"ball\" sphere { radius: 0.6 } } node { material: \"air\" box { low { x: -2 "
      "y: -2 "
      "z: -2 } high { x: 2 y: 2 z: 2 } } } }"
      "material { name: \"ball\" solid { } bsdf: \"diffuse\" scattering: 0.5 scattering_colour { red: 1 green: 0.5 "
      "blue: 0 } }"
      "material { name: \"air\" fog { extinction: 1 } bsdf: \"isotropic\" scattering: 0.5 }",
      "ball", ".");
  SceneSetup setup = set_up(scene, 1);
  const auto paths = to_paths(setup);
  EXPECT_NEAR(paths.surfaces[0].value_or(0), 4095 / 2.0, 1e-9);
  EXPECT_FALSE(paths.surfaces[1]);
  EXPECT_EQ(paths.scattering_colours[0], (reference::paths::Rgb{1, 0.5, 0}));
  setup.materials[0].function.opacities = {{0, 0}, {1000, 0}, {2000, 0.4}, {4095, 0.4}};
  EXPECT_NEAR(to_paths(setup).surfaces[0].value_or(0), 1500, 1e-9);
  setup.materials[0].function.opacities = {{0, 0}, {4095, 0}};
  EXPECT_THROW(to_paths(setup), InputError);
}

}  // namespace
}  // namespace gicube::samples
