// Worlds, materials, lights, illumination and engines as text.
#include "../damage.h"
#include "../scene_faults.h"
#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "test.h"

namespace gicube::scene {
namespace {

TEST(WorldFile, FillsTheStructsOfTheScenegraph) {
  const Scene scene = parse_scene(R"(
    world { low { x: -1 y: -1 z: 0 } high { x: 1 y: 1 z: 1.5 } size: 64
      node { name: "group" material: "gold" transform { translate { z: 0.2 } }
        child { name: "ring" transform { rotate { axis { x: 1 } degrees: 90 } } transform { scale { all: 2 } }
                torus { radius: 0.5 tube: 0.1 } }
        child { name: "pipe" cylinder { radius: 0.5 height: 0.3 inner_radius: 0.4 rounding: 0.01 } }
        child { name: "thing" mesh { file: "thing.ply" } }
        child { name: "head" builtin: "head" transform { scale { z: 0.5 } } } }
      node { name: "floor" material: "paper" box { low { x: -1 y: -1 z: 0 } high { x: 1 y: 1 z: 0.1 } rounding: 0.02 } }
      node { name: "scan" material: "bone" volume { file: "head.nrrd" spacing: [1, 1, 2] } }
      node { name: "haze" material: "air" box { } } }
    material { name: "gold" solid { colour { red: 1 green: 0.8 blue: 0.3 } } scattering: 0.9
               bsdf: "dull_reflection" gloss: 0.05 seen_through_scattering: true
               scattering_colour { red: 1 green: 0.8 blue: 0.4 }
               emission: 2.5 emission_colour { red: 1 green: 0.5 blue: 0 } }
    material { name: "paper" tag: 3 scattering: 0.5 bsdf: "diffuse" }
    material { name: "bone" tag: 1 transfer_function { preset: "ct-bone" } }
    material { name: "air" tag: 2 fog { extinction: 0.7 } scattering: 0.4 bsdf: "trap" routine: "henyey_greenstein"
               surface: false parameter: 0.6 }
    light { name: "lamp" point { position { z: 3 } } power: 9 colour { green: 0.5 } }
    light { towards { x: 1 } power: 2 }
    light { rectangle { corner { x: 1 } edge_u { y: 1 } edge_v { z: 1 } } }
    light { sphere { centre { x: 4 } radius: 0.25 } }
    illumination { albedo: "high" rules: "as-printed" rays_per_face_voxel: 16 step: 0.25 jitter: true
                   lifetime: 9 seed: 5 exposure: 0.3 colour_passes: true }
    camera { name: "front" eye { y: -3 } } camera { name: "top" eye { z: 3 } up { y: 1 } }
    engine { target: "light[lamp].power" key { time: 0 value: 1 } key { time: 2 value: 3 } }
    engine { target: "camera[top].eye.z" start: 3 rate: 0.5 }
    background { red: 0.1 green: 0.2 blue: 0.3 } lifetime: 4 high_albedo: true seed: 77)",
                                  "a.scene", "/data");
  ASSERT_TRUE(scene.world);
  EXPECT_EQ(scene.world->high, (Vec3{1, 1, 1.5}));
  EXPECT_EQ(scene.world->size, 64);
  const std::vector<Node>& nodes = scene.world->root.children;
  ASSERT_EQ(nodes.size(), 4u);
  EXPECT_EQ(nodes[0].material, "gold");
  EXPECT_EQ(nodes[0].transforms, (std::vector<Transform>{Translate{{0, 0, 0.2}}}));
  const std::vector<Node>& parts = nodes[0].children;
  EXPECT_EQ(parts[0].transforms, (std::vector<Transform>{Rotate{{1, 0, 0}, 90}, Scale{{2, 2, 2}}}));
  EXPECT_EQ(parts[0].content, Content(Shape(TorusShape{0.5, 0.1})));
  EXPECT_EQ(parts[1].content, Content(Shape(CylinderShape{0.5, 0.3, 0.4, 0.01})));
  EXPECT_EQ(parts[2].content, Content(Shape(MeshShape{"/data/thing.ply", nullptr})));
  EXPECT_EQ(parts[3].content, Content(Shape(BuiltinShape{"head"})));
  EXPECT_EQ(parts[3].transforms, (std::vector<Transform>{Scale{{1, 1, 0.5}}}));
  EXPECT_EQ(nodes[1].content, Content(Shape(BoxShape{{-1, -1, 0}, {1, 1, 0.1}, 0.02})));
  EXPECT_EQ(std::get<ScanContent>(nodes[2].content).source.file, "/data/head.nrrd");
  EXPECT_EQ(nodes[3].content, Content(Shape(BoxShape{})));

  ASSERT_EQ(scene.materials.size(), 4u);
  EXPECT_EQ(scene.materials[0].tag, 0);
  EXPECT_EQ(look_as<SolidLook>(scene.materials[0])->colour, (Colour{1, 0.8, 0.3}));
  EXPECT_EQ(scene.materials[0].optics.bsdf, Bsdf::kDullReflection);
  EXPECT_EQ(scene.materials[0].optics.gloss, 0.05);
  EXPECT_TRUE(scene.materials[0].optics.seen_through_scattering);
  EXPECT_EQ(scene.materials[0].scattering_colour, (Colour{1, 0.8, 0.4}));
  EXPECT_EQ(scene.materials[0].emission, 2.5);
  EXPECT_EQ(scene.materials[0].emission_colour, (Colour{1, 0.5, 0}));
  EXPECT_EQ(scene.materials[1].emission, 0);
  EXPECT_EQ(scene.materials[1].tag, 3);
  EXPECT_FALSE(scene.materials[1].look);
  EXPECT_NE(look_as<TransferFunctionFile>(scene.materials[2]), nullptr);
  EXPECT_EQ(look_as<FogLook>(scene.materials[3])->extinction, 0.7);
  EXPECT_EQ(scene.materials[3].optics.routine, kHenyeyGreensteinRoutine);
  EXPECT_EQ(scene.materials[3].optics.parameters, (std::vector<float>{0.6f}));

  ASSERT_EQ(scene.lights.size(), 4u);
  EXPECT_EQ(std::get<PointLight>(scene.lights[0].light).power, 9);
  EXPECT_EQ(scene.lights[0].colour, (Colour{1, 0.5, 1}));
  EXPECT_EQ(std::get<DirectionalLight>(scene.lights[1].light).irradiance, 2);
  EXPECT_EQ(std::get<RectangleLight>(scene.lights[2].light).edge_v, (Vec3{0, 0, 1}));
  EXPECT_EQ(std::get<SphereLight>(scene.lights[3].light).radius, 0.25);

  EXPECT_TRUE(scene.lighting.on);
  EXPECT_EQ(scene.lighting.settings.albedo, Albedo::kHigh);
  EXPECT_EQ(scene.lighting.settings.rules, EnergyRules::kAsPrinted);
  EXPECT_EQ(scene.lighting.settings.rays_per_face_voxel, 16);
  EXPECT_EQ(scene.lighting.settings.step, 0.25);
  EXPECT_TRUE(scene.lighting.settings.jitter);
  EXPECT_EQ(scene.lighting.settings.lifetime, 9);
  EXPECT_EQ(scene.lighting.settings.seed, 5u);
  EXPECT_EQ(scene.lighting.exposure, 0.3);
  EXPECT_TRUE(scene.lighting.colour_passes);

  EXPECT_EQ(scene.camera.name, "front");
  ASSERT_EQ(scene.more_cameras.size(), 1u);
  EXPECT_EQ(scene.more_cameras[0].eye, (Vec3{0, 0, 3}));
  ASSERT_EQ(scene.engines.size(), 2u);
  EXPECT_EQ(scene.engines[0].at(1), 2);
  EXPECT_EQ(scene.engines[1].at(2), 4);
  EXPECT_EQ(scene.background, (Colour{0.1, 0.2, 0.3}));
  EXPECT_EQ(scene.view.lifetime, 4);
  EXPECT_TRUE(scene.view.high_albedo);
  EXPECT_EQ(scene.view.seed, 77u);
}

// The program of docs/guide/scenes.md.
TEST(WorldFile, IsTheSameByProgram) {
  Node ring{.name = "ring", .content = Shape(TorusShape{.radius = 0.6, .tube = 0.1}), .material = "gold"};
  ring.transforms = {Rotate{{1, 0, 0}, 90}, Translate{{0, 0, 0.7}}};
  Scene scene;
  scene.world = World{.low = {-1, -1, 0}, .high = {1, 1, 1.5}, .size = 64, .root = {}};
  scene.world->root.children = {ring};
  SceneMaterial gold{.name = "gold", .tag = 0, .look = SolidLook{.colour = {0.1, 0.07, 0.02}}};
  gold.optics = {.scattering = 0.97, .bsdf = Bsdf::kSpecular, .seen_through_scattering = true};
  scene.materials = {gold};
  scene.lights = {{.name = "lamp", .light = PointLight{{-1.5, 0.9, 1.7}, 40}}};
  scene.lighting.on = true;
  scene.engines = {{.target = "node[ring].transform[0].rotate.degrees", .start = 90, .rate = 45}};

  const Scene text = parse_scene(R"(
    world { low { x: -1 y: -1 z: 0 } high { x: 1 y: 1 z: 1.5 } size: 64
      node { name: "ring" material: "gold" transform { rotate { axis { x: 1 } degrees: 90 } }
             transform { translate { z: 0.7 } } torus { radius: 0.6 tube: 0.1 } } }
    material { name: "gold" solid { colour { red: 0.1 green: 0.07 blue: 0.02 } } scattering: 0.97 bsdf: "specular"
               seen_through_scattering: true }
    light { name: "lamp" point { position { x: -1.5 y: 0.9 z: 1.7 } } power: 40 }
    illumination { }
    engine { target: "node[ring].transform[0].rotate.degrees" start: 90 rate: 45 })",
                                 "a.scene", "");
  EXPECT_TRUE(same_voxels(scene, text));
  EXPECT_TRUE(same_illumination(scene, text));
  const SceneSetup by_program = set_up(at_time(scene, 2)), by_text = set_up(at_time(text, 2));
  EXPECT_EQ(by_program.volume.samples, by_text.volume.samples);
  EXPECT_EQ(by_program.optics.at(0).scattering, by_text.optics.at(0).scattering);
  EXPECT_EQ(by_program.optics.at(0).bsdf, by_text.optics.at(0).bsdf);
}

// The void of docs/guide/scenes.md: solids of the scenegraph only unite.
TEST(WorldFile, HasVoidsByAFieldOfTheProgramsOwn) {
  const Field block = fields_of(BoxShape{}).front(), pore = fields_of(SphereShape{.radius = 0.3}).front();
  const Field cast = [block, pore](gicube::Vec3 p) {  // in the block and not in the pore
    const Distance solid = block(p), hollow = pore(p);
    return solid.distance > -hollow.distance ? solid : Distance{-hollow.distance, -1 * hollow.away};
  };
  Node part{.name = "part", .content = Shape(FieldShape{std::make_shared<const Field>(cast)}), .material = "steel"};
  World world{.low = {-1.5, -1.5, -1.5},
              .high = {1.5, 1.5, 1.5},
              .size = 61,
              .densities = Densities::kPartialVolumes,
              .root = {}};
  world.root.children = {part};
  const BuiltWorld built = build(world, {{.name = "steel"}});
  double volume = 0;
  for (const float density : values_of(built.voxels.volume))
    volume += density / kMaxDensity * std::pow(built.grid.voxel, 3);
  EXPECT_NEAR(volume, 8 - 4 * std::numbers::pi / 3 * 0.027, 0.005);
}

TEST(WorldFile, HasHypertexturesWhoseNumbersEnginesDrive) {
  const Scene scene = parse_scene(R"(
    world { size: 16 node { name: "fire" material: "m" hypertexture { kind: "flame" torus { radius: 0.5 tube: 0.2 }
      softness: 0.4 frequency: 2 octaves: 3 amplitude: 0.1 time: 1 length: 0.5 curl: 0.2 stretch: 1.5 seed: 9 } } }
    material { name: "m" transfer_function { preset: "ramp" } }
    engine { target: "node[fire].hypertexture.time" start: 1 rate: 2 })",
                                  "a.scene", "/data");
  const Hypertexture texture{.kind = HypertextureKind::kFlame,
                             .shape = TorusShape{0.5, 0.2},
                             .softness = 0.4,
                             .frequency = 2,
                             .octaves = 3,
                             .amplitude = 0.1,
                             .time = 1,
                             .length = 0.5,
                             .curl = 0.2,
                             .stretch = 1.5,
                             .seed = 9};
  EXPECT_EQ(scene.world->root.children[0].content, Content(texture));
  const Scene later = at_time(scene, 0.5);
  EXPECT_EQ(std::get<Hypertexture>(later.world->root.children[0].content).time, 2);
  EXPECT_FALSE(same_voxels(scene, later));
  EXPECT_NE(set_up(scene).volume.samples, set_up(later).volume.samples);
  Scene driven = scene;
  for (const char* field : {"softness", "frequency", "amplitude", "time", "length", "curl", "stretch"}) {
    find_parameter(driven, std::string("node[fire].hypertexture.") + field) = 7;
  }
  const Hypertexture sevens{texture.kind, texture.shape, 7, 7, 3, 7, 7, 7, 7, 7, 9};
  EXPECT_EQ(driven.world->root.children[0].content, Content(sevens));
  EXPECT_THROW(find_parameter(driven, "node[fire].hypertexture.octaves"), InputError);
  EXPECT_THROW(find_parameter(driven, "node[fire].transform[0].scale.x"), InputError);
}

TEST(WorldFile, OfTheSourceTreesHypertexturesAreBuilt) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GICUBE_SOURCE_DIR "/samples/scenes/hypertexture")) {
    Scene scene = read_scene(entry.path());
    scene.world->size = 24;
    const SceneSetup setup = set_up(at_time(scene, 1));
    std::vector<float> densities = values_of(setup.volume);
    std::ranges::sort(densities);
    EXPECT_GT(std::ranges::unique(densities).begin() - densities.begin(), 100) << entry.path();
    ++scenes;
  }
  EXPECT_GE(scenes, 2);
}

TEST(WorldFile, NamesTheFaultsOfAHypertexture) {
  const std::string faults = faults_of(R"(world { node { name: "a" hypertexture { kind: "smoke" } }
    node { name: "b" hypertexture { kind: "fur" sphere { radius: 0 } box { } softness: 0 } } })");
  for (const char* part : {"node[a].hypertexture: expected one shape, got none",
                           "node[a].hypertexture.kind: expected noise, turbulence, fur or flame, got \"smoke\"",
                           "node[b].hypertexture: expected one shape, got several",
                           "node[b].hypertexture.softness: expected a number above 0, got 0"}) {
    EXPECT_THAT(faults, HasSubstr(part));
  }
}

TEST(WorldFile, HasPartialVolumesIfItAsksForThem) {
  const std::string rest = " node { material: \"m\" sphere { } } } material { name: \"m\" }";
  EXPECT_EQ(parse_scene("world {" + rest, "a.scene", "").world->densities, Densities::kRamp);
  EXPECT_EQ(parse_scene("world { partial_volumes: true" + rest, "a.scene", "").world->densities,
            Densities::kPartialVolumes);
}

TEST(WorldFile, HasTheDefaultsOfTheStructs) {
  const Scene scene = parse_scene(
      "world { node { material: \"m\" torus { } } } material { name: \"m\" } illumination { }", "a.scene", "");
  const World world;
  EXPECT_EQ(scene.world->low, world.low);
  EXPECT_EQ(scene.world->high, world.high);
  EXPECT_EQ(scene.world->size, world.size);
  EXPECT_EQ(scene.world->root.children[0].content, Content(Shape(TorusShape{})));
  const Illumination settings;
  EXPECT_TRUE(scene.lighting.on);
  EXPECT_EQ(scene.lighting.settings.albedo, settings.albedo);
  EXPECT_EQ(scene.lighting.settings.rules, settings.rules);
  EXPECT_EQ(scene.lighting.settings.rays_per_face_voxel, settings.rays_per_face_voxel);
  EXPECT_EQ(scene.lighting.settings.step, settings.step);
  EXPECT_EQ(scene.lighting.settings.lifetime, settings.lifetime);
  EXPECT_EQ(scene.view.lifetime, View().lifetime);
}

TEST(WorldFile, ReportsAllFaultsByTheirFields) {
  const std::string faults = faults_of(R"(
    volume { builtin: "buckyball" }
    world { size: 4
      node { name: "a" sphere { radius: -1 } material: "steel" }
      node { name: "b" sphere { } torus { tube: 3 } material: "gold" }
      node { transform { } transform { scale { x: 0 } } transform { scale { all: 1 y: 2 } }
             material: "gold" sphere { } }
      node { name: "d" child { name: "e" builtin: "teapot" } material: "gold" transform { rotate { axis { } } } }
      node { name: "f" }
      node { name: "g" material: "gold" mesh { } }
      node { name: "h" material: "gold" volume { builtin: "buckyball" } } }
    material { name: "gold" scattering: 1.5 bsdf: "mirror" fog { } solid { } tag: 7 }
    material { tag: 1 routine: "glass" }
    material { name: "gold" tag: 1 }
    light { name: "l" point { } sphere { } }
    light { rectangle { edge_u { x: 1 } edge_v { x: 2 } } colour { } }
    light { sphere { radius: 0 } power: 0 }
    illumination { albedo: "medium" rules: "nice" rays_per_face_voxel: 0 step: 20 lifetime: 5000 exposure: -1 }
    engine { target: "light[9].power" key { time: 1 value: 1 } key { time: 1 value: 1 } }
    engine { key { time: 1 } }
    background { red: 2 } lifetime: 2000)");
  for (const char* fault :
       {"volume: expected a volume or a world, got both",
        "world.size: expected 8 to 1024 voxels, got 4",
        "node[a].sphere.radius: expected a number above 0, got -1",
        "node[a].material: expected a material of the scene, got \"steel\"",
        "node[b]: expected children, one shape, one hypertexture or one volume, got several",
        "world.node[2].transform[0]: expected one of translate, rotate and scale, got none",
        "world.node[2].transform[1].scale: expected finite numbers other than 0, got 0 1 1",
        "world.node[2].transform[2].scale: expected all, or x, y and z, got both",
        "node[e].builtin: expected buckyball, buckyball_atoms, buckyball_bonds or head, got \"teapot\"",
        "node[d].transform[0].rotate.axis: expected a direction, got 0 0 0",
        "node[f]: expected children, one shape, one hypertexture or one volume, got nothing",
        "node[g].mesh.file: expected a mesh, got none",
        "node[h].volume: expected a file, got a builtin",
        "material[gold]: expected one of solid, fog and transfer_function, got several",
        "material[gold].bsdf: expected none, specular,",
        "material[gold].tag: expected 0 to 3, got 7",
        "material[1].name: expected a name, got none",
        "material[1].routine: expected fresnel,",
        "material[gold].tag: expected a tag of its own, got 1",
        "material[gold].name: expected a name of its own, got \"gold\"",
        "light[l]: expected one of towards, point, rectangle and sphere, got several",
        "light[1].rectangle.edge_v: expected an edge across edge_u",
        "light[1].colour: expected illumination.colour_passes with it",
        "light[2].sphere.radius: expected a number above 0, got 0",
        "illumination: albedo: expected none, low or high, got \"medium\"",
        "illumination: rules: expected conserving or as-printed, got \"nice\"",
        "illumination.rays_per_face_voxel: expected 1 to 4096, got 0",
        "illumination.step: expected 0.015625 to 16, got 20",
        "illumination.lifetime: expected 0 to 1023, got 5000",
        "illumination.exposure: expected a number above 0, or 0",
        "engine[0].key.time: expected more than 1, got 1",
        "engine[0]: engine.target: expected a number of a node's transform",
        "engine[1].target: expected the place of a number",
        "engine[1].key[0]: expected time and value",
        "background.red: expected 0 to 1, got 2",
        "lifetime: expected 0 to 1023, got 2000"}) {
    EXPECT_THAT(faults, HasSubstr("a.scene: " + std::string(fault)));
  }
}

TEST(WorldFile, RefusesMaterialsOverOneInKs) {
  EXPECT_THAT(faults_of("volume { builtin: \"buckyball\" } material { scattering: 1.01 bsdf: \"diffuse\" }"),
              HasSubstr("a.scene: material[0].scattering: expected 0 to 1, got 1.01"));
}

TEST(WorldFile, RefusesBracesWithoutEnd) {
  std::string deep = "world { node { ";
  for (int i = 0; i < 100'000; ++i) deep += "child {";
  EXPECT_NE(faults_of(deep), "none");
  std::string tower = "material { name: \"m\" } world { node { material: \"m\" ";
  for (int i = 0; i < 80; ++i) tower += "child { ";
  EXPECT_THAT(faults_of(tower + "sphere { } " + std::string(82, '}')), HasSubstr("at most 60 levels"));
}

TEST(WorldFile, OfTheSourceTreeIsReadOrRefusedHoweverItIsDamaged) {
  constexpr std::string_view kLikely = "0123456789-. {}:\"#_";
  std::mt19937 random(17);
  int scenes = 0, refused = 0, rounds = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GICUBE_SOURCE_DIR "/samples/scenes")) {
    if (entry.path().extension() != ".scene") continue;
    ++scenes;
    std::ifstream stream(entry.path());
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_NO_THROW(parse_scene(whole, "whole", entry.path().parent_path())) << entry.path();
    for (int round = 0; round < 200; ++round, ++rounds) {
      try {
        const std::string text = damaged(whole, kLikely, random);
        at_time(parse_scene(text, "damaged", entry.path().parent_path()), 1.5);
      } catch (const InputError&) {
        ++refused;
      }
    }
  }
  EXPECT_GE(scenes, 7);
  EXPECT_GT(refused, rounds / 10);
}

}  // namespace
}  // namespace gicube::scene
