// gicube-render: pictures that go on from a checkpoint.
#include <nlohmann/json.hpp>

#include "render_program.h"
#include "test.h"

namespace gicube::samples {
namespace {

class CheckpointProgram : public RenderProgram {
 protected:
  CheckpointProgram() {
    std::ofstream(path("turning.scene")) << R"(
        world { size: 24 node { material: "ball" sphere { radius: 1 } } }
        material { name: "ball" solid { opacity: 0.3 } bsdf: "isotropic" scattering: 0.4 }
        camera { name: "c" eye { x: 5 y: -4 z: 2 } } image { width: 24 height: 24 }
        light { point { position { z: 4 } } power: 100 } illumination { }
        engine { target: "camera.eye.x" rate: 1 })";
  }
  std::string scene() const { return path("turning.scene") + " --fidelity cycle --frames 4 --duration 4 "; }
  static nlohmann::json frames(const std::string& file) { return nlohmann::json::parse(text_of(file)).at("frames"); }
};

TEST_F(CheckpointProgram, GoesOnWithTheSamePicturesTimesAndCounters) {
  ASSERT_EQ(run(scene() + "-o " + path("whole.png") + " --stats " + path("whole.json")).code, 0);
  const auto whole = frames(path("whole.json"));
  const ProgramResult stopped =
      run(scene() + "-o " + path("first.png") + " --checkpoint-at frame=2 --checkpoint " + path("saved"));
  ASSERT_EQ(stopped.code, 0) << stopped.err;
  EXPECT_EQ(pixels_of(path("first_0003.png")), pixels_of(path("whole_0003.png")));
  const ProgramResult rest = run(scene() + "-o " + path("rest.png") + " --restore " + path("saved") +
                                 " --first-frame 2 --stats " + path("rest.json"));
  ASSERT_EQ(rest.code, 0) << rest.err;
  EXPECT_FALSE(std::filesystem::exists(path("rest_0001.png")));
  const auto frames_of_rest = frames(path("rest.json"));
  ASSERT_EQ(frames_of_rest.size(), 2u);
  for (const std::size_t i : {2u, 3u}) {
    const std::string number = "_000" + std::to_string(i) + ".png";
    EXPECT_EQ(pixels_of(path("rest" + number)), pixels_of(path("whole" + number)));
    for (const char* key :
         {"frame_ms", "bus_ms", "samples", "hit_ratio", "memory_gb_s", "dsp_utilisation", "config_hash", "time"}) {
      EXPECT_EQ(frames_of_rest.at(i - 2).at(key), whole.at(i).at(key)) << key << i;
    }
  }
  EXPECT_EQ(nlohmann::json::parse(text_of(path("rest.json"))).at("illumination_passes"), 0);
}

TEST_F(CheckpointProgram, OfOnePictureGoesOnToTheSameCounters) {
  const std::string one = path("turning.scene") + " --fidelity cycle --quiet -o ";
  ASSERT_EQ(
      run(one + path("a.png") + " --checkpoint-at frame=0 --checkpoint " + path("saved") + " --stats " + path("a.json"))
          .code,
      0);
  ASSERT_EQ(run(one + path("b.png") + " --restore " + path("saved") + " --stats " + path("b.json")).code, 0);
  EXPECT_EQ(pixels_of(path("a.png")), pixels_of(path("b.png")));
  const auto a = nlohmann::json::parse(text_of(path("a.json"))), b = nlohmann::json::parse(text_of(path("b.json")));
  for (const char* key : {"counters", "frame_ms", "samples"}) EXPECT_EQ(a.at(key), b.at(key)) << key;
}

TEST_F(CheckpointProgram, WritesAtATimeOrARayAndSaysIfThatNeverComes) {
  const auto restored = [this](const std::string& when, int first) {
    const ProgramResult written =
        run(scene() + "-o " + path("a.png") + " --checkpoint-at " + when + " --checkpoint " + path("saved"));
    EXPECT_EQ(written.code, 0) << written.err;
    const ProgramResult rest = run(scene() + "-o " + path("b.png") + " --restore " + path("saved") + " --first-frame " +
                                   std::to_string(first));
    EXPECT_EQ(rest.code, 0) << rest.err;
    EXPECT_EQ(pixels_of(path("b_0003.png")), pixels_of(path("a_0003.png")));
  };
  restored("ray=1200", 2);  // 576 a picture
  restored("time=0", 0);
  const ProgramResult never =
      run(scene() + "-o " + path("a.png") + " --checkpoint-at time=1e9 --checkpoint " + path("none"));
  EXPECT_EQ(never.code, 1);
  EXPECT_THAT(never.err, HasSubstr("--checkpoint-at: expected a time or a ray before the last picture"));
  EXPECT_FALSE(std::filesystem::exists(path("none")));
}

TEST_F(CheckpointProgram, GoesOnWithAnotherBusAtABoardOfItsOwn) {
  ASSERT_EQ(run(scene() + "-o " + path("a.png") + " --checkpoint-at frame=0 --checkpoint " + path("saved")).code, 0);
  const auto frame_ms = [this](const std::string& options) {
    const ProgramResult result =
        run(scene() + "-o " + path("b.png") + " --restore " + path("saved") + options + " --stats " + path("b.json"));
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(pixels_of(path("b_0000.png")), pixels_of(path("a_0000.png")));
    return frames(path("b.json")).at(0).at("frame_ms").get<double>();
  };
  EXPECT_LT(frame_ms(" --set bus.model=agp4x"), frame_ms(""));
  const ProgramResult other =
      run(scene() + "-o " + path("b.png") + " --restore " + path("saved") + " --set asic.processors=2");
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("asic.processors: expected 4, as in the checkpoint, got 2"));
}

TEST_F(CheckpointProgram, RefusesWhatNoCheckpointServes) {
  std::ofstream(path("empty")) << "nothing";
  const std::pair<std::string, const char*> cases[] = {
      {"--checkpoint a", "--checkpoint: expected --checkpoint-at WHEN beside it"},
      {"--checkpoint-at frame=0", "--checkpoint-at: expected --checkpoint FILE beside it"},
      {"--checkpoint a --checkpoint-at frame=4", "--checkpoint-at: expected one of the pictures 0 to 3, got 4"},
      {"--checkpoint a --checkpoint-at soon",
       "--checkpoint-at: expected frame=N, time=MS or ray=N, from 0, got \"soon\""},
      {"--checkpoint a --checkpoint-at ray=1.5", "--checkpoint-at: expected frame=N"},
      {"--checkpoint a --checkpoint-at frame=0 --crop", "--checkpoint: expected without --crop"},
      {"--first-frame 1", "--first-frame: expected --restore FILE beside it"},
      {"--restore " + path("empty") + " --colour-passes", "--restore: expected without --colour-passes"},
      {"--restore " + path("empty") + " --first-frame 4", "--first-frame: expected less than --frames, 4, got 4"},
      {"--restore " + path("empty"), "checkpoint: file: expected a checkpoint with its checksum"}};
  for (const auto& [options, words] : cases) {
    const ProgramResult result = run(scene() + "-o " + path("a.png ") + options);
    EXPECT_EQ(result.code, 2) << options;
    EXPECT_THAT(result.err, HasSubstr(words)) << options;
  }
}

TEST_F(CheckpointProgram, RefusesTheCheckpointOfAnotherVolume) {
  ASSERT_EQ(run(scene() + "-o " + path("a.png") + " --checkpoint-at frame=0 --checkpoint " + path("saved")).code, 0);
  const ProgramResult other =
      run("builtin:buckyball --volume-size 32 --size 8x8 -o " + path("b.png") + " --restore " + path("saved"));
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.err,
              HasSubstr("--restore: expected a checkpoint with the scene's volume of 32 x 32 x 32 voxels, got 24"));
}

}  // namespace
}  // namespace gicube::samples
