// --explain-pixel: what the board tells of a pixel's rays is what made the pixel.
#include <nlohmann/json.hpp>

#include "render/renderer.h"
#include "render_program.h"
#include "test.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kLevels[] = {"functional", "cycle"};

class PixelLife : public RenderProgram {
 protected:
  // The picture's frame, of gicube-render's options, and its board has small blocks.
  static Frame frame(std::vector<std::string> words) {
    words.insert(words.begin(), "gicube-render");
    words.insert(words.end(), {"--set", "asic.block_voxels=8", "--quiet"});
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    std::ostringstream ignored;
    const auto options = parse_options(static_cast<int>(arguments.size()), arguments.data(), ignored);
    return Renderer(*options, [](const std::string&) { return Progress(); }).picture(0);
  }

  // Of a picture of 24 x 24, at each level; `check` is told the life and the picture's pixel.
  template <typename Check>
  static void at_every_level(const std::vector<std::string>& words, int x, int y, const Check& check) {
    Json passes;
    for (const char* level : kLevels) {
      std::vector<std::string> all = words;
      all.insert(all.end(), {"--size", "24x24", "--fidelity", level, "--explain-pixel",
                             std::to_string(x) + "," + std::to_string(y)});
      const Frame made = frame(all);
      Json life = made.statistics.pixel;
      ASSERT_FALSE(life.is_null());
      const Pixel pixel = made.image.at(x, y);
      EXPECT_EQ(life.at("framebuffer"), Json({pixel.red, pixel.green, pixel.blue, pixel.alpha})) << level;
      EXPECT_EQ(life.at("explained"), life.at("framebuffer")) << level;
      check(life, level);
      for (Json& ray : life["rays"]) {
        for (Json& pass : ray["passes"]) {
          for (const char* of_cycles : {"processor", "cycle", "missing", "stalled", "links", "overflows"})
            pass.erase(of_cycles);
        }
      }
      if (passes.is_null()) passes = life;
      EXPECT_EQ(passes, life) << level;  // all values, bit by bit
    }
  }
};

const std::vector<std::string> kSmallBall{"builtin:buckyball", "--volume-size", "32"};

std::vector<std::string> ball(const std::vector<std::string>& more) {
  std::vector<std::string> all = kSmallBall;
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

TEST_F(PixelLife, EndsWithThePictureAndHasCyclesWhereTheLevelHasThem) {
  at_every_level(kSmallBall, 9, 8, [](const Json& life, const std::string& level) {
    ASSERT_EQ(life.at("rays").size(), 1u);
    const Json& passes = life.at("rays")[0].at("passes");
    ASSERT_GT(passes.size(), 5u);
    const Json& last = passes.back().at("gathered");
    const auto word = [&](std::size_t i) { return last.at("colour")[i].get<int>(); };
    for (std::size_t i = 0; i < 3; ++i) {  // 12 bits of a ray are 8 of a pixel
      EXPECT_NEAR(word(i) * 255.0 / 4095, life.at("framebuffer")[i].get<int>(), 0.51);
    }
    EXPECT_NEAR(last.at("opacity").get<double>() / 4096, life.at("framebuffer")[3].get<double>(), 1);
    std::uint64_t before = 0;
    for (const Json& pass : passes) {
      ASSERT_EQ(pass.contains("processor"), level == "cycle");
      if (level != "cycle") continue;
      EXPECT_LT(pass.at("processor").get<int>(), 4);
      EXPECT_GT(pass.at("cycle").get<std::uint64_t>(), before);
      before = pass.at("cycle").get<std::uint64_t>();
    }
    if (level != "cycle") return;
    int missing = 0;
    for (const Json& pass : passes) missing += pass.at("missing").get<int>();
    EXPECT_GT(missing, 0);
  });
}

TEST_F(PixelLife, HasTheDatapathsCompositing) {
  at_every_level(ball({"--no-shade"}), 9, 8, [](const Json& life, const std::string&) {
    std::uint64_t opacity = 0;
    for (const Json& pass : life.at("rays")[0].at("passes")) {
      if (!pass.contains("leap")) {  // Porter and Duff's over, in words of 24 bits
        const std::uint64_t one = (1 << 24) - 1, product = (one - opacity) * pass.at("opacity").get<std::uint64_t>();
        opacity += (product + one / 2) / one;
      }
      EXPECT_EQ(pass.at("gathered").at("opacity").get<std::uint64_t>(), opacity);
    }
    EXPECT_GT(opacity, 0u);
  });
}

TEST_F(PixelLife, HoldsWithOtherSamplesFiltersWordsAndRuns) {
  const auto nothing = [](const Json&, const std::string&) {};
  at_every_level(ball({"--samples", "2", "--jitter"}), 12, 10, nothing);
  at_every_level(ball({"--samples", "2", "--filter", "tent"}), 12, 10, nothing);
  at_every_level(ball({"--filter", "tent"}), 0, 23, nothing);
  at_every_level(ball({"--set", "asic.datapath=wide"}), 12, 10, nothing);
  at_every_level(ball({"--set", "dsp.run_rays=16"}), 12, 10, nothing);
  at_every_level(ball({"--no-leap", "--cut", "0,1,0,15"}), 12, 10, nothing);
}

TEST_F(PixelLife, OfARayThatMissesTheVolumeHasNoPasses) {
  at_every_level(ball({"--eye", "16,-400,16", "--look-at", "16,16,16"}), 0, 0,
                 [](const Json& life, const std::string&) {
                   EXPECT_EQ(life.at("rays")[0].at("end"), "missed");
                   EXPECT_TRUE(life.at("rays")[0].at("passes").empty());
                   EXPECT_EQ(life.at("framebuffer"), Json({0, 0, 0, 0}));
                 });
}

TEST_F(PixelLife, OfLitAndScatteredPicturesIsTheirs) {
  int scattered = 0;
  const auto count = [&](const Json& life, const std::string&) {
    for (const Json& ray : life.at("rays")) {
      for (const Json& pass : ray.at("passes")) scattered += pass.contains("scattered") ? 1 : 0;
    }
  };
  for (const char* scene : {"glass", "mirror_buckyball"}) {
    const std::string file = std::string(GICUBE_SOURCE_DIR "/samples/scenes/") + scene + ".scene";
    for (const int y : {12, 20}) {
      at_every_level({file, "--volume-size", "32", "--light-rays", "1", "--lifetime", "4", "--samples", "1"}, 12, y,
                     count);
    }
  }
  EXPECT_GT(scattered, 0);
}

TEST_F(PixelLife, IsPrintedDrawnAndWritten) {
  const ProgramResult result =
      run("builtin:buckyball --volume-size 32 --size 24x24 --fidelity cycle --explain-pixel 9,8 --explain-svg " +
          path("strip.svg") + " --stats " + path("a.json") + " -o " + path("a.png"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("pixel 9,8: red "));
  EXPECT_THAT(result.out, HasSubstr("misses waits links\n"));
  const Json life = Json::parse(text_of(path("a.json"))).at("pixel");
  const std::size_t passes = life.at("rays")[0].at("passes").size();
  EXPECT_THAT(result.out, HasSubstr(": " + std::to_string(passes) + " passes, "));
  const std::string svg = text_of(path("strip.svg"));
  std::size_t boxes = 0;
  for (std::size_t at = svg.find("processor "); at != svg.npos; at = svg.find("processor ", at + 1)) ++boxes;
  EXPECT_EQ(boxes, passes);
  EXPECT_THAT(svg, EndsWith("</svg>\n"));
}

TEST_F(PixelLife, RefusesWhatItCannotExplain) {
  const std::map<std::string, std::string> faults{
      {"--explain-pixel 24,0", "pixel: expected one of the picture's 24 x 24, got 24,0"},
      {"--explain-pixel 1", "expected 2 numbers with commas between and no blanks, as --explain-pixel 2,1"},
      {"--explain-pixel=-1,2", "expected two whole numbers from 0 to 4094"},
      {"--explain-svg a.svg", "expected --explain-pixel X,Y beside it"},
      {"--explain-pixel 1,2 --frames 2 --fps 5", "expected without more than one of --frames"},
      {"--explain-pixel 1,2 --max-error 5%", "expected without --max-error or --time-budget"},
      {"--explain-pixel 1,2 --board unix:/none", "expected without a running board"},
      {"--explain-pixel 1,2 --set asic.block_voxels=8 --set asic.max_volume_voxels=32 --volume-size 64",
       "got one in bricks"},
  };
  const ProgramResult colours = run(GICUBE_SOURCE_DIR
                                    "/samples/scenes/fog_box.scene --volume-size 32 --size 24x24 "
                                    "--samples 1 --light-rays 1 --explain-pixel 1,2 --quiet -o " +
                                    path("a.png"));
  EXPECT_THAT(colours.err, HasSubstr("--explain-pixel: expected a scene without colour passes"));
  for (const auto& [options, words] : faults) {
    const std::string size = options.find("--volume-size") == options.npos ? " --volume-size 32 " : " ";
    const ProgramResult result =
        run("builtin:buckyball --size 24x24 --quiet" + size + "-o " + path("a.png") + " " + options);
    EXPECT_NE(result.code, 0) << options;
    EXPECT_THAT(result.err, HasSubstr(words)) << options;
  }
}

}  // namespace
}  // namespace gicube::samples
