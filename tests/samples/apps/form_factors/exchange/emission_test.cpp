// The power that elements send out against that of the scene's shapes: emission times their area, or volume, in
// closed form.
#include "form_factors/exchange/elements.h"
#include "form_factors/program/options.h"
#include "gicube/scene/scene.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kEmission = 2;

double power_of(Scene scene, int size) {
  scene.world->size = size;
  scene.lighting.on = false;
  const SceneSetup setup = set_up(scene);
  double sum = 0;
  for (const Leaf& leaf : make_leaves(make_medium(setup, 0.5), setup, emissions_of(setup))) {
    sum += leaf.weight * leaf.emission[0];
  }
  return sum * setup.grid.voxel * setup.grid.voxel;
}

// `shape`: what follows material in a node.
Scene lamp(const std::string& shape, double fog, const std::string& look = "solid { }") {
  std::string world = "node { material: \"lamp\" " + shape + " }";
  std::string more;
  if (fog > 0) {
    world += "node { material: \"fog\" box { low { x: -3 y: -3 z: -3 } high { x: 3 y: 3 z: 3 } } }";
    more = "material { name: \"fog\" fog { extinction: " + std::to_string(fog) +
           " } scattering: 0.5 bsdf: \"isotropic\" }";
  }
  return parse_scene("world {" + world + "} material { name: \"lamp\" " + look + " emission: 2 } " + more +
                         "camera { eye { y: -3 } look_at { } }",
                     "lamp", ".");
}

constexpr const char* kBox = "box { low { x: -0.35 y: -0.25 z: -0.15 } high { x: 0.35 y: 0.25 z: 0.15 } }";

TEST(Emission, OfABoxIsItsAreaTimesItsEmissionWithAndWithoutFog) {
  constexpr double kArea = 2 * (0.7 * 0.5 + 0.5 * 0.3 + 0.3 * 0.7);
  for (const double fog : {0.0, 0.01, 2.0}) {
    for (const int size : {21, 26, 31, 36, 41, 51, 61}) {
      EXPECT_NEAR(power_of(lamp(kBox, fog), size) / (kEmission * kArea), 1, 0.015) << size << " voxels, fog " << fog;
    }
  }
}

TEST(Emission, OfCurvedAndTurnedSolidsConvergesWithTheResolution) {
  struct Solid {
    const char* shape;
    double area, coarse, fine;  // bounds of the error at 21 and at 81 voxels
  };
  const std::string turned = std::string("transform { rotate { axis { x: 1 y: 2 z: 3 } degrees: 37 } } ") + kBox;
  const Solid solids[] = {
      {"sphere { radius: 0.35 }", 4 * kPi * 0.35 * 0.35, 0.01, 0.002},
      {"transform { rotate { axis { x: 1 y: 1 } degrees: 30 } } torus { radius: 0.6 tube: 0.2 }",
       4 * kPi * kPi * 0.6 * 0.2, 0.03, 0.003},
      {turned.c_str(), 1.42, 0.045, 0.015},
  };
  for (const Solid& solid : solids) {
    for (const double fog : {0.0, 0.25}) {
      EXPECT_NEAR(power_of(lamp(solid.shape, fog), 21) / (kEmission * solid.area), 1, solid.coarse) << solid.shape;
      EXPECT_NEAR(power_of(lamp(solid.shape, fog), 81) / (kEmission * solid.area), 1, solid.fine) << solid.shape;
    }
  }
}

// Its lamp is a ball of 0.14, which is 2 voxels at 32.
TEST(Emission, OfTheGlowingRoomIsThatOfItsBall) {
  const Scene room = read_scene(GICUBE_SOURCE_DIR "/samples/scenes/radiosity/glowing_room.scene");
  for (const int size : {32, 48, 64}) {
    EXPECT_NEAR(power_of(room, size) / (20 * 4 * kPi * 0.14 * 0.14), 1, 0.03) << size;
  }
}

// Inside a solid shape of fog that is as dense as the lamp, no step of density says where the lamp's surface lies.
TEST(Emission, OfALampWithinSomethingAsDenseIsItsAreaTimesItsEmission) {
  const Scene scene = parse_scene(
      "world { low { x: -1 y: -1 z: -1 } high { x: 1 y: 1 z: 1 }"
      " node { material: \"wax\" sphere { radius: 0.8 } } node { material: \"lamp\" sphere { radius: 0.3 } } }"
      " material { name: \"wax\" transfer_function { colour { value: 0 colour { red: 1 green: 1 blue: 1 } }"
      " opacity { value: 1200 opacity: 0 } opacity { value: 2800 opacity: 0.3 } } scattering: 0.9 bsdf: \"isotropic\" }"
      " material { name: \"lamp\" solid { } emission: 2 } camera { eye { y: -3 } look_at { } }",
      "lamp", ".");
  for (const int size : {21, 41, 81}) {
    const double bound = size == 21 ? 0.11 : 0.04;  // at 21 its radius is three voxels
    EXPECT_NEAR(power_of(scene, size) / (kEmission * 4 * kPi * 0.3 * 0.3), 1, bound) << size << " voxels";
  }
}

TEST(Emission, OfTheLanternIsThatOfItsBall) {
  const Scene lantern = read_scene(GICUBE_SOURCE_DIR "/samples/scenes/radiosity/lantern.scene");
  for (const int size : {48, 64, 96}) {
    EXPECT_NEAR(power_of(lantern, size) / (30 * 4 * kPi * 0.13 * 0.13), 1, 0.04) << size;
  }
}

// Its ramp has more volume at edges and corners: of 7 x 5 x 3 voxels 20% more, of twice as many along each edge 3.4%.
TEST(Emission, OfAFogIsItsVolumeTimesItsEmission) {
  for (const int size : {21, 41}) {
    const double power = power_of(lamp(kBox, 0, "fog { extinction: 0.5 }"), size);
    EXPECT_NEAR(power / (kEmission * 0.7 * 0.5 * 0.3), 1, size == 21 ? 0.21 : 0.04) << size;
  }
}

}  // namespace
}  // namespace gicube::samples
