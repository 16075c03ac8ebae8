#include "render/options.h"

#include "gicube/scene/error.h"
#include "test.h"

namespace gicube::samples {
namespace {

std::optional<RenderOptions> parse(std::vector<const char*> arguments, std::ostream& out) {
  arguments.insert(arguments.begin(), "gicube-render");
  return parse_options(static_cast<int>(arguments.size()), arguments.data(), out);
}

RenderOptions parse(std::vector<const char*> arguments) {
  std::ostringstream out;
  return parse(std::move(arguments), out).value();
}

// The text of the UsageError, or "none".
std::string fault_of(std::vector<const char*> arguments) {
  return message_of<UsageError>([&] { scene_of(parse(std::move(arguments))); });
}

TEST(RenderOptions, MakeASceneOfTheBuiltinVolume) {
  const RenderOptions options =
      parse({"builtin:buckyball", "--volume-size", "64", "--size", "320x200", "--samples", "2", "--filter", "tent",
             "--step", "0.25", "--threshold", "0.9", "--jitter", "--no-leap", "--no-shade"});
  const Scene scene = scene_of(options);
  EXPECT_EQ(scene.volume.builtin, "buckyball");
  EXPECT_EQ(scene.volume.size, 64);
  EXPECT_EQ(scene.view.width, 320);
  EXPECT_EQ(scene.view.height, 200);
  EXPECT_EQ(scene.view.samples_per_axis, 2);
  EXPECT_EQ(scene.view.filter, PixelFilter::kTent);
  EXPECT_EQ(scene.view.step, 0.25);
  EXPECT_EQ(scene.view.opacity_threshold, 0.9);
  EXPECT_TRUE(scene.view.jitter);
  EXPECT_FALSE(scene.view.leap);
  EXPECT_FALSE(scene.view.shade);
}

TEST(RenderOptions, TakeVectorsThatBeginWithAMinus) {
  const Scene scene = scene_of(parse(
      {"head.nrrd", "--eye", "-1,-2,-3", "--look-at=-4,5,6", "--up", "-1,0,0", "--light", "-1,2,3", "--fov", "20"}));
  EXPECT_EQ(scene.volume.file, "head.nrrd");
  EXPECT_EQ(scene.camera.eye, (Vec3{-1, -2, -3}));
  EXPECT_EQ(scene.camera.look_at, (Vec3{-4, 5, 6}));
  EXPECT_EQ(scene.camera.up, (Vec3{-1, 0, 0}));
  EXPECT_EQ(scene.light, (Vec3{-1, 2, 3}));
  EXPECT_EQ(scene.camera.fov_degrees, 20);
}

TEST(RenderOptions, DescribeAFileWithoutHeader) {
  const Scene scene = scene_of(
      parse({"a.raw", "--dims", "4,5,6", "--type", "int16", "--big-endian", "--skip", "16", "--spacing", "1,1,2.5"}));
  ASSERT_TRUE(scene.volume.raw);
  EXPECT_EQ(scene.volume.raw->dims, (Dims{4, 5, 6}));
  EXPECT_EQ(scene.volume.raw->type, SampleType::kInt16);
  EXPECT_TRUE(scene.volume.raw->big_endian);
  EXPECT_EQ(scene.volume.raw->skip_bytes, 16u);
  EXPECT_EQ(scene.volume.spacing, (Vec3{1, 1, 2.5}));
}

TEST(RenderOptions, RepeatCutsAndSettings) {
  const RenderOptions options = parse(
      {"a.nrrd", "--cut", "1,0,0,5", "--cut", "-1,0,0,-20", "--set", "asic.processors=8", "--set", "bus.model=agp2x"});
  ASSERT_EQ(options.cut_planes.size(), 2u);
  EXPECT_EQ(options.cut_planes[1].normal, (Vec3{-1, 0, 0}));
  EXPECT_EQ(options.cut_planes[1].offset, -20);
  EXPECT_EQ(options.board.settings, (std::vector<std::string>{"asic.processors=8", "bus.model=agp2x"}));
}

TEST(RenderOptions, ChangePhongCoefficientsOneByOne) {
  Phong phong{0.1, 0.2, 0.3, 4};
  set_phong(parse({"a.nrrd", "--specular", "0.9"}), phong);
  EXPECT_EQ(phong.ambient, 0.1);
  EXPECT_EQ(phong.specular, 0.9);
}

TEST(RenderOptions, LightASceneThatHasNoLightsYet) {
  const Scene scene =
      scene_of(parse({"head.nrrd", "--illumination", "high", "--rules", "as-printed", "--light-rays", "12",
                      "--lifetime", "7", "--exposure", "0.5", "--seed", "99", "--light", "0,0,1"}));
  EXPECT_TRUE(scene.lighting.on);
  EXPECT_EQ(scene.lighting.settings.albedo, Albedo::kHigh);
  EXPECT_EQ(scene.lighting.settings.rules, EnergyRules::kAsPrinted);
  EXPECT_EQ(scene.lighting.settings.rays_per_face_voxel, 12);
  EXPECT_EQ(scene.lighting.settings.lifetime, 7);
  EXPECT_EQ(scene.lighting.settings.seed, 99u);
  EXPECT_EQ(scene.lighting.exposure, 0.5);
  EXPECT_EQ(scene.view.lifetime, 7);
  EXPECT_EQ(scene.view.seed, 99u);
  EXPECT_FALSE(scene_of(parse({"head.nrrd"})).lighting.on);
}

TEST(RenderOptions, ChangeTheSizeLightAndCameraOfAScene) {
  const std::string file = testing::TempDir() + "/lit.scene";
  std::ofstream(file) << R"(world { size: 64 node { material: "m" sphere { } } } material { name: "m" }
    illumination { albedo: "high" seed: 3 } camera { name: "a" eye { x: 5 } } camera { name: "b" eye { x: 6 } }
    engine { target: "camera[b].eye.x" start: 6 rate: 2 })";
  const Scene scene =
      scene_of(parse({file.c_str(), "--volume-size", "32", "--illumination", "none", "--camera", "b", "--time", "3"}));
  EXPECT_EQ(scene.world->size, 32);
  EXPECT_FALSE(scene.lighting.on);
  EXPECT_EQ(scene.lighting.settings.seed, 3u);
  EXPECT_EQ(scene.camera.eye, (Vec3{12, 0, 0}));
  EXPECT_THAT(fault_of({file.c_str(), "--spacing", "1,1,2"}), HasSubstr("--spacing"));
  EXPECT_THROW(scene_of(parse({file.c_str(), "--camera", "c"})), InputError);
}

TEST(RenderOptions, NumberTheFilesAndSpaceTheTimesOfAnAnimation) {
  const RenderOptions by_rate = parse({"a.scene", "--frames", "3", "--fps", "4", "--time", "1", "-o", "x/out.png"});
  EXPECT_EQ(frame_times(by_rate.animation), (std::vector<double>{1, 1.25, 1.5}));
  EXPECT_EQ(frame_file(by_rate.output, by_rate.animation, 2), "x/out_0002.png");
  EXPECT_EQ(frame_times(parse({"a.scene", "--frames", "4", "--duration", "2"}).animation),
            (std::vector<double>{0, 0.5, 1, 1.5}));
  const RenderOptions one = parse({"a.scene", "-o", "out.exr"});
  EXPECT_EQ(frame_file(one.output, one.animation, 0), "out.exr");
}

TEST(RenderOptions, AreRefusedWithTheOptionsName) {
  const std::pair<std::vector<const char*>, const char*> cases[] = {
      {{}, "INPUT"},
      {{"a.nrrd", "--eye", "1,2"}, "--eye"},
      {{"a.nrrd", "--size", "512"}, "--size"},
      {{"a.nrrd", "--size", "5000x5"}, "--size"},
      {{"a.nrrd", "--samples", "3"}, "--samples"},
      {{"a.nrrd", "--filter", "gauss"}, "--filter"},
      {{"a.nrrd", "--step", "0"}, "--step"},
      {{"a.nrrd", "--fov", "30", "--orthographic", "5"}, "--orthographic"},
      {{"a.nrrd", "--light", "0,0,0"}, "--light"},
      {{"a.nrrd", "--background", "1,2,3"}, "--background"},
      {{"a.nrrd", "-o", "a.jpg"}, "--output"},
      {{"a.nrrd", "-o", "a.exr", "--background", "1,0,0"}, "--composite"},
      {{"a.nrrd", "--composite", "screen"}, "--composite"},
      {{"a.nrrd", "--composite", "linear", "--background", "none"}, "--composite"},
      {{"a.nrrd", "--type", "int12"}, "--type"},
      {{"a.raw", "--type", "int16"}, "--dims"},
      {{"a.nrrd", "--volume-size", "64"}, "--volume-size"},
      {{"builtin:buckyball", "--dims", "4,4,4"}, "--dims"},
      {{"builtin:buckyball", "--volume-size", "8"}, "--volume-size"},
      {{"builtin:teapot"}, "builtin:teapot"},
      {{"a.nrrd", "--threads", "-1"}, "--threads"},
      {{"a.nrrd", "--config", "/nowhere/board.cfg"}, "--config"},
      {{"a.nrrd", "--colour", "3"}, "--colour"},
      {{"a.nrrd", "b.nrrd"}, "b.nrrd"},
      {{"a.nrrd", "--illumination", "medium"}, "--illumination"},
      {{"a.nrrd", "--rules", "nice"}, "--rules"},
      {{"a.nrrd", "--light-rays", "0"}, "--light-rays"},
      {{"a.nrrd", "--lifetime", "1024"}, "--lifetime"},
      {{"a.nrrd", "--exposure", "-1"}, "--exposure"},
      {{"a.nrrd", "--mpi=pictures"}, "--mpi: expected rays"},
      {{"a.nrrd", "--frames", "0"}, "--frames"},
      {{"a.nrrd", "--fps", "25"}, "--frames"},
      {{"a.nrrd", "--frames", "2", "--fps", "25", "--duration", "1"}, "--fps"},
  };
  for (const auto& [arguments, name] : cases) EXPECT_THAT(fault_of(arguments), HasSubstr(name));
}

TEST(RenderOptions, PrintHelpAndVersion) {
  std::ostringstream help, version;
  EXPECT_FALSE(parse({"--help"}, help));
  for (const char* option : {"--eye", "--orthographic", "--transfer-function", "--board", "--fidelity", "--stats",
                             "--seed", "ct-bone", "--illumination", "--frames"}) {
    EXPECT_THAT(help.str(), HasSubstr(option));
  }
  EXPECT_FALSE(parse({"--version"}, version));
  EXPECT_THAT(version.str(), HasSubstr("gicube-render 0."));
}

}  // namespace
}  // namespace gicube::samples
