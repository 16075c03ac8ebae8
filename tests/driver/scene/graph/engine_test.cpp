#include "gicube/scene/engine.h"

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "test.h"

namespace gicube::scene {
namespace {

Scene example() {
  Scene scene;
  scene.world.emplace();
  Node ring{"ring", {Translate{{1, 2, 3}}, Rotate{{0, 0, 1}, 30}, Scale{{1, 1, 2}}}, Shape(TorusShape{}), "gold", {}};
  scene.world->root.children = {{"group", {}, Group{}, "", {ring}}};
  scene.lights = {{"lamp", PointLight{{1, 1, 1}, 5}, {1, 1, 1}},
                  {"", DirectionalLight{{0, 0, 1}, 2}, {1, 1, 1}},
                  {"panel", RectangleLight{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 3}, {1, 1, 1}},
                  {"ball", SphereLight{{0, 0, 0}, 0.5, 4}, {1, 1, 1}}};
  scene.camera.name = "front";
  scene.camera.eye = Vec3{0, -5, 0};
  scene.camera.fov_degrees = 30;
  scene.more_cameras = {{"top", Vec3{0, 0, 9}, {}, {}, "", {}, 4.0}};
  scene.view.cut_planes = {{{1, 0, 0}, 0.25}};
  return scene;
}

TEST(Engine, IsLinearBetweenItsKeysAndConstantBeyond) {
  const Engine engine{"x", {{1, 10}, {2, 20}, {4, 0}}, 0, 0};
  EXPECT_EQ(engine.at(0), 10);
  EXPECT_EQ(engine.at(1), 10);
  EXPECT_EQ(engine.at(1.5), 15);
  EXPECT_EQ(engine.at(3), 10);
  EXPECT_EQ(engine.at(9), 0);
}

TEST(Engine, WithoutKeysStartsAndGrowsAtItsRate) {
  const Engine engine{"x", {}, 3, -0.5};
  EXPECT_EQ(engine.at(0), 3);
  EXPECT_EQ(engine.at(4), 1);
}

TEST(Engine, ReachesEveryNumberOfTransformsLightsCamerasAndCutPlanes) {
  Scene scene = example();
  const std::pair<const char*, double> places[] = {{"node[ring].transform[0].translate.y", 2},
                                                   {"node[ring].transform[1].rotate.degrees", 30},
                                                   {"node[ring].transform[1].rotate.axis.z", 1},
                                                   {"node[ring].transform[2].scale.z", 2},
                                                   {"light[lamp].power", 5},
                                                   {"light[0].position.x", 1},
                                                   {"light[1].towards.z", 1},
                                                   {"light[1].power", 2},
                                                   {"light[panel].edge_v.y", 1},
                                                   {"light[panel].corner.x", 0},
                                                   {"light[panel].edge_u.x", 1},
                                                   {"light[ball].radius", 0.5},
                                                   {"light[ball].centre.x", 0},
                                                   {"camera.eye.y", -5},
                                                   {"camera[front].fov_degrees", 30},
                                                   {"camera[top].eye.z", 9},
                                                   {"camera[top].orthographic_height", 4},
                                                   {"cut_plane[0].normal.x", 1},
                                                   {"cut_plane[0].offset", 0.25}};
  for (const auto& [target, value] : places) EXPECT_EQ(find_parameter(scene, target), value) << target;
}

TEST(Engine, IsRefusedWhereThereIsNoSuchNumber) {
  Scene scene = example();
  for (const char* target : {"",
                             "camera",
                             "camera.eye",
                             "camera.eye.w",
                             "camera.look_at.x",
                             "camera[side].eye.x",
                             "camera.eye.x.y",
                             "light[4].power",
                             "light[lamp].radius",
                             "light.power",
                             "light[lamp",
                             "node[none].transform[0].translate.x",
                             "node[ring].transform[3].scale.x",
                             "node[ring].transform[0].scale.x",
                             "node[ring].transform.scale.x",
                             "cut_plane[1].offset",
                             "cut_plane[0].normal",
                             "cut_plane[-1].offset",
                             "step",
                             "camera..eye"}) {
    EXPECT_THROW(find_parameter(scene, target), InputError) << target;
  }
}

TEST(Engine, MakesTheSceneOfATimeAndLeavesTheSceneItself) {
  Scene scene = example();
  scene.engines = {{"camera.eye.y", {{0, -5}, {10, 5}}, 0, 0}, {"node[ring].transform[1].rotate.degrees", {}, 0, 36}};
  const Scene later = at_time(scene, 5);
  EXPECT_EQ(later.camera.eye->y, 0);
  EXPECT_EQ(std::get<Rotate>(later.world->root.children[0].children[0].transforms[1]).degrees, 180);
  EXPECT_EQ(scene.camera.eye->y, -5);
  EXPECT_FALSE(same_voxels(scene, later));
}

TEST(Engine, ThatMovesTheEyeAloneLeavesTheIllumination) {
  Scene scene = example();
  scene.engines = {{"camera.eye.y", {}, 0, 1}};
  EXPECT_TRUE(same_illumination(at_time(scene, 1), at_time(scene, 2)));
  scene.engines = {{"light[lamp].position.x", {}, 0, 1}};
  EXPECT_TRUE(same_voxels(at_time(scene, 1), at_time(scene, 2)));
  EXPECT_FALSE(same_illumination(at_time(scene, 1), at_time(scene, 2)));
}

TEST(Engine, IsAloneAtItsNumber) {
  Scene scene = example();
  scene.engines = {{"light[lamp].power", {}, 1, 1}, {"light[0].power", {}, 2, 0}};
  EXPECT_THROW(at_time(scene, 0), InputError);
}

TEST(Engine, IsCheckedByField) {
  const std::pair<Engine, const char*> cases[] = {{{"", {}, 0, 0}, "target"},
                                                  {{"x", {{0, 1}, {0, 2}}, 0, 0}, "key.time"},
                                                  {{"x", {{0, 1}}, 0, 2}, "both"},
                                                  {{"x", {}, std::nan(""), 0}, "start"}};
  for (const auto& [engine, fault] : cases) {
    EXPECT_THROWS(InputError, fault, check(engine));
  }
}

}  // namespace
}  // namespace gicube::scene
