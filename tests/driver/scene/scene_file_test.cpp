#include "gicube/scene/scene.h"

#include "gicube/scene/error.h"
#include "scene_faults.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::scene {
namespace {

using testing::Not;

TEST(SceneFile, FillsEveryPartOfTheScene) {
  const Scene scene = parse_scene(R"(
    volume { file: "head.raw" spacing: [1, 1, 2.5] raw { dims: [64, 32, 16] type: "int16" big_endian: true
      skip_bytes: 8 } }
    transfer_function { colour { value: 10 colour { red: 1 green: 0.5 blue: 0 } } opacity { value: 5 opacity: 0 }
                        opacity { value: 20.25 opacity: 1 } }
    phong { ambient: 0.1 shininess: 50 }
    light { towards { x: 1 z: 2 } }
    camera { eye { x: 1 y: 2 z: 3 } look_at { x: 4 } up { y: 1 } orthographic_height: 99 }
    cut_plane { normal { x: 1 } offset: 7 }
    image { width: 320 height: 200 samples_per_axis: 2 }
    step: 0.25 opacity_threshold: 0.9 shade: false jitter: true)",
                                  "a.scene", "/data");
  EXPECT_EQ(scene.volume.file, "/data/head.raw");
  ASSERT_TRUE(scene.volume.raw);
  EXPECT_EQ(scene.volume.raw->dims, (Dims{64, 32, 16}));
  EXPECT_EQ(scene.volume.raw->type, SampleType::kInt16);
  EXPECT_TRUE(scene.volume.raw->big_endian);
  EXPECT_EQ(scene.volume.raw->skip_bytes, 8u);
  EXPECT_EQ(scene.volume.spacing, (Vec3{1, 1, 2.5}));
  ASSERT_TRUE(scene.transfer_function);
  EXPECT_EQ(scene.transfer_function->function.colours[0].colour, (Colour{1, 0.5, 0}));
  EXPECT_EQ(scene.transfer_function->function.opacities[1].value, 20.25);
  EXPECT_EQ(scene.phong->ambient, 0.1);
  EXPECT_EQ(scene.phong->diffuse, Phong{}.diffuse);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(std::get<DirectionalLight>(scene.lights[0].light).towards, (Vec3{1, 0, 2}));
  EXPECT_EQ(scene.camera.eye, (Vec3{1, 2, 3}));
  EXPECT_EQ(scene.camera.look_at, (Vec3{4, 0, 0}));
  EXPECT_EQ(scene.camera.up, (Vec3{0, 1, 0}));
  EXPECT_EQ(scene.camera.orthographic_height, 99);
  EXPECT_FALSE(scene.camera.fov_degrees);
  ASSERT_EQ(scene.view.cut_planes.size(), 1u);
  EXPECT_EQ(scene.view.cut_planes[0].offset, 7);
  EXPECT_EQ(scene.view.width, 320);
  EXPECT_EQ(scene.view.height, 200);
  EXPECT_EQ(scene.view.samples_per_axis, 2);
  EXPECT_EQ(scene.view.step, 0.25);
  EXPECT_EQ(scene.view.opacity_threshold, 0.9);
  EXPECT_FALSE(scene.view.shade);
  EXPECT_TRUE(scene.view.jitter);
}

TEST(SceneFile, HasTheDefaultsOfTheSchemaThatAreThoseOfTheView) {
  const Scene scene = parse_scene("volume { builtin: \"buckyball\" }", "a.scene", "");
  const View view;
  EXPECT_EQ(scene.volume.size, 256);
  EXPECT_EQ(scene.view.width, view.width);
  EXPECT_EQ(scene.view.height, view.height);
  EXPECT_EQ(scene.view.step, view.step);
  EXPECT_EQ(scene.view.opacity_threshold, view.opacity_threshold);
  EXPECT_EQ(scene.view.shade, view.shade);
  EXPECT_EQ(scene.view.jitter, view.jitter);
  EXPECT_FALSE(scene.phong);
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_FALSE(scene.lighting.on);
  EXPECT_FALSE(scene.transfer_function);
}

TEST(SceneFile, ReportsUnknownFieldsWithTheirLinesAndGoesOn) {
  const std::string faults = faults_of("volume { builtin: \"buckyball\"\n  colour: 3 }\nfog: 2\nstep: 100\n");
  EXPECT_THAT(faults, HasSubstr("a.scene:2:"));
  EXPECT_THAT(faults, HasSubstr("\"colour\""));
  EXPECT_THAT(faults, HasSubstr("a.scene:3:"));
  EXPECT_THAT(faults, HasSubstr("\"fog\""));
  EXPECT_THAT(faults, Not(HasSubstr("step"))) << "a text that is not understood has no meaning to be judged";
}

TEST(SceneFile, ReportsASyntaxErrorWithItsLine) {
  EXPECT_THAT(faults_of("volume { builtin: \"buckyball\" }\nstep: 0.5 0.7"), HasSubstr("a.scene:2:"));
  EXPECT_THAT(faults_of("step: \"half\""), HasSubstr("a.scene:1:"));
}

TEST(SceneFile, ReportsAllFaultsOfMeaningTogether) {
  const std::string faults = faults_of(R"(
    volume { file: "a" builtin: "teapot" size: 4 spacing: [1, 0] raw { dims: [1, 2] type: "int12" } }
    transfer_function { preset: "ct-bone" file: "b.tf" }
    phong { ambient: -1 shininess: 0.5 }
    light { towards { } }
    camera { up { } fov_degrees: 200 orthographic_height: 3 eye { } look_at { } }
    cut_plane { normal { x: nan } }
    cut_plane { }
    image { width: 0 height: 5000 samples_per_axis: 3 }
    opacity_threshold: 1.5)");
  for (const char* fault :
       {"volume: expected either builtin or file, got both",
        "volume.builtin: expected \"buckyball\", got \"teapot\"",
        "volume.size: expected 16 to 1024, got 4",
        "volume.spacing: expected 3 numbers, x y z, got 2",
        "volume.spacing: expected numbers above 0, got 0",
        "volume.raw.dims: expected 3 numbers, x y z, got 2",
        "volume.raw: type: expected uint8, uint12, uint16, int16 or float32, got \"int12\"",
        "transfer_function: expected one of file, preset, and points of colour and opacity, got several",
        "phong.ambient: expected 0 to 1.99, got -1",
        "phong.shininess: expected 1 to 1000, got 0.5",
        "light[0].towards: expected a direction, got 0 0 0",
        "camera.up: expected a direction, got 0 0 0",
        "camera.fov_degrees: expected more than 0 and less than 180, got 200",
        "camera: expected fov_degrees or orthographic_height, got both",
        "camera.look_at: expected another point than camera.eye, got the same",
        "cut_plane[0].normal: expected finite numbers, got nan 0 0",
        "cut_plane[1].normal: expected a direction, got 0 0 0",
        "image.width: expected 1 to 4095, got 0",
        "image.height: expected 1 to 4095, got 5000",
        "image.samples_per_axis: expected 1, 2 or 4, got 3",
        "opacity_threshold: expected 0 to 1, got 1.5"}) {
    EXPECT_THAT(faults, HasSubstr("a.scene: " + std::string(fault)));
  }
}

TEST(SceneFile, NeedsAVolume) {
  EXPECT_THAT(faults_of("step: 1"), HasSubstr("a.scene: volume: expected a volume or a world, got none"));
}

TEST(SceneFile, ReportsFaultsInsideItsTransferFunction) {
  const std::string volume = "volume { builtin: \"buckyball\" } ";
  EXPECT_THAT(faults_of(volume + "transfer_function { preset: \"none\" }"), HasSubstr("ct-bone"));
  EXPECT_THAT(faults_of(volume + "transfer_function { file: \"not-there.tf\" }"), HasSubstr("/data/not-there.tf"));
  EXPECT_THAT(faults_of(volume + "transfer_function { colour { value: 1 } opacity { opacity: 1 } }"),
              HasSubstr("missing"));
}

// Names that lead out of the folder, whether there is anything or not; nothing of what is there comes back.
TEST(SceneFile, NamesFilesInItsFolderAndBelowOnly) {
  const reference::TemporaryDirectory folder;
  const std::filesystem::path all = folder.path(), own = all / "own";
  std::filesystem::create_directories(own / "below");
  const std::string look = "values absolute\ncolour 0 1 0 0\nopacity 0 0\nopacity 9 1\n";
  for (const auto& file : {own / "a.tf", own / "below" / "b.tf", all / "out.tf"}) std::ofstream(file) << look;
  std::ofstream(all / "secret") << "root:x:0\n";
  std::filesystem::create_symlink(all / "secret", own / "link");
  const auto scene = [](const std::string& part, const std::string& name) {
    const std::string file = " { file: \"" + name + "\" }";
    if (part == "volume") return "volume" + file;
    if (part == "mesh")
      return "world { node { name: \"n\" material: \"m\" mesh" + file + " } } material { name: \"m\" }";
    return "volume { builtin: \"buckyball\" } transfer_function" + file;
  };
  for (const std::string part : {"volume", "mesh", "transfer_function"}) {
    for (const std::string& name : {(all / "secret").string(), std::string("../secret"), std::string("../none"),
                                    std::string("none/../../secret"), std::string("link"), std::string("/dev/zero")}) {
      try {
        parse_scene(scene(part, name), "a.scene", own);
        ADD_FAILURE() << part << " " << name;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr(part + ".file: expected a file in this file's folder or below")) << name;
        EXPECT_THAT(error.what(), Not(HasSubstr("root"))) << name;
        EXPECT_EQ(error.faults().size(), 1u) << error.what();
      }
    }
  }
  for (const std::string name : {"a.tf", "below/b.tf", "./below/../a.tf", "../own/a.tf"}) {
    EXPECT_NO_THROW(parse_scene(scene("transfer_function", name), "a.scene", own)) << name;
  }
  EXPECT_NO_THROW(parse_scene(scene("transfer_function", "../out.tf"), "a.scene", own, true));
  EXPECT_FALSE(parse_scene(scene("volume", "a.nhdr"), "a.scene", own).volume.allow_outside);
  EXPECT_TRUE(parse_scene(scene("volume", "../a.nhdr"), "a.scene", own, true).volume.allow_outside);
}

TEST(SceneFile, IsNamedInTheErrorIfItIsNotThere) { EXPECT_THROW(read_scene("/nowhere/a.scene"), InputError); }

}  // namespace
}  // namespace gicube::scene
