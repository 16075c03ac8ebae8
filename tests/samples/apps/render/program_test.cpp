// The program itself, with a private emulated board.
#include <nlohmann/json.hpp>

#include "full_disk.h"
#include "gicube/scene/image_file.h"
#include "gicube/scene/light_field.h"
#include "render_program.h"
#include "scene/names.h"
#include "test.h"

namespace gicube::samples {
namespace {

TEST_F(RenderProgram, DrawsTheBuckyballAndSaysWhatItCost) {
  const ProgramResult result =
      run("builtin:buckyball --volume-size 64 --size 64x48 -o " + path("ball.png") + " --stats " + path("ball.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, HasSubstr("ball.png: frame "));
  EXPECT_THAT(result.out, HasSubstr("bus "));
  EXPECT_GT(colours(path("ball.png"), 64, 48), 100u);

  const auto json = nlohmann::json::parse(text_of(path("ball.json")));
  EXPECT_GT(json.at("frame_ms").get<double>(), 0);
  EXPECT_GT(json.at("load_ms").get<double>(), 0);
  EXPECT_GT(json.at("bus_ms").get<double>(), 0);
  EXPECT_LE(json.at("bus_ms").get<double>(), json.at("frame_ms").get<double>());
  EXPECT_GT(json.at("samples").get<std::uint64_t>(), 1000u);
  EXPECT_EQ(json.at("config_hash").get<std::string>().size(), 16u);
  EXPECT_TRUE(json.at("hit_ratio").is_null());
  EXPECT_TRUE(json.at("counters").contains("dsp.viewing_rays"));
  EXPECT_EQ(json.at("counters").at("dsp.viewing_rays").at("value"), 64 * 48);
}

TEST_F(RenderProgram, TakesAFileWhoseNameIsNoUtf8AndWarnsOfDataThatAreTooLong) {
  const std::string name = path("gr\xfc.nhdr");
  std::ofstream(name) << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 4 4\nencoding: raw\ndata file: v.raw\n";
  std::ofstream(path("v.raw")) << std::string(65, '\x80');
  const ProgramResult result = run(name + " --size 8x8 -o " + path("a.png") + " --stats " + path("a.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.err, StartsWith("gicube-render: warning: " + path("v.raw") +
                                     ": data: expected 64 bytes by the header, got 65"));
  EXPECT_EQ(std::ranges::count(result.err, '\n'), 1);
  EXPECT_THAT(nlohmann::json::parse(text_of(path("a.json"))).at("provenance").at("command").get<std::string>(),
              HasSubstr("/gr\\xfc.nhdr' --size"));
}

TEST_F(RenderProgram, DrawsTheSamePictureOnSeveralBoardsAndSaysWhereTheirTimeWent) {
  const std::string scene = "builtin:buckyball --volume-size 48 --size 40x40 --illumination low ";
  ASSERT_EQ(run(scene + "--quiet -o " + path("one.png")).code, 0);
  const ProgramResult three =
      run(scene + "--board emu:?boards=3 -o " + path("three.png") + " --stats " + path("three.json"));
  ASSERT_EQ(three.code, 0) << three.err;
  EXPECT_THAT(three.out, HasSubstr("3 boards, a shared bus: each works "));
  EXPECT_EQ(pixels_of(path("three.png")), pixels_of(path("one.png")));
  const auto json = nlohmann::json::parse(text_of(path("three.json")));
  EXPECT_EQ(json.at("boards").at("buses"), "shared");
  ASSERT_EQ(json.at("boards").at("each").size(), 3u);
  for (const auto& board : json.at("boards").at("each")) {
    double sum = 0;
    for (const char* part : {"bus_ms", "work_ms", "bus_wait_ms", "skew_ms"}) sum += board.at(part).get<double>();
    EXPECT_NEAR(sum, json.at("frame_ms").get<double>(), 1e-6);
  }
  EXPECT_EQ(json.at("counters").at("dsp.viewing_rays").at("value"), 40 * 40);

  const ProgramResult two = run(scene + "--board emu: --board emu: --own-buses -o " + path("two.png"));
  ASSERT_EQ(two.code, 0) << two.err;
  EXPECT_THAT(two.out, HasSubstr("2 boards, own buses: "));
  EXPECT_EQ(pixels_of(path("two.png")), pixels_of(path("one.png")));
}

TEST_F(RenderProgram, SaysWhatSeveralBoardsDoNotDo) {
  const std::string several =
      "builtin:buckyball --volume-size 32 --size 8x8 --board emu:?boards=2 -o " + path("ball.png");
  for (const char* option : {"--crop", "--level-of-detail 1", "--max-error 0.1"}) {
    const ProgramResult result = run(several + " " + option);
    EXPECT_EQ(result.code, 2) << option;
    EXPECT_THAT(result.err, HasSubstr("several boards: expected without --")) << option;
  }
  EXPECT_THAT(run(several + " --explain-pixel 1,1").err, HasSubstr("--explain-pixel: expected without several boards"));
  EXPECT_THAT(run("builtin:buckyball --board emu:?boards=99 -o " + path("ball.png")).err,
              HasSubstr("URI option boards: expected a number from 1 to 64"));
  EXPECT_THAT(run("builtin:buckyball --board emu: --board unix:" + path("none") + " -o " + path("ball.png")).err,
              HasSubstr("board 2 of 2 (unix:"));
}

TEST_F(RenderProgram, SaysWhatMemoryTheBoardTakesOnItsComputer) {
  const auto peak = [&](const char* edge) {
    const ProgramResult result = run(std::string("builtin:buckyball --size 8x8 --volume-size ") + edge + " -o " +
                                     path("ball.png") + " --stats " + path("ball.json"));
    EXPECT_EQ(result.code, 0) << result.err;
    const auto host = nlohmann::json::parse(text_of(path("ball.json"))).at("host");
    EXPECT_GT(host.at("program_cpu_s").get<double>(), 0);
    return host.at("board_peak_mib").get<double>();
  };
  const double small = peak("32");
  EXPECT_GT(small, 5);                 // MiB: a process has that
  EXPECT_GT(peak("160"), small + 15);  // 160^3 voxels of 36 bits are 17.6 MiB, in whatever layout
}

TEST_F(RenderProgram, DrawsTheSamePictureAtTheCycleLevelAndSaysWhatTheAsicDid) {
  const std::string scene = "builtin:buckyball --volume-size 48 --size 40x40 --quiet -o ";
  ASSERT_EQ(run(scene + path("functional.png")).code, 0);
  const ProgramResult result = run(scene + path("cycle.png") + " --fidelity cycle --stats " + path("cycle.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(pixels_of(path("cycle.png")), pixels_of(path("functional.png")));
  const auto json = nlohmann::json::parse(text_of(path("cycle.json")));
  for (const char* key : {"throughput", "hit_ratio", "memory_utilisation"}) {
    EXPECT_GT(json.at(key).get<double>(), 0) << key;
    EXPECT_LT(json.at(key).get<double>(), 1) << key;
  }
  EXPECT_EQ(json.at("counters").at("processor.samples").at("value"), json.at("samples"));
}

TEST_F(RenderProgram, SaysInItsStatisticsWhichLevelAnswered) {
  const auto answered = [&](const std::string& options) {
    const ProgramResult result = run("builtin:buckyball --volume-size 40 --size 16x16 --quiet --fidelity cycle -o " +
                                     path("a.png") + " --stats " + path("a.json") + " " + options);
    EXPECT_EQ(result.code, 0) << result.err;
    std::map<std::string, int> commands;
    const nlohmann::json statistics = nlohmann::json::parse(text_of(path("a.json")));
    for (const auto& level : statistics.at("fidelity_report")) {
      EXPECT_FALSE(level.at("not_modelled").empty());
      for (const auto& [command, count] : level.at("answered").items()) {
        commands[level.at("level").get<std::string>() + ' ' + command] = count.get<int>();
      }
    }
    return commands;
  };
  EXPECT_EQ(answered(""), (std::map<std::string, int>{{"cycle render", 1}}));
  const auto in_bricks = answered("--set asic.block_voxels=8 --set asic.max_volume_voxels=32");
  EXPECT_EQ(in_bricks.at("cycle render"), 1);
  EXPECT_GT(in_bricks.at("cycle continue"), 0);
  EXPECT_EQ(in_bricks.size(), 2u);
}

TEST_F(RenderProgram, DrawsTheSamePictureForAnyNumberOfThreads) {
  for (const char* threads : {"1", "3"}) {
    const ProgramResult result = run("builtin:buckyball --volume-size 32 --size 32x32 --quiet --threads " +
                                     std::string(threads) + " -o " + path(std::string(threads) + ".png"));
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.out, "");
  }
  EXPECT_GT(colours(path("1.png"), 32, 32), 20u);
  EXPECT_EQ(pixels_of(path("1.png")), pixels_of(path("3.png")));
}

// White fog that is partly seen through, over a dark red.
TEST_F(RenderProgram, CompositesInDisplayValuesOrInLinearLight) {
  std::ofstream(path("haze.scene")) << R"(
    world { size: 16 node { name: "haze" material: "air" box { low { x: -0.5 y: -1 z: -1 } high { x: 1 y: 1 z: 1 } } } }
    material { name: "air" fog { extinction: 0.3 } } shade: false
    camera { eye { x: 0 y: -9 z: 0 } fov_degrees: 10 } image { width: 16 height: 16 })";
  const std::string draw = path("haze.scene") + " --quiet --background 0.2,0,0 -o ";
  const auto made = [&](const std::string& name, const std::string& options) {
    const ProgramResult result = run(draw + path(name) + options);
    EXPECT_EQ(result.code, 0) << result.err;
    return pixel(path(name), 12, 8);
  };
  const auto alpha = [&] {
    EXPECT_EQ(run(path("haze.scene") + " --quiet -o " + path("alpha.exr")).code, 0);
    return pixels_of(path("alpha.exr"))[4 * (8 * 16 + 12) + 3];
  }();
  ASSERT_GT(alpha, 0.2);
  ASSERT_LT(alpha, 0.8);
  const auto plain = made("plain.png", ""), display = made("display.png", " --composite display"),
             linear = made("linear.png", " --composite linear");
  EXPECT_EQ(plain, display);
  EXPECT_NEAR(display[1], alpha, 0.005);  // white over no green
  EXPECT_NEAR(linear[1], display_value(alpha), 0.005);
  EXPECT_NEAR(linear[0], display_value(alpha + (1 - alpha) * linear_light(0.2)), 0.005);
  // An EXR holds linear light of the same two pictures, and no alpha.
  EXPECT_NEAR(made("linear.exr", " --composite linear")[0], linear_light(linear[0]), 0.005);
  EXPECT_NEAR(made("display.exr", " --composite display")[0], linear_light(display[0]), 0.005);
  EXPECT_EQ(pixels_of(path("linear.exr")).size(), 16u * 16 * 3);
  const ProgramResult without = run(path("haze.scene") + " --composite linear -o " + path("a.png"));
  EXPECT_EQ(without.code, 2);
  EXPECT_THAT(without.err, HasSubstr("--composite: expected with --background"));
}

TEST_F(RenderProgram, WritesTheSameBytesByTheSameCommand) {
  const std::string command = "builtin:buckyball --volume-size 24 --size 16x16 --quiet -o " + path("a.png");
  ASSERT_EQ(run(command).code, 0);
  const std::string first = text_of(path("a.png"));
  ASSERT_EQ(run(command).code, 0);
  EXPECT_EQ(text_of(path("a.png")), first);
}

// Of the same scene, whatever camera sees it; another one has another hash.
TEST_F(RenderProgram, TellsInItsStatisticsWhereTheyCameFrom) {
  const auto hash = [&](const std::string& options) {
    const ProgramResult result =
        run("builtin:buckyball --size 8x8 --quiet -o " + path("a.png") + " --stats " + path("a.json") + options);
    EXPECT_EQ(result.code, 0) << result.err;
    const auto from = nlohmann::json::parse(text_of(path("a.json"))).at("provenance");
    EXPECT_EQ(from.at("program"), "gicube-render");
    EXPECT_TRUE(from.at("command").get<std::string>().starts_with("gicube-render builtin:buckyball --size 8x8"));
    return from.at("scene_hash").get<std::string>();
  };
  const std::string small = hash(" --volume-size 24");
  EXPECT_EQ(small.size(), 16u);
  EXPECT_EQ(hash(" --volume-size 24 --eye 100,20,3 --step 1"), small);
  EXPECT_NE(hash(" --volume-size 25"), small);
  EXPECT_NE(hash(" --volume-size 24 --transfer-function ramp"), small);
}

TEST_F(RenderProgram, DrawsASceneFileIntoAnExr) {
  std::ofstream(path("ball.scene")) << "volume { builtin: \"buckyball\" size: 32 }\nimage { width: 24 height: 16 }\n";
  const ProgramResult result = run(path("ball.scene") + " -o " + path("ball.exr"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_GT(colours(path("ball.exr"), 24, 16), 20u);
}

// Light that is known already is shown as colour times light times exposure: a white block in red and blue light.
TEST_F(RenderProgram, ShowsAFieldOfLightInPlaceOfLightingRays) {
  std::ofstream(path("block.scene")) << R"(
    world { size: 16 node { name: "block" material: "chalk" box { low { x: -3 y: -3 z: -3 } high { x: 3 y: 3
      z: 3 } } } }
    material { name: "chalk" solid { colour { red: 0.5 green: 0.5 blue: 0.5 } } scattering: 0.9 bsdf: "diffuse" }
    light { point { position { x: 0 y: -3 z: 0 } } power: 100 }
    camera { eye { x: 0 y: -9 z: 0 } fov_degrees: 10 } illumination { exposure: 2 colour_passes: true })";
  LightField field{{16, 16, 16}, 3, {}};
  for (int i = 0; i < 16 * 16 * 16; ++i) field.values.insert(field.values.end(), {0.6F, 0.0F, 0.2F});
  write_light_field(field, {1, 1, 1}, {}, path("field.nrrd"));
  const std::string shown = path("block.scene") + " --size 16x16 --irradiance " + path("field.nrrd") + " -o ";
  for (const char* set : {"", " --set asic.datapath=wide"}) {
    const ProgramResult result = run(shown + path("field.png") + set);
    ASSERT_EQ(result.code, 0) << result.err;
    const auto seen = pixel(path("field.png"), 8, 8);
    EXPECT_NEAR(seen[0], 0.5 * 0.6 * 2, 0.01);
    EXPECT_EQ(seen[1], 0);
    EXPECT_NEAR(seen[2], 0.5 * 0.2 * 2, 0.01);
  }
  ASSERT_EQ(run(shown + path("half.png") + " --exposure 1").code, 0);
  EXPECT_NEAR(pixel(path("half.png"), 8, 8)[0], 0.5 * 0.6, 0.01);

  const ProgramResult both = run(shown + path("a.png") + " --illumination low");
  EXPECT_EQ(both.code, 2);
  EXPECT_THAT(both.err, HasSubstr("--irradiance: expected it or --illumination, got both"));
  const ProgramResult other = run(shown + path("a.png") + " --volume-size 20");
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.err,
              HasSubstr("--irradiance: expected a field of the volume's 20 x 20 x 20 voxels, got 16 x 16 x 16"));
}

TEST_F(RenderProgram, SaysOnceOfEachReasonWhyNothingIsVisible) {
  std::ofstream(path("mask.raw"), std::ios::binary)
      << std::string(8 * 8 * 8 / 2, '\0') + std::string(8 * 8 * 8 / 2, '\1');
  const std::string mask = path("mask.raw") + " --dims 8,8,8 --size 8x8 -o " + path("a.png") + " --stats " +
                           path("a.json") + " --transfer-function " + path("dense.tf");
  std::ofstream(path("dense.tf")) << "colour 0 1 1 1\nopacity 25.5 0\nopacity 255 1\n";
  const ProgramResult empty = run(mask);
  ASSERT_EQ(empty.code, 0) << empty.err;
  const std::string why =
      "nothing is visible in the picture: voxels have values of 0 to 1, the transfer function has "
      "opacity at 25.5 to 255 alone (a mask? load it with its own range of values)";
  EXPECT_EQ(empty.err, "gicube-render: warning: " + why + "\n");
  EXPECT_EQ(nlohmann::json::parse(text_of(path("a.json"))).at("invisible"), why);
  EXPECT_EQ(run(mask + " --quiet").err, "");

  const std::string ball = "builtin:buckyball --volume-size 16 --size 8x8 -o " + path("a.png");
  const ProgramResult cut = run(ball + " --cut 1,0,0,900 --frames 3 --fps 1");
  ASSERT_EQ(cut.code, 0) << cut.err;
  EXPECT_EQ(cut.err, "gicube-render: warning: nothing is visible in the picture: all that is visible is cut away\n");
  EXPECT_EQ(run(ball + " --cut 1,0,0,8").err, "");
}

TEST_F(RenderProgram, SaysOnceWhichFieldsOfTheHardwareItsLevelDoesNotModel) {
  std::ofstream(path("board.textproto"))
      << "asic { processors: 2 core_khz: 50000 } dsp { clock_khz: 100000 } link { bits: 8 }";
  const std::string ball = "builtin:buckyball --volume-size 16 --size 8x8 -o " + path("a.png");
  const auto said = [&](const std::string& options) {
    const ProgramResult result = run(ball + options);
    EXPECT_EQ(result.code, 0) << result.err;
    return result.err;
  };
  EXPECT_EQ(said(" --set asic.queue_rays=512 --set bus.model=agp2x --frames 2 --fps 1"),
            "gicube-render: warning: asic.queue_rays: not modelled at the level functional; --fidelity cycle models "
            "what is set\n");
  EXPECT_THAT(said(" --set sorter.policy=longest_wait --config " + path("board.textproto")),
              HasSubstr("warning: sorter.policy, asic.processors, asic.core_khz and 1 more: not modelled"));
  for (const char* options : {" --fidelity cycle --set asic.queue_rays=512", " --set dsp.clock_khz=100000",
                              " --set asic.queue_rays=512 --quiet"}) {
    EXPECT_EQ(said(options), "") << options;
  }
}

TEST_F(RenderProgram, FailsWithOneLineAndCodeTwoForWrongUsage) {
  for (const char* arguments :
       {"", "builtin:buckyball --size huge", "builtin:buckyball --board pci:0", "builtin:buckyball --fidelity exact",
        "builtin:buckyball --board unix:/nowhere --set asic.processors=8"}) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_THAT(result.err, HasSubstr("gicube-render: "));
  }
}

TEST_F(RenderProgram, FailsWithOneLineAndCodeOneForWhatIsNotThere) {
  const std::string small = "builtin:buckyball --volume-size 16 --size 8x8 -o " + path("a.png");
  for (const std::string& arguments :
       {std::string("/nowhere/head.nrrd"), std::string("/nowhere/a.scene"), small + " --board unix:/nowhere/socket",
        small + " --transfer-function ct-bnoe", small + " --stats /nowhere/a.json",
        std::string("builtin:buckyball --volume-size 16 --size 8x8 -o /nowhere/a.png")}) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, 1) << arguments << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
}

TEST_F(RenderProgram, SaysHowLongAnEdgeMayBe) {
  std::ofstream(path("long.raw")) << std::string(1100 * 2 * 2, 'a');
  const ProgramResult result = run(path("long.raw") + " --dims 1100,2,2 -o " + path("a.png"));
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("at most 1024 voxels an edge, got 1100 x 2 x 2"));
}

TEST_F(RenderProgram, RendersAVolumeThatTheCardDoesNotStoreWholeWithTheSameBits) {
  const std::string picture = "builtin:buckyball --volume-size 72 --size 40x40 --set asic.block_voxels=8 -o ";
  const ProgramResult small = run(picture + path("small.png") + " --set asic.max_volume_voxels=32");
  const ProgramResult large = run(picture + path("large.png") + " --set asic.max_volume_voxels=128");
  ASSERT_EQ(small.code, 0) << small.err;
  ASSERT_EQ(large.code, 0) << large.err;
  EXPECT_EQ(pixels_of(path("small.png")), pixels_of(path("large.png")));
}

TEST_F(RenderProgram, FailsAndLeavesNothingOnAFullDisk) {
  const std::string small = "builtin:buckyball --volume-size 24 --size 32x32 --quiet -o ";
  const auto expect_nothing = [&](const std::string& arguments, const std::string& told) {
    const ProgramResult result = [&] {
      const reference::FileSizeLimit limit(300);
      return run(arguments);
    }();
    EXPECT_EQ(result.code, 1) << arguments;
    EXPECT_THAT(result.err, HasSubstr(told));
    for (const auto& entry : std::filesystem::directory_iterator(path(""))) {
      EXPECT_THAT(entry.path().filename().string(), testing::AnyOf("stdout", "stderr"));
    }
  };
  expect_nothing(small + path("a.png"), "a.png: file: expected a place to write to, got File too large");
  expect_nothing(small + path("a.exr"), "a.exr: file: expected a place to write to, got File too large");
  ::setenv("GICUBE_CAPTURE", path("session.cap").c_str(), 1);
  expect_nothing(small + path("a.png"), "capture: " + path("session.cap") + ": File too large");
  ::unsetenv("GICUBE_CAPTURE");
}

TEST_F(RenderProgram, RefusesItsPicturesNameForItsStatistics) {
  const std::string scene = "builtin:buckyball --volume-size 24 --size 8x8 -o ";
  for (const std::string& arguments :
       {path("a.png") + " --stats " + path("a.png"), path("a.png") + " --frames 3 --stats " + path("a_0001.png")}) {
    const ProgramResult result = run(scene + arguments);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_THAT(result.err, HasSubstr("--stats: expected another file than --output"));
    EXPECT_FALSE(std::filesystem::exists(path("a.png")));
  }
}

TEST_F(RenderProgram, WritesStatisticsToStandardOutput) {
  const std::string command =
      "builtin:buckyball --volume-size 24 --size 8x8 --quiet -o " + path("a.png") + " --stats /dev/stdout";
  const ProgramResult result = run(command);
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(nlohmann::json::parse(result.out).contains("frame_ms"));
  run(command + " | cat >" + path("piped") + "; true");
  EXPECT_TRUE(nlohmann::json::parse(text_of(path("piped"))).contains("frame_ms"));
}

}  // namespace
}  // namespace gicube::samples
