// The program itself, with a private emulated board.
#include <nlohmann/json.hpp>

#include "program_test.h"
#include "scene/names.h"
#include "test.h"

namespace gicube::samples {
namespace {

class PhotonMapProgram : public ProgramTest {
 protected:
  PhotonMapProgram() : ProgramTest("gicube-light photon-map") {}
};

TEST_F(PhotonMapProgram, MakesAPictureAndSaysWhereItsPhotonsWent) {
  const ProgramResult result = run("builtin:buckyball --volume-size 24 --size 12x8 --passes 2 --photons 500 -o " +
                                   path("x.png") + " --stats " + path("x.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("1000 photons sent"), HasSubstr("mean radiance")));
  const auto json = nlohmann::json::parse(text_of(path("x.json")));
  EXPECT_EQ(json.at("photons"), 1000);
  EXPECT_GT(json.at("on_surfaces").get<int>(), 0);
  EXPECT_EQ(json.at("in_media"), 0);
  EXPECT_GT(json.at("rays").get<int>(), 1000);
  EXPECT_TRUE(text_of(path("x.png")).starts_with("\x89PNG"));
}

TEST_F(PhotonMapProgram, MakesTheSameLightAtEveryLevel) {
  std::vector<std::string> pictures;
  for (const char* level : {"functional", "cycle"}) {
    const ProgramResult result =
        run("builtin:buckyball --volume-size 16 --size 8x6 --passes 1 --photons 300 --pixels " + path("x.csv") +
            " --fidelity " + level);
    ASSERT_EQ(result.code, 0) << result.err;
    pictures.push_back(text_of(path("x.csv")));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
}

TEST_F(PhotonMapProgram, SaysWhatItCantDo) {
  EXPECT_THAT(run("builtin:buckyball --neighbours 1").err, HasSubstr("--neighbours"));
  EXPECT_EQ(run("builtin:buckyball --photons 0").code, 2);
  EXPECT_EQ(run("builtin:teapot").code, 2);
}

}  // namespace
}  // namespace gicube::samples
