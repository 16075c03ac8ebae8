// gicube-sweep as its users run it, on pictures of a few pixels.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "full_disk.h"

namespace gicube::samples {
namespace {

using testing::HasSubstr;
using testing::Not;

class SweepProgram : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("gicube-sweep-") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string text(const std::filesystem::path& file) const {
    std::ifstream stream(folder_ / file);
    std::ostringstream all;
    all << stream.rdbuf();
    return all.str();
  }
  // Its exit code.
  int run(const std::string& arguments) const {
    const std::string command =
        "cd " + folder_.string() + " && " GICUBE_BIN_DIR "/gicube-sweep " + arguments + " >stdout 2>stderr </dev/null";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::map<std::string, std::filesystem::file_time_type> runs() const {
    std::map<std::string, std::filesystem::file_time_type> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "out/runs")) {
      if (entry.path().extension() == ".json") found[entry.path().filename()] = entry.last_write_time();
    }
    return found;
  }

  static constexpr const char* kSmall =
      "builtin:buckyball --fix volume-size=32 --fix size=24x24 --vary step=0.5,1,2 --reference step=0.25 -o out";
  std::filesystem::path folder_;
};

TEST_F(SweepProgram, WritesCostAndErrorOfEveryCombinationAndTheFront) {
  ASSERT_EQ(run(std::string(kSmall) + " --vary jitter=off,on --also bus_ms --jobs 2"), 0) << text("stderr");
  const auto read = nlohmann::json::parse(text("out/sweep.json"));
  ASSERT_EQ(read["points"].size(), 6u);
  double finest = 1, coarsest = 0;
  for (const auto& point : read["points"]) {
    EXPECT_GT(point["frame_ms"], 0);
    EXPECT_GT(point["bus_ms"], 0);
    if (point["settings"]["jitter"] != "off") continue;
    if (point["settings"]["step"] == "0.5") finest = point["error picture"];
    if (point["settings"]["step"] == "2") coarsest = point["error picture"];
  }
  EXPECT_GT(coarsest, 1.5 * finest);
  EXPECT_GT(read["front"].size(), 0u);
  EXPECT_THAT(text("out/sweep.csv"), HasSubstr("gicube-render builtin:buckyball --step 2 --jitter --volume-size 32"));
  EXPECT_THAT(text("stdout"), HasSubstr("of 6 runs"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/sweep.gp"));
}

TEST_F(SweepProgram, SaysThatAFunctionalBoardsFrameTimeHardlyKnowsTheStep) {
  ASSERT_EQ(run(std::string(kSmall) + " --fix fidelity=functional"), 0) << text("stderr");
  EXPECT_THAT(text("stderr"), HasSubstr("note: step changes frame_ms by at most "));
  EXPECT_THAT(text("stderr"), HasSubstr("--fix fidelity=approximate"));
  ASSERT_EQ(run(std::string(kSmall) + " --fix fidelity=functional --cost samples"), 0) << text("stderr");
  EXPECT_THAT(text("stderr"), Not(HasSubstr("note:")));
  ASSERT_EQ(run(std::string(kSmall) + " --fix fidelity=approximate"), 0) << text("stderr");
  EXPECT_THAT(text("stderr"), Not(HasSubstr("note:")));
}

TEST_F(SweepProgram, GoesOnWhereAKilledSweepWas) {
  ASSERT_EQ(run(kSmall), 0) << text("stderr");
  const std::string table = text("out/sweep.csv");
  const auto before = runs();
  ASSERT_EQ(before.size(), 4u);
  // As if it had been killed within a run: no result, and what the run had begun to write.
  const std::string lost = before.begin()->first;
  std::filesystem::remove(folder_ / "out/runs" / lost);
  std::ofstream(folder_ / "out/runs" / (lost.substr(0, 16) + ".part.json")) << "{";
  ASSERT_EQ(run(kSmall), 0) << text("stderr");
  auto after = runs();
  EXPECT_EQ(text("out/sweep.csv"), table);  // simulated time is the same again
  for (const auto& [name, written] : before) {
    if (name == lost) continue;
    EXPECT_EQ(after[name], written) << name;
  }
}

// The runs are there; what there is room for is the tables, but not the chart.
TEST_F(SweepProgram, LeavesNoPartOfAChartOnAFullDisk) {
  ASSERT_EQ(run(std::string(kSmall) + " --chart"), 0) << text("stderr");
  const std::string chart = text("out/sweep.svg");
  EXPECT_THAT(chart, testing::AllOf(HasSubstr("Pareto front"), HasSubstr("</svg>")));
  ASSERT_GT(chart.size(), 2 * text("out/sweep.json").size());
  std::filesystem::remove(folder_ / "out/sweep.svg");
  {
    const reference::FileSizeLimit limit(chart.size() / 2);
    EXPECT_EQ(run(std::string(kSmall) + " --chart"), 1);
  }
  EXPECT_THAT(text("stderr"), HasSubstr("sweep.svg: file: expected a place to write to"));
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "out")) {
    EXPECT_THAT(entry.path().string(), Not(HasSubstr("svg")));
  }
}

// Every row's command makes its figures again.
TEST_F(SweepProgram, PrintsCommandsThatMakeTheirPointsAgain) {
  ASSERT_EQ(run(kSmall), 0);
  const auto read = nlohmann::json::parse(text("out/sweep.json"));
  const auto& point = read["front"][0];
  const std::string command = "cd " + folder_.string() + " && PATH=" GICUBE_BIN_DIR ":$PATH " +
                              point["command"].get<std::string>() + " >/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  EXPECT_EQ(nlohmann::json::parse(text("run.json"))["frame_ms"], point["frame_ms"]);
}

TEST_F(SweepProgram, AFailedRunIsNamedWithItsCommandAndReason) {
  EXPECT_EQ(run("builtin:buckyball --fix volume-size=32 --vary asic.processors=2,99 --reference step=1 -o out"), 1);
  EXPECT_THAT(text("stderr"), HasSubstr("--set asic.processors=99"));
  EXPECT_THAT(text("stderr"), HasSubstr("asic.processors"));
}

TEST_F(SweepProgram, WhatIsWrongWithTheCommandLineIsNamed) {
  EXPECT_EQ(run("builtin:buckyball --vary step=1 -o out"), 2);
  EXPECT_THAT(text("stderr"), HasSubstr("--reference or --reference-picture: expected one of them"));
  EXPECT_EQ(run("builtin:buckyball --vary step=1 --fix step=2 --reference step=1 -o out"), 2);
  EXPECT_THAT(text("stderr"), HasSubstr("step: expected once"));
  EXPECT_EQ(run("builtin:buckyball --vary output=a,b --reference step=1 -o out"), 2);
  EXPECT_THAT(text("stderr"), HasSubstr("sweep's own"));
}

}  // namespace
}  // namespace gicube::samples
