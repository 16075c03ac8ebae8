// Lamps behind mirrors, and leaps over empty cells, in closed forms.
#include "light_guide.h"

#include <numbers>

#include "empty_space.h"
#include "path_tests.h"

namespace gicube::reference::paths {
namespace {

// A floor below z = 4, a mirror behind y = 12, a round lamp above: the mirror shows it again at y = 30.
struct MirroredLamp {
  MirroredLamp() : test({17, 17, 17}, [](Vec3 p) { return 0.5 + std::max(4 - p.z, p.y - 12) / 4; }) {
    test.surface(0.5);
    test.scene.functions[1] = test.scene.functions[0];
    for (int i = 0; i < 17 * 17 * 17; ++i) tags.push_back(i / 17 % 17 > 10 ? 1 : 0);
    test.scene.volume.tags = tags;
    scene = path_scene(test, {.scattering = 0.6, .bsdf = Bsdf::kDiffuse});
    scene.materials[1] = {.scattering = 0.9, .bsdf = Bsdf::kSpecular};
    scene.surfaces = {0.5, 0.5};
    add_light(scene, SphereLight{{8, -6, 20}, 2, 100}, {1, 0.5, 0.25});
  }
  std::vector<std::uint8_t> tags;
  TestScene test;
  PathScene scene;
};

TEST(LightGuide, FindsALampInAMirrorAndLeavesItsLightWhatItIs) {
  const MirroredLamp room;
  const auto from_lamp = [](double along, double up) {  // irradiance of the floor, a unit of power
    return up / (4 * std::numbers::pi * std::pow(std::hypot(along, up), 3));
  };
  const double truth = 100 * 0.6 / std::numbers::pi * (from_lamp(10, 16) + 0.9 * from_lamp(26, 16));
  const PathTracer plain(room.scene), guided(room.scene, true);
  const auto at_floor = [](const PathTracer& tracer) { return tracer.estimate({8, 4, 12}, {0, 0, -1}, 30'000, 60); };
  const auto rough = at_floor(plain), fine = at_floor(guided);
  for (std::size_t c = 0; c < 3; ++c) {
    expect_near(rough[c], truth / (1 << c), "by chance");
    expect_near(fine[c], truth / (1 << c), "guided");
    EXPECT_LT(fine[c].error, 0.4 * rough[c].error);
    EXPECT_LT(fine[c].error, 0.01 * truth / (1 << c));
  }
}

TEST(PathTracer, ShowsALampInAMirrorAsBrightAsIsAskedForAtMost) {
  MirroredLamp room;
  const double radiance = 100 / (4 * std::numbers::pi * std::numbers::pi * 2 * 2);
  const auto seen = [&] { return PathTracer(room.scene).estimate({8, 4, 8}, {0, 26, 12}, 10, 62); };
  EXPECT_NEAR(seen()[0].mean, 0.9 * radiance, 1e-9);
  room.scene.max_seen = 0.7 * radiance;
  EXPECT_NEAR(seen()[0].mean, 0.7 * radiance, 1e-9);
  EXPECT_NEAR(seen()[1].mean, 0.9 * radiance / 2, 1e-9);
}

TEST(LightGuide, KnowsNothingWhereNoMirrorSendsLight) {
  MirroredLamp room;
  room.scene.materials[1] = room.scene.materials[0];
  const Field field(room.scene.scene.volume, {});
  const Extinction extinction(room.scene, field);
  EXPECT_EQ(LightGuide(room.scene, extinction, room.scene.lights).cell({8, 4, 4}).sums, nullptr);
}

TEST(EmptySpace, IsLeftBeforeAnythingIsMet) {
  constexpr std::array<int, 3> kCells{9, 7, 11};
  CounterRandom random(61, 0);
  std::vector<std::uint8_t> something(9 * 7 * 11);
  for (auto& cell : something) cell = random.uniform() < 0.02 ? 1 : 0;
  const EmptySpace space(kCells, something);
  const auto flag = [&](const std::array<double, 3>& at) {
    std::array<int, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell[axis] = std::clamp(static_cast<int>(at[axis]), 0, kCells[axis] - 1);
    return something[static_cast<std::size_t>((cell[2] * 7 + cell[1]) * 9 + cell[0])] != 0;
  };
  double leapt = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::array<double, 3> from{9 * random.uniform(), 7 * random.uniform(), 11 * random.uniform()};
    const Vec3 way = random.direction();
    const double end = space.leave(from, {way.x, way.y, way.z}, 0);
    if (flag(from)) {
      EXPECT_EQ(end, 0);
      continue;
    }
    EXPECT_GT(end, 0);
    leapt = std::max(leapt, end);
    for (int k = 0; k < 50; ++k) {
      const double t = end * (k + 0.5) / 50;
      ASSERT_FALSE(flag({from[0] + t * way.x, from[1] + t * way.y, from[2] + t * way.z})) << i;
    }
  }
  EXPECT_GT(leapt, 2);
}

}  // namespace
}  // namespace gicube::reference::paths
