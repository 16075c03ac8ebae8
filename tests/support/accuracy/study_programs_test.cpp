// The programs that script/charts measures with, as it runs them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>
#include <string>

#include "program_test.h"
#include "sweep/picture.h"

namespace gicube::samples {
namespace {

constexpr const char* kBall = "builtin:buckyball --volume-size 32 --size 40x30 ";

class ReferenceProgram : public ProgramTest {
 protected:
  ReferenceProgram() : ProgramTest("../tests/gicube-reference") {}
};

TEST_F(ReferenceProgram, DrawsWhatTheBoardDraws) {
  const ProgramResult exact = run(kBall + ("-o " + path("exact.exr")));
  ASSERT_EQ(exact.code, 0) << exact.err;
  const std::string board = GICUBE_BIN_DIR "/gicube-render ";
  ASSERT_EQ(std::system((board + kBall + "--quiet --no-leap -o " + path("board.exr")).c_str()), 0);
  ASSERT_EQ(std::system((board + kBall + "--quiet --eye 60,60,60 -o " + path("other.exr")).c_str()), 0);
  const sweep::Picture reference = sweep::read_picture(path("exact.exr"));
  EXPECT_EQ(reference.width, 40);
  EXPECT_EQ(reference.height, 30);
  EXPECT_LT(sweep::rmse(sweep::read_picture(path("board.exr")), reference), 0.01);  // 40 dB
  EXPECT_GT(sweep::rmse(sweep::read_picture(path("other.exr")), reference), 0.05);
}

TEST_F(ReferenceProgram, NamesWhatItCannotWrite) {
  const ProgramResult result = run(kBall + std::string("-o /nowhere/exact.exr"));
  EXPECT_NE(result.code, 0);
  EXPECT_NE(result.err.find("/nowhere/exact.exr"), std::string::npos) << result.err;
}

class LightingStudy : public ProgramTest {
 protected:
  LightingStudy() : ProgramTest("../tests/gicube-lighting-study") {}

  // The row of a table that ends with this command.
  static std::string row_of(const std::string& table, const std::string& command) {
    std::istringstream rows(table);
    for (std::string row; std::getline(rows, row);) {
      if (row.ends_with("," + command)) return row;
    }
    return "";
  }
};

TEST_F(LightingStudy, HasLessErrorForMoreRaysAndTheCommandOfEveryPoint) {
  const std::string fixed = "--albedo low --rules conserving --datapath wide --fidelity functional --step 0.5 ";
  const ProgramResult all = run(fixed + "--rays 1 4");
  ASSERT_EQ(all.code, 0) << all.err;
  const auto command = [](int rays) {
    return "gicube-lighting-study --albedo low --rules conserving --datapath wide --rays " + std::to_string(rays) +
           " --step 0.5";
  };
  const auto error = [](const std::string& row) { return std::stod(row.substr(row.find(',') + 1)); };
  const std::string few = row_of(all.out, command(1)), many = row_of(all.out, command(4));
  ASSERT_FALSE(few.empty() || many.empty()) << all.out;
  EXPECT_LT(error(many), 0.5 * error(few)) << all.out;

  const ProgramResult again =
      run(command(4).substr(std::string("gicube-lighting-study").size()) + " --fidelity functional");
  EXPECT_EQ(error(row_of(again.out, command(4))), error(many)) << again.out;
}

}  // namespace
}  // namespace gicube::samples
