// The program itself, with a private emulated board.
#include <nlohmann/json.hpp>

#include "full_disk.h"
#include "gicube/scene/light_field.h"
#include "program_test.h"
#include "scene/names.h"
#include "test.h"

namespace gicube::samples {
namespace {

class FormFactorProgram : public ProgramTest {
 protected:
  FormFactorProgram() : ProgramTest("gicube-form-factors") {}

  // A closed room with a lamp at its ceiling.
  std::string room() const {
    std::ofstream(path("room.scene")) << R"(
      world { size: 10 node { material: "wall" box { low { x: -2 y: -2 z: -2 } high { x: 2 y: 2 z: -0.75 } } }
        node { material: "wall" box { low { x: -2 y: -2 z: 0.75 } high { x: 2 y: 2 z: 2 } } }
        node { material: "wall" box { low { x: -2 y: -2 z: -2 } high { x: -0.75 y: 2 z: 2 } } }
        node { material: "wall" box { low { x: 0.75 y: -2 z: -2 } high { x: 2 y: 2 z: 2 } } }
        node { material: "wall" box { low { x: -2 y: -2 z: -2 } high { x: 2 y: -0.75 z: 2 } } }
        node { material: "wall" box { low { x: -2 y: 0.75 z: -2 } high { x: 2 y: 2 z: 2 } } }
        node { material: "lamp" box { low { x: -0.3 y: -0.3 z: 0.5 } high { x: 0.3 y: 0.3 z: 0.9 } } } }
      material { name: "wall" solid { colour { red: 0.8 green: 0.8 blue: 0.8 } } scattering: 0.5 bsdf: "diffuse" }
      material { name: "lamp" solid { } emission: 3 emission_colour { red: 1 green: 0.5 blue: 0 } }
      cut_plane { normal { y: 1 } offset: -0.6 } camera { eye { y: -6 } } image { width: 24 height: 16 })";
    return path("room.scene");
  }
};

TEST_F(FormFactorProgram, PlansForAnErrorAndExplainsItself) {
  const ProgramResult result =
      run("solve " GICUBE_SOURCE_DIR
          "/samples/scenes/radiosity/glowing_room.scene --volume-size 8 --max-error 40% --explain --stats " +
          path("x.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("plan for an error of at most 40%"), HasSubstr("links: divided where"),
                    HasSubstr("error: "), HasSubstr("where a full matrix takes"), HasSubstr("the plan itself")));
  const auto json = nlohmann::json::parse(text_of(path("x.json")));
  const auto &plan = json.at("plan"), &chosen = plan.at("chosen");
  EXPECT_TRUE(plan.at("kept").get<bool>());
  EXPECT_LE(chosen.at("error_bound").get<double>(), 0.4);
  EXPECT_EQ(json.at("settings").at("error"), chosen.at("threshold"));
  EXPECT_EQ(json.at("rays"), chosen.at("rays"));  // the plan's last solution is what is written
  EXPECT_GT(plan.at("full_matrix_rays").get<double>(), 3 * chosen.at("rays").get<double>());
}

TEST_F(FormFactorProgram, KeepsATimeBudgetOnABoardThatKeepsTime) {
  const ProgramResult result = run("solve " + room() + " --time-budget 60ms --stats " + path("x.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  const auto json = nlohmann::json::parse(text_of(path("x.json")));
  EXPECT_EQ(json.at("board").at("fidelity"), "cycle");
  EXPECT_TRUE(json.at("plan").at("kept").get<bool>());
  EXPECT_LE(json.at("board_ms").get<double>(), 60);
  EXPECT_GT(json.at("plan").at("points").size(), 1u);
}

TEST_F(FormFactorProgram, RefusesPlansThatContradictOtherOptions) {
  for (const char* wrong : {" --max-error 5% --time-budget 5ms", " --explain", " --max-error 5% --error 1e-3",
                            " --max-error 5% --rays 8", " --time-budget 1s --full-matrix", " --max-error 0"}) {
    EXPECT_EQ(run("solve " + room() + wrong).code, 2) << wrong;
  }
}

TEST_F(FormFactorProgram, SolvesASceneIntoItsFiles) {
  const ProgramResult result =
      run("solve " + room() + " --error 1e-2 --factors " + path("x.mtx") + " --elements " + path("x.csv") +
          " --solution " + path("x.nrrd") + " -o " + path("x.png") + " --stats " + path("x.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, HasSubstr("links where a full matrix has"));
  EXPECT_THAT(text_of(path("x.mtx")), HasSubstr("%%MatrixMarket"));
  EXPECT_THAT(text_of(path("x.mtx.clusters.csv")), HasSubstr("row,facing"));
  EXPECT_GT(std::filesystem::file_size(path("x.png")), 100u);
  const LightField field = read_light_field(path("x.nrrd"));
  EXPECT_EQ(field.dims, (Dims{10, 10, 10}));
  double red = 0, green = 0, blue = 0;
  for (std::size_t i = 0; i < field.values.size(); i += 3) {
    red += field.values[i], green += field.values[i + 1], blue += field.values[i + 2];
  }
  EXPECT_GT(red, 1);
  EXPECT_NEAR(green, red / 2, 0.001 * red);
  EXPECT_EQ(blue, 0);
  const auto json = nlohmann::json::parse(text_of(path("x.json")));
  double incident = 0, weights = 0;  // of the elements' file
  std::istringstream elements(text_of(path("x.csv")));
  std::string line;
  std::getline(elements, line);
  EXPECT_EQ(line, "x,y,z,facing,tag,weight,red,green,blue,standard_error");
  while (std::getline(elements, line)) {
    std::array<double, 10> value{};
    std::istringstream cells(line);
    for (double& each : value) cells >> each, cells.ignore();
    weights += value[5];
    incident += value[5] * (value[6] + value[7] + value[8]);
  }
  EXPECT_NEAR(incident / weights, json.at("standard_error").at("mean_incident").get<double>(), 1e-9);
  EXPECT_GT(json.at("links").get<int>(), 10);
  EXPECT_GT(json.at("all_pairs").get<int>(), json.at("links").get<int>());
  EXPECT_GT(json.at("bus_down_bytes").get<int>(), 0);
  EXPECT_GT(json.at("board_ms").get<double>(), 0);
  EXPECT_GT(json.at("energy").at("emitted")[0].get<double>(), 0);
  EXPECT_EQ(json.at("energy").at("emitted")[2], 0);
  EXPECT_FALSE(json.at("iterations").empty());
  EXPECT_GT(json.at("standard_error").at("mean").get<double>(), 0);
}

TEST_F(FormFactorProgram, FindsTheSameLightWhoeverMakesTheRays) {
  for (const char* made : {"board", "host"}) {
    const ProgramResult result =
        run("solve " + room() + " --error 1e-2 --quiet --made " + made + " --solution " + path(made));
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.out, "");
  }
  EXPECT_EQ(read_light_field(path("board")).values, read_light_field(path("host")).values);
}

TEST_F(FormFactorProgram, LooksBetweenRandomVoxels) {
  const ProgramResult result = run("visibility builtin:buckyball --volume-size 32 --pairs 200 --stats " +
                                   path("v.json") + " --pairs-file " + path("v.csv"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("200 pairs"));
  const auto json = nlohmann::json::parse(text_of(path("v.json")));
  EXPECT_EQ(json.at("rays"), 3200);
  EXPECT_GT(json.at("transmittance").get<double>(), 0.1);
  EXPECT_GT(json.at("rays_per_simulated_second").get<double>(), 1e5);
  EXPECT_EQ(json.at("utilisation").at("bound"), "DSP");
  const std::string pairs = text_of(path("v.csv"));
  EXPECT_EQ(std::count(pairs.begin(), pairs.end(), '\n'), 201);
  double sum = 0;
  std::istringstream rows(pairs.substr(pairs.find('\n') + 1));
  for (std::string row; std::getline(rows, row);) sum += std::stod(row.substr(row.rfind(',') + 1));
  EXPECT_NEAR(sum / 200, json.at("transmittance").get<double>(), 1e-9);
  EXPECT_TRUE(json.at("utilisation").at("memory").is_null());
}

TEST_F(FormFactorProgram, FailsWithOneLineThatNamesWhatIsWrong) {
  const auto expect = [&](const std::string& arguments, int code, const std::string& text) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, code) << arguments;
    EXPECT_THAT(result.err, HasSubstr(text)) << arguments;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  };
  expect("solve /nowhere/a.scene", 1, "/nowhere/a.scene");
  expect("solve " + room() + " -o /nowhere/a.png", 1, "/nowhere/a.png: expected a folder that is there");
  expect("solve " + room() + " --solver both", 2, "--solver");
  expect("solve builtin:ball --emission 0=1", 2, "INPUT: expected builtin:buckyball");
  expect("solve " + room() + " --emission 1=0", 1, "emission");
  expect("visibility " + room() + " --board unix:/nowhere/socket", 1, "/nowhere/socket");
}

// Neither what could not be written, nor a part of it.
TEST_F(FormFactorProgram, FailsAndLeavesNothingOnAFullDisk) {
  const std::string solve = "solve " + room() + " --volume-size 8 --quiet ";
  for (const auto& [option, name] :
       {std::pair{"--factors", "a.mtx"}, {"--elements", "a.csv"}, {"--solution", "a.nrrd"}, {"--stats", "a.json"}}) {
    const ProgramResult result = [&] {
      const reference::FileSizeLimit limit(300);
      return run(solve + option + " " + path(name));
    }();
    EXPECT_EQ(result.code, 1) << name;
    EXPECT_THAT(result.err, HasSubstr(std::string(name) + ": file: expected a place to write to, got File too large"));
    for (const auto& entry : std::filesystem::directory_iterator(path(""))) {
      EXPECT_FALSE(entry.path().filename().string().starts_with("a.")) << entry.path();
    }
  }
  const ProgramResult twice = run(solve + "--solution " + path("a.nrrd") + " --factors " + path("a.nrrd"));
  EXPECT_EQ(twice.code, 2);
  EXPECT_THAT(twice.err, HasSubstr("--solution: expected another file than --factors, got "));
}

}  // namespace
}  // namespace gicube::samples
