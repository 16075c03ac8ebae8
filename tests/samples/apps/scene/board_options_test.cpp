#include "scene/program/board_options.h"

#include "scene/program/option_group.h"
#include "test.h"

namespace gicube::samples {
namespace {

TEST(BoardOptions, MakeAPlainUriByDefault) { EXPECT_EQ(board_uri({}), "emu:"); }

TEST(BoardOptions, BecomeTheQueryOfAnEmulatedBoard) {
  BoardOptions options;
  options.fidelity = "functional";
  options.config = "boards/50%&more.cfg";
  options.settings = {"asic.processors=8", "bus.model=agp2x"};
  options.threads = 3;
  EXPECT_EQ(
      board_uri(options),
      "emu:?fidelity=functional&config=boards/50%25%26more.cfg&threads=3&set=asic.processors=8&set=bus.model=agp2x");
}

TEST(BoardOptions, AreAppendedToAQueryThatIsThere) {
  BoardOptions options;
  options.board = "emu:?bus=agp4x";
  options.settings = {"asic.processors=8"};
  EXPECT_EQ(board_uri(options), "emu:?bus=agp4x&set=asic.processors=8");
  options.board = "emu:?";
  EXPECT_EQ(board_uri(options), "emu:?set=asic.processors=8");
}

TEST(BoardOptions, DoNotConfigureABoardThatRunsAlready) {
  BoardOptions options;
  options.board = "unix:/run/board";
  options.threads = 2;
  options.seed = 7;
  EXPECT_EQ(board_uri(options), "unix:/run/board") << "threads and seed are no settings of the board";
  options.settings = {"asic.processors=8"};
  try {
    board_uri(options);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--set"));
    EXPECT_THAT(error.what(), HasSubstr("own configuration"));
  }
}

TEST(BoardOptions, TakeSeedsAndTimesThatAreNumbersFromZero) {
  const auto refusal = [](const std::string& option, const std::string& value) {
    CLI::App app;
    BoardOptions options;
    add_board_options(app, options);
    try {
      app.parse(std::vector<std::string>{value, option});  // last first
    } catch (const CLI::ParseError& error) {
      return std::string(error.what());
    }
    return std::to_string(options.seed) + " " + std::to_string(options.watchdog.count());
  };
  EXPECT_EQ(refusal("--seed", "18446744073709551615"), "18446744073709551615 600");
  EXPECT_EQ(refusal("--watchdog", "0"), "0 0");
  EXPECT_EQ(refusal("--watchdog", "7"), "0 7");
  for (const char* seed : {"-1", "18446744073709551616", "1.5", "one"}) {
    EXPECT_EQ(refusal("--seed", seed),
              "--seed: expected a whole number from 0 to 2^64 - 1, got \"" + std::string(seed) + "\"");
  }
  for (const char* time : {"-1", "604801", "5s"}) {
    EXPECT_EQ(refusal("--watchdog", time),
              "--watchdog: expected whole seconds from 0 to 604800, got \"" + std::string(time) + "\"");
  }
}

TEST(Options, ThatAreUnknownAreNamedInTheirOrderWithTheNearestThatThereAre) {
  const auto fault = [](std::vector<const char*> words) -> std::string {
    CLI::App app("Renders.", "gicube-render");
    std::string input, function;
    double step = 0;
    std::optional<Vec3> eye;
    app.add_option("INPUT", input)->required();
    app.add_option("--step", step);
    app.add_option("--transfer-function", function);
    OptionGroup(app, "Camera").vector("--eye", eye, "");
    words.insert(words.begin(), "gicube-render");
    return message_of<UsageError>([&] {
      std::ostringstream out;
      parsed(app, static_cast<int>(words.size()), words.data(), out);
    });
  };
  EXPECT_EQ(fault({"a", "--step", "1", "--eye", "1,-2,3"}), "none");
  EXPECT_EQ(fault({"a", "--stpe", "1"}), "--stpe: no such option, the nearest is --step");  // a transposition
  EXPECT_EQ(fault({"--steps=1"}), "--steps: no such option, the nearest is --step");        // though INPUT is missing
  EXPECT_EQ(fault({"a", "--transfer", "x"}), "--transfer: no such option, the nearest is --transfer-function");
  EXPECT_EQ(fault({"a", "--zzz", "--setp", "3", "--eey", "1,2,3"}),
            "--zzz: no such option; --setp: no such option, the nearest is --step; --eey: no such option, the nearest "
            "is --eye");
  EXPECT_EQ(fault({"a", "b", "c"}), "not expected: b c");
  EXPECT_THAT(fault({"a", "--step", "x"}), HasSubstr("--step"));
  // A vector is one word.
  EXPECT_EQ(fault({"a", "--eye", "0", "-300", "100"}),
            "--eye: expected X,Y,Z without blanks, as --eye 0,-300,100, got 0 -300 100");
  EXPECT_EQ(fault({"--eye", "-300", "0", "100", "a"}),
            "--eye: expected X,Y,Z without blanks, as --eye -300,0,100, got -300 0 100");
  EXPECT_EQ(fault({"a", "--eye", "0,1"}),
            "--eye: expected 3 numbers with commas between and no blanks, as --eye 1,0,0.5, got \"0,1\"");
}

TEST(ParseNumbers, TakesExactlyTheNumbersAskedFor) {
  EXPECT_EQ(parse_vector("--eye", "-1,2.5,3e2"), (Vec3{-1, 2.5, 300}));
  EXPECT_EQ(parse_sizes("--size", "640x480", 2, 'x'), (std::vector<int>{640, 480}));
  for (const char* text : {"", "1,2", "1,2,3,4", "1,2,", "1,2,x", "1, 2,3", "1,2,nan", "1,2,inf"}) {
    EXPECT_THROW(parse_vector("--eye", text), CLI::ValidationError) << text;
  }
  for (const char* text : {"640", "640x", "0x480", "640x-1", "640X480", "99999999999x1"}) {
    EXPECT_THROW(parse_sizes("--size", text, 2, 'x'), CLI::ValidationError) << text;
  }
}

}  // namespace
}  // namespace gicube::samples
