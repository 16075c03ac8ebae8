// Paths at surfaces against closed forms: a furnace, a wall in a lamp's light, a mirror's light on a wall.
#include "../../../../driver/board/test_board.h"
#include "light/path/bidirectional.h"
#include "light_scenes.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr double kPi = std::numbers::pi;

// One unit is a voxel.
const std::string kWorld = "world { low { } high { x: 23 y: 23 z: 23 } size: 24 ";
const std::string kMaterials = R"(
  material { name: "wall" solid { } scattering: 0.5 bsdf: "diffuse" }
  material { name: "white" solid { } scattering: 1 bsdf: "diffuse" }
  material { name: "mirror" solid { } scattering: 0.5 bsdf: "specular" }
  material { name: "fog" fog { extinction: 0.1 } scattering: 1 bsdf: "isotropic" } )";
const Vec3 kEye{11.5, -20, 14};

std::string camera(Vec3 look_at, double degrees) {
  const auto place = [](Vec3 p) {
    return "{ x: " + std::to_string(p.x) + " y: " + std::to_string(p.y) + " z: " + std::to_string(p.z) + " }";
  };
  return "camera { eye " + place(kEye) + " look_at " + place(look_at) +
         " up { z: 1 } fov_degrees: " + std::to_string(degrees) + " } image { width: 24 height: 24 }";
}

struct Shown {
  double mean = 0, error = 0;
};

// The mean of the whole picture.
Shown shown(const SceneSetup& setup, int light_scatterings, int max_scatterings, int passes) {
  Board board = Board::open("emu:");
  const Medium medium(board, setup);
  const Lights lights(setup, medium);
  Bidirectional paths(board, medium, lights, setup.view,
                      {.light_scatterings = light_scatterings, .max_scatterings = max_scatterings, .seed = 5});
  Shown out;
  for (int i = 0; i < passes; ++i) paths.pass();
  const RadiancePicture picture = paths.picture();
  const auto n = static_cast<double>(picture.mean.size());
  for (std::size_t i = 0; i < picture.mean.size(); ++i) {
    out.mean += picture.mean[i][0] / n;
    out.error += std::pow(picture.error[i][0] / n, 2);
  }
  out.error = std::sqrt(out.error);
  return out;
}

// Six lamps of radiance 1 inwards, far round the volume.
Shown in_furnace(const std::string& nodes, Vec3 look_at, int passes) {
  SceneSetup setup = setup_of({"furnace", kWorld + nodes + "}" + kMaterials + camera(look_at, 6)});
  const double low = -60, high = 83, e = high - low;
  for (const auto& [corner, u, v] : {std::array<Vec3, 3>{Vec3{low, low, low}, {e, 0, 0}, {0, e, 0}},
                                     {Vec3{low, low, high}, {0, e, 0}, {e, 0, 0}},
                                     {Vec3{low, low, low}, {0, e, 0}, {0, 0, e}},
                                     {Vec3{high, low, low}, {0, 0, e}, {0, e, 0}},
                                     {Vec3{low, low, low}, {0, 0, e}, {e, 0, 0}},
                                     {Vec3{low, high, low}, {e, 0, 0}, {0, 0, e}}}) {
    setup.lights.push_back(RectangleLight{corner, u, v, kPi * e * e});
    setup.light_colours.push_back({1, 1, 1});
  }
  return shown(setup, 0, 200, passes);
}

std::string wall(const char* material, double turn) {
  return "node { material: \"" + std::string(material) +
         "\" transform { rotate { axis { x: 0.3 z: 1 } degrees: " + std::to_string(turn) +
         " } } transform { translate { x: 11.5 y: 14 z: 11.5 } } " +
         "box { low { x: -60 z: -60 } high { x: 60 y: 60 z: 60 } } }";
}
std::string ball(const char* material) {
  return "node { material: \"" + std::string(material) +
         "\" transform { translate { x: 11.5 y: 12 z: 11.5 } } sphere { radius: 6 } }";
}

// What is convex sends no light to itself: it shows its albedo. A path that met its own surface again would lose some,
// one that came into the solid all.
TEST(Furnace, ShowsTheAlbedoOfWhatIsConvex) {
  for (const std::string& nodes : {wall("wall", 0), wall("wall", 23), ball("wall")}) {
    const Shown found = in_furnace(nodes, {11.5, 12, 11.5}, 60);
    EXPECT_NEAR(found.mean, 0.5, 3 * found.error) << nodes;
    EXPECT_LT(found.error, 0.001) << nodes;
  }
  const Shown mirror = in_furnace(ball("mirror"), {11.5, 12, 11.5}, 3);
  EXPECT_NEAR(mirror.mean, 0.5, 1e-6);
}

// In corners and at edges too, however often light goes to and fro.
TEST(Furnace, ShowsNothingOfWhatAbsorbsNothing) {
  const std::string room =
      "node { material: \"white\" box { low { x: -3 y: -3 z: -3 } high { x: 6 y: 26 z: 26 } } }"
      "node { material: \"white\" box { low { x: -3 y: -3 z: -3 } high { x: 26 y: 26 z: 7 } } }"
      "node { material: \"white\" box { low { x: -3 y: 15 z: -3 } high { x: 26 y: 26 z: 26 } } }"
      "node { material: \"white\" transform { translate { x: 11 y: 11 z: 9 } } sphere { radius: 4 } }";
  const std::string fog = "node { material: \"fog\" box { low { x: -9 y: -9 z: -9 } high { x: 40 y: 40 z: 40 } } }";
  for (const std::string& nodes : {room, room + fog}) {
    const Shown found = in_furnace(nodes, {10, 13, 9}, 60);
    EXPECT_NEAR(found.mean, 1, 3 * found.error) << nodes;
    EXPECT_LT(found.error, 0.003) << nodes;
  }
}

// The picture's mean of a radiance at the wall y = 15, by quadrature.
double mean_on_wall(const SceneSetup& setup, const std::function<double(Vec3)>& radiance) {
  Board board = Board::open("emu:");
  const Medium medium(board, setup);
  const Eye eye(setup.view, medium);
  constexpr int kPlaces = 240;
  double sum = 0;
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    const Vec3 direction = eye.direction((i % kPlaces + 0.5) / 10, (i / kPlaces + 0.5) / 10);
    sum += radiance(kEye + (15 - kEye.y) / direction.y * direction) / kPlaces / kPlaces;
  }
  return sum;
}

// Of a lamp of this power, on a wall that faces -y.
double irradiance(Vec3 place, Vec3 lamp, double power) {
  const Vec3 way = lamp - place;
  return power * -way.y / (4 * kPi * std::pow(length(way), 3));
}

const Vec3 kLamp{9, 8, 15};
const std::string kLit = "light { point { position { x: 9 y: 8 z: 15 } } power: 800 }" + camera({11.5, 15, 11}, 12);
const std::string kBack = "node { material: \"wall\" box { low { x: -9 y: 15 z: -9 } high { x: 40 y: 40 z: 40 } } }";

TEST(Wall, OfALampHasTheInverseSquaresLight) {
  const SceneSetup setup = setup_of({"wall", kWorld + kBack + "}" + kMaterials + kLit});
  const double truth = mean_on_wall(setup, [](Vec3 p) { return 0.5 / kPi * irradiance(p, kLamp, 800); });
  for (const int light_scatterings : {0, 2}) {
    const Shown found = shown(setup, light_scatterings, 8, 30);
    EXPECT_NEAR(found.mean, truth, 3 * found.error + 5e-4 * truth) << light_scatterings;
    EXPECT_LT(found.error, 0.005 * truth) << light_scatterings;
  }
}

// A mirror in the floor lights the wall as a second lamp beneath it does. Paths of two scatterings: longer ones have no
// closed form.
TEST(Wall, HasTheLightOfAMirrorInTheFloor) {
  const SceneSetup setup = setup_of(
      {"mirror", kWorld + kBack +
                     "node { material: \"mirror\" box { low { x: -9 y: -9 z: -9 } high { x: 40 y: 40 z: 5 } } } }" +
                     kMaterials + kLit});
  const Vec3 image{kLamp.x, kLamp.y, 2 * 5 - kLamp.z};
  const double straight = mean_on_wall(setup, [](Vec3 p) { return 0.5 / kPi * irradiance(p, kLamp, 800); });
  const double truth =
      straight + mean_on_wall(setup, [&](Vec3 p) { return 0.5 * 0.5 / kPi * irradiance(p, image, 800); });
  const Shown found = shown(setup, 2, 2, 120);
  EXPECT_NEAR(found.mean, truth, 3 * found.error + 5e-4 * truth);
  EXPECT_LT(found.error, 0.01 * truth);
  const Shown eye_alone = shown(setup, 0, 2, 30);  // no such path finds a lamp without area in a mirror
  EXPECT_NEAR(eye_alone.mean, straight, 3 * eye_alone.error + 5e-4 * straight);
  EXPECT_GT(truth - straight, 6 * found.error);
}

}  // namespace
}  // namespace gicube::samples
