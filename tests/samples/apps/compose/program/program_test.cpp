// The program itself, with private emulated boards.
#include "program_test.h"

#include <nlohmann/json.hpp>

#include "test.h"

namespace gicube::samples {
namespace {

class ComposeProgram : public ProgramTest {
 protected:
  ComposeProgram() : ProgramTest("gicube-compose") {
    std::ofstream(path("a.composition")) << R"(
      volume { name: "ball" input: "builtin:buckyball" volume_size: 24 }
      volume { name: "other" input: "builtin:buckyball" volume_size: 16 transform { translate { x: 0.4 } } }
      surface { name: "gem" file: ")" GICUBE_SOURCE_DIR
                                            R"(/samples/scenes/gem.obj" transform { scale { all: 0.3 } } opacity: 0.5 }
      image { width: 24 height: 16 } background { red: 0 green: 0 blue: 0 })";
  }
};

TEST_F(ComposeProgram, WritesAPictureAndWhatItCost) {
  const ProgramResult result =
      run(path("a.composition") + " --allow-outside --boards 2 -o " + path("a.png") + " --stats " + path("a.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("ball: "), HasSubstr("other: "), HasSubstr("picture: ")));
  EXPECT_THAT(text_of(path("a.png")), HasSubstr("PNG"));
  const auto json = nlohmann::json::parse(text_of(path("a.json")));
  ASSERT_EQ(json.at("volumes").size(), 2u);
  double longest = 0, again = 0;
  for (const auto& volume : json.at("volumes")) {
    EXPECT_GT(volume.at("segments"), 100);
    longest = std::max(longest, volume.at("load_ms").get<double>() + volume.at("trace_ms").get<double>());
    again = std::max(again, volume.at("trace_ms").get<double>());
  }
  EXPECT_NEAR(json.at("frame_ms").get<double>(), longest, 1e-9);
  EXPECT_NEAR(json.at("further_frame_ms").get<double>(), again, 1e-9);
  EXPECT_EQ(json.at("boards").size(), 2u);
  EXPECT_GT(json.at("boards")[1].at("bus_down_bytes"), 0);
  EXPECT_EQ(json.at("surfaces"), 1);
}

TEST_F(ComposeProgram, SaysWhatIsWrong) {
  EXPECT_EQ(run("").code, 2);
  const ProgramResult none = run(path("none.composition"));
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, AllOf(HasSubstr("gicube-compose: "), HasSubstr("none.composition")));
  std::ofstream(path("b.composition")) << "volume { input: \"builtin:teapot\" }";
  EXPECT_THAT(run(path("b.composition")).err,
              HasSubstr("volume[0]: built-in volume: expected buckyball, got \"teapot\""));
}

}  // namespace
}  // namespace gicube::samples
