#include "compose/composition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gicube::samples {
namespace {

using testing::HasSubstr;

const std::filesystem::path kScenes = GICUBE_SOURCE_DIR "/samples/scenes";

Composition parsed_composition(const std::string& text) { return parse_composition(text, "x", kScenes); }

std::string fault_of(const std::string& text) {
  try {
    parsed_composition(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(Composition, PlacesVolumesAndSurfaces) {
  const Composition read = parsed_composition(R"(
    volume { name: "ball" input: "builtin:buckyball" volume_size: 32 transform { translate { x: 2 } } }
    volume { input: "golden_ring.scene" transfer_function: "ramp" transform { scale { all: 3 } } }
    surface { file: "gem.obj" opacity: 0.5 colour { red: 0.5 } transform { scale { z: 2 } } transform { translate { y: 1 } } }
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
  EXPECT_THAT(fault_of(""), HasSubstr("volume: expected at least one volume or surface, got none"));
  EXPECT_THAT(fault_of("surfaces { }"), HasSubstr("x:1:10: "));
}

}  // namespace
}  // namespace gicube::samples
