#include "compose/composition.h"

#include "../../../driver/scene/damage.h"
#include "test.h"

namespace gicube::samples {
namespace {

const std::filesystem::path kScenes = GICUBE_SOURCE_DIR "/samples/scenes";

Composition parsed_composition(const std::string& text) { return parse_composition(text, "x", kScenes); }

std::string fault_of(const std::string& text) {
  return message_of<InputError>([&] { parsed_composition(text); });
}

TEST(Composition, PlacesVolumesAndSurfaces) {
  const Composition read = parsed_composition(R"(
    volume { name: "ball" input: "builtin:buckyball" volume_size: 32 transform { translate { x: 2 } } }
    volume { input: "golden_ring.scene" transfer_function: "ramp" transform { scale { all: 3 } } }
    surface { file: "gem.obj" opacity: 0.5 colour { red: 0.5 } transform { scale { z: 2 } } transform { translate {
      y: 1 } } }
    camera { eye { z: 5 } } image { width: 20 height: 10 samples_per_axis: 2 } step: 0.25 overlap_step: 3 light { x: 1 }
    opacity_threshold: 1 background { red: 0.5 green: 0.5 blue: 0.5 })");
  ASSERT_EQ(read.volumes.size(), 2u);
  EXPECT_EQ(read.volumes[0].name, "ball");
  EXPECT_EQ(read.volumes[0].scene.volume.builtin, "buckyball");
  EXPECT_EQ(read.volumes[0].scene.volume.size, 32);
  EXPECT_EQ(read.volumes[0].to_space.point({0, 0, 0}), (Vec3{2, 0, 0}));
  EXPECT_EQ(read.volumes[1].name, "volume[1]");
  EXPECT_TRUE(read.volumes[1].scene.world.has_value());
  EXPECT_TRUE(read.volumes[1].scene.transfer_function.has_value());
  EXPECT_FALSE(read.volumes[1].scene.lighting.on);
  ASSERT_EQ(read.surfaces.size(), 1u);
  const Vec3 first = read_mesh(kScenes / "gem.obj").points.front();
  EXPECT_EQ(read.surfaces[0].mesh.points.front(), (Vec3{first.x, first.y + 1, 2 * first.z}));
  EXPECT_EQ(read.surfaces[0].opacity, 0.5);
  EXPECT_EQ(read.view.width, 20);
  EXPECT_EQ(read.view.samples_per_axis, 2);
  EXPECT_EQ(read.view.step, 0.25);
  EXPECT_EQ(read.view.opacity_threshold, 1);
  EXPECT_EQ(read.overlap_step, 3);
  EXPECT_EQ(read.light, (Vec3{1, 0, 0}));
}

TEST(Composition, CoversMeshesWithVolumes) {
  const Composition read = parsed_composition(R"(
    shell { name: "hair" file: "compose/knot.obj" input: "compose/hairs.scene" volume_size: 24 thickness: 0.2
      repeat_u: 30 repeat_v: 4
            transform { scale { all: 2 } } })");
  ASSERT_EQ(read.shells.size(), 1u);
  const PlacedShell& shell = read.shells[0];
  EXPECT_EQ(shell.name, "hair");
  EXPECT_EQ(shell.scene.world->size, 24);
  EXPECT_EQ(shell.mesh.points.front(), 2 * read_mesh(kScenes / "compose/knot.obj").points.front());
  EXPECT_EQ(shell.mesh.texture_triangles.size(), shell.mesh.triangles.size());
  EXPECT_EQ(shell.settings.thickness, 0.2);
  EXPECT_EQ(shell.settings.repeat_u, 30);
  EXPECT_EQ(shell.settings.repeat_v, 4);
  const std::string fault =
      fault_of("shell { repeat_u: 0 repeat_v: 2000 } shell { file: \"gem.obj\" input: \"x.nrrd\" thickness: -1 }");
  for (const char* part :
       {"shell[0].input: expected a scene, a volume file or builtin:buckyball, got none",
        "shell[0].file: expected a mesh, .obj or .ply, got none",
        "shell[0].thickness: expected a number above 0, got 0", "shell[0].repeat_u: expected 1 to 1000, got 0",
        "shell[0].repeat_v: expected 1 to 1000, got 2000", "shell[1].thickness: expected a number above 0, got -1"}) {
    EXPECT_THAT(fault, HasSubstr(part));
  }
}

TEST(Composition, IsReadOrRefusedHoweverItIsDamaged) {
  const std::string whole =
      R"(volume { name: "a" input: "golden_ring.scene" volume_size: 32 transform { translate { x: 2 } } }
    surface { file: "gem.obj" opacity: 0.5 colour { red: 0.5 } transform { scale { z: 2 } } }
    shell { file: "compose/knot.obj" input: "glass.scene" thickness: 0.1 repeat_u: 3 } camera { eye { z: 5 } }
      step: 0.25)";
  EXPECT_NO_THROW(parsed_composition(whole));
  std::mt19937 random(3);
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    try {
      parsed_composition(damaged(whole, "0123456789-. {}:\"#_", random));
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(Composition, NamesAllItsFaultsByField) {
  const std::string fault = fault_of(R"(
    volume { } volume { input: "none.scene" } volume { input: "a.nrrd" volume_size: 32 }
    volume { input: "builtin:buckyball" volume_size: 2 } volume { input: "a.nrrd" transfer_function: "none.tf" }
    surface { opacity: 2 } surface { file: "none.obj" transform { scale { x: 0 } } }
    step: 0 overlap_step: -1 light { } opacity_threshold: 0)");
  for (const char* part :
       {"volume[0].input: expected a scene, a volume file or builtin:buckyball, got none", "none.scene",
        "volume[2].volume_size: expected none for a volume file, which has its own, got 32",
        "volume[3].volume_size: expected 8 to 1024 voxels, got 2", "none.tf",
        "surface[0].opacity: expected 0 to 1, got 2", "surface[0].file: expected a mesh, .obj or .ply, got none",
        "none.obj", "surface[1].transform[0].scale: expected finite numbers other than 0",
        "step: expected 0.015625 to 16, got 0", "overlap_step: expected 0.015625 to 4096, got -1",
        "light: expected a direction, got 0 0 0", "opacity_threshold: expected 1e-06 to 1, got 0"}) {
    EXPECT_THAT(fault, HasSubstr(part));
  }
  const std::string outside = "expected a file in this file's folder or below";
  for (const std::string part : {"volume { input: \"../view/x.scene\" }", "volume { input: \"/a.nrrd\" }",
                                 "volume { input: \"builtin:buckyball\" transfer_function: \"/etc/passwd\" }",
                                 "surface { file: \"../a.obj\" }", "shell { file: \"../a.obj\" input: \"a.nrrd\" }"}) {
    EXPECT_THAT(fault_of(part), HasSubstr(outside)) << part;
  }
  EXPECT_THAT(fault_of(""), HasSubstr("volume: expected at least one volume, surface or shell, got none"));
  EXPECT_THAT(fault_of("surfaces { }"), HasSubstr("x:1:10: "));
}

}  // namespace
}  // namespace gicube::samples
