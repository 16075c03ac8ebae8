#include "gicube/scene/world.h"

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "test.h"

namespace gicube::scene {
namespace {

double total(const BuiltWorld& built) {
  double sum = 0;
  for (std::size_t i = 0; i < built.voxels.tags.size(); ++i) {
    std::uint16_t word = 0;
    std::memcpy(&word, &built.voxels.volume.samples[2 * i], sizeof word);
    sum += word / kMaxDensity;
  }
  return sum * std::pow(built.grid.voxel, 3);  // world units
}

std::string fault_of(const World& world, const std::vector<SceneMaterial>& materials) {
  return message_of<InputError>([&] { build(world, materials); });
}

Node leaf(const std::string& name, const Content& content, const std::string& material,
          const std::vector<Transform>& transforms = {}) {
  return {name, transforms, content, material, {}};
}

const std::vector<SceneMaterial> kWhite{{"white", 2, {}, {}, {1, 1, 1}}};

TEST(World, HasCubicVoxelsWhoseFirstAndLastLieOnItsCorners) {
  World world;
  world.low = {-1, 0, 0};
  world.high = {1, 1, 0.5};
  world.size = 101;
  const WorldGrid grid = grid_of(world);
  EXPECT_EQ(grid.dims, (Dims{101, 51, 26}));
  EXPECT_DOUBLE_EQ(grid.voxel, 0.02);
  EXPECT_EQ(grid.voxel_of({-1, 0, 0}), (Vec3{0, 0, 0}));
  EXPECT_NEAR(grid.point_of({100, 50, 25}).z, 0.5, 1e-12);
}

TEST(World, AppliesANodesTransformsInTheirOrderAndThenItsParents) {
  World world;
  world.size = 65;  // a voxel is 1/32
  Node ball = leaf("ball", Shape(SphereShape{0.25}), "white", {Translate{{0.5, 0, 0}}, Rotate{{0, 0, 1}, 90}});
  world.root.children = {{"group", {Translate{{0, 0, 0.5}}}, Group{}, "", {ball}}};
  const BuiltWorld built = build(world, kWhite);
  const auto density = [&](Vec3 p) {
    const Vec3 v = built.grid.voxel_of(p);
    const auto at = static_cast<std::size_t>((std::lround(v.z) * 65 + std::lround(v.y)) * 65 + std::lround(v.x));
    std::uint16_t word = 0;
    std::memcpy(&word, &built.voxels.volume.samples[2 * at], sizeof word);
    return word;
  };
  EXPECT_EQ(density({0, 0.5, 0.5}), 4095);
  EXPECT_EQ(density({0.5, 0, 0.5}), 0);
  // Ramps of two voxels across a sphere of 8 fill 1/64 too much.
  EXPECT_NEAR(total(built) / (4 * std::numbers::pi / 3 / 64), 1, 0.02);
}

TEST(World, LooksTheSameAtEverySize) {
  World world;
  world.root.children = {leaf("ring", Shape(TorusShape{0.6, 0.2}), "white", {Rotate{{1, 0, 0}, 30}})};
  world.size = 48;
  const double coarse = total(build(world, kWhite));
  world.size = 96;
  EXPECT_NEAR(coarse / total(build(world, kWhite)), 1, 0.015);
}

TEST(World, GivesEachTagItsMaterialsLookAndLeavesTheOthersInvisible) {
  World world;
  world.size = 16;
  const std::vector<SceneMaterial> materials{{"red", 1, SolidLook{{1, 0, 0}, 1}, {}, {1, 1, 1}}};
  world.root.children = {leaf("ball", Shape(SphereShape{0.5}), "red")};
  const BuiltWorld built = build(world, materials);
  ASSERT_EQ(built.looks.size(), 4u);
  EXPECT_EQ(built.looks[1].function.colour_at(4000), (Colour{1, 0, 0}));
  EXPECT_EQ(built.looks[1].function.opacity_at(4095), 1);
  for (const std::size_t tag : {0u, 2u, 3u}) EXPECT_EQ(built.looks[tag].function.opacity_at(4095), 0);
  EXPECT_EQ(built.voxels.tags[static_cast<std::size_t>((8 * 16 + 8) * 16 + 8)], 1);
}

TEST(World, HoldsScansWhoseTransferFunctionIsInTheirOwnValues) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "ramp.raw";
  std::ofstream stream(file, std::ios::binary);
  for (int i = 0; i < 16 * 16 * 16; ++i) stream.put(static_cast<char>(10 + 10 * (i % 16)));  // 10..160 along x
  stream.close();
  VolumeSource source;
  source.file = file;
  source.raw = RawLayout{{16, 16, 16}, SampleType::kUint8, {1, 1, 1}, false, 0};
  const TransferFunctionFile look{{{{0, {1, 1, 1}}}, {{0, 0}, {255, 1}}}};
  const std::vector<SceneMaterial> materials{{"tissue", 3, look, {}, {1, 1, 1}}};
  World world;
  world.size = 33;
  world.root.children = {leaf("scan", ScanContent{source}, "tissue", {Scale{{2, 2, 2}}})};
  const BuiltWorld built = build(world, materials);
  const std::size_t middle = static_cast<std::size_t>((16 * 33 + 16) * 33 + 16);
  std::uint16_t word = 0;
  std::memcpy(&word, &built.voxels.volume.samples[2 * middle], sizeof word);
  EXPECT_NEAR(word, 4095 * 85 / 255.0, 1);  // between 80 and 90; uint8 has the range 0..255
  EXPECT_EQ(built.voxels.tags[middle], 3);
  EXPECT_NEAR(built.looks[3].function.opacity_at(word), 85.0 / 255, 1e-3);
  EXPECT_EQ(built.voxels.gradients[3 * middle], 1);

  world.root.children.push_back(leaf("ball", Shape(SphereShape{0.5}), "tissue"));
  EXPECT_THAT(fault_of(world, materials), HasSubstr("node[ball]: material: expected one that no scan is made of"));
}

TEST(World, NamesTheNodeAndTheFieldOfWhatIsWrong) {
  World world;
  world.size = 16;
  world.root.children = {leaf("ball", Shape(SphereShape{0}), "white")};
  EXPECT_THAT(fault_of(world, kWhite), HasSubstr("node[ball]: radius: expected a number above 0, got 0"));
  world.root.children = {leaf("ball", Shape(SphereShape{}), "blue")};
  EXPECT_THAT(fault_of(world, kWhite), HasSubstr("node[ball]: material: expected one of white, got \"blue\""));
  EXPECT_THAT(fault_of(world, {}), HasSubstr("got \"blue\""));
  world.root.children = {leaf("ball", Shape(SphereShape{}), "white", {Scale{{1, 0, 1}}})};
  EXPECT_THAT(fault_of(world, kWhite), HasSubstr("node[ball]: scale"));
  world.root.children = {leaf("ball", Shape(SphereShape{}), "white", {Scale{{1e-200, 1e-200, 1}}})};
  EXPECT_THAT(fault_of(world, kWhite), HasSubstr("node[ball]: transform: expected a scale from"));
  world.root.children = {leaf("ball", Shape(SphereShape{}), "white")};
  world.root.children[0].children = world.root.children;
  EXPECT_THAT(fault_of(world, kWhite), HasSubstr("node[ball]: expected children or a content, got both"));
  const std::vector<SceneMaterial> two{{"a", 1, {}, {}, {1, 1, 1}}, {"b", 1, {}, {}, {1, 1, 1}}};
  EXPECT_THAT(fault_of(world, two), HasSubstr("material[b].tag: expected another than that of a, got 1"));
  world.size = 4;
  EXPECT_THAT(fault_of(world, kWhite), HasSubstr("world.size: expected 8 to 1024 voxels, got 4"));
  world.size = 16;
  world.high = {1, -1, 1};
  EXPECT_THAT(fault_of(world, kWhite), HasSubstr("world.high"));
}

// The same scene by program as by text (world_file_test.cpp); then everything is in voxels.
TEST(World, IsSetUpWithCameraLightsAndCutPlanesInVoxels) {
  Scene scene;
  scene.world.emplace();
  scene.world->size = 41;  // 0.05 a voxel
  scene.world->root.children = {leaf("ball", Shape(SphereShape{0.5}), "white")};
  scene.materials = kWhite;
  scene.materials[0].optics = {0.5, Bsdf::kSpecular, 0, true};
  scene.camera.eye = Vec3{0, -4, 0};
  scene.camera.look_at = Vec3{0, 0, 0};
  scene.lights = {{"lamp", PointLight{{0, 0, 2}, 3}, {1, 1, 1}}};
  scene.lighting.on = true;
  scene.lighting.exposure = 2;
  scene.view.cut_planes = {{{0, 0, 2}, 1}};  // z >= 0.5
  const SceneSetup setup = set_up(scene);
  EXPECT_NEAR(setup.view.eye.y, -60, 1e-9);
  EXPECT_NEAR(setup.view.look_at.x, 20, 1e-9);
  EXPECT_NEAR(std::get<PointLight>(setup.lights.at(0)).position.z, 60, 1e-9);
  EXPECT_NEAR(setup.lighting.exposure, 2 / 0.0025, 1e-9);
  EXPECT_NEAR(setup.view.cut_planes[0].offset / 2, 30, 1e-9);
  EXPECT_TRUE(setup.view.irradiance);
  EXPECT_TRUE(setup.view.scatter);
  ASSERT_EQ(setup.optics.size(), 3u);
  EXPECT_EQ(setup.optics[2].bsdf, Bsdf::kSpecular);
}

TEST(World, GivesItsAreaLightsToMirrorsIfItIsLit) {
  Scene scene;
  scene.world.emplace();
  scene.world->size = 41;  // 0.05 a voxel
  scene.materials = kWhite;
  scene.materials[0].optics = {0.5, Bsdf::kSpecular, 0, true};
  scene.lights = {{"bulb", PointLight{{0, 0, 2}, 3}, {1, 1, 1}},
                  {"panel", RectangleLight{{0, 0, 2}, {0, 1, 0}, {1, 0, 0}, 5}, {1, 0.5, 0}},
                  {"moon", SphereLight{{0, 0, 3}, 0.5, 5}, {0.25, 1, 1}}};
  EXPECT_TRUE(set_up(scene).view.lamps.empty()) << "without illumination";
  scene.lighting.on = true;
  SceneSetup setup = set_up(scene);
  ASSERT_EQ(setup.view.lamps.size(), 2u);
  EXPECT_EQ(setup.view.lamps[0].light, setup.lights[1]);
  EXPECT_EQ(setup.view.lamps[1].light, setup.lights[2]);
  EXPECT_EQ(setup.view.lamps[1].colour, (Colour{1, 1, 1}));
  EXPECT_NEAR(std::get<SphereLight>(setup.view.lamps[1].light).radius, 10, 1e-9);
  scene.lighting.colour_passes = true;
  set_look(scene, setup);
  ASSERT_EQ(setup.view.lamps.size(), 2u);
  EXPECT_EQ(setup.view.lamps[0].colour, (Colour{1, 0.5, 0}));
  scene.materials[0].optics.seen_through_scattering = false;
  EXPECT_TRUE(set_up(scene).view.lamps.empty()) << "without mirrors";
}

TEST(World, NamesTheLightThatIsWrong) {
  Scene scene;
  scene.world.emplace();
  scene.world->size = 16;
  scene.materials = kWhite;
  scene.lights = {{"panel", RectangleLight{{}, {1, 0, 0}, {1, 0, 0}, 1}, {1, 1, 1}}};
  EXPECT_THROWS(InputError, "light[panel].rectangle.edge_v", set_up(scene));
}

}  // namespace
}  // namespace gicube::scene
