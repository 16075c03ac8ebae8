#include "compose/program/options.h"

#include "test.h"

namespace gicube::samples {
namespace {

std::optional<ComposeOptions> parsed(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "gicube-compose");
  std::ostringstream out;
  return parse_compose_options(static_cast<int>(arguments.size()), arguments.data(), out);
}

std::string refusal(const std::vector<const char*>& arguments) {
  return message_of<UsageError>([&] { parsed(arguments); });
}

TEST(ComposeOptions, SetThePicture) {
  const ComposeOptions options = *parsed({"a.composition", "-o", "a.png", "--size", "30x20", "--samples", "2", "--step",
                                          "0.25", "--overlap-step", "2", "--boards", "3"});
  EXPECT_EQ(options.composition, "a.composition");
  EXPECT_EQ(options.picture, "a.png");
  EXPECT_EQ(options.size, (std::array{30, 20}));
  EXPECT_EQ(options.samples_per_axis, 2);
  EXPECT_EQ(options.step, 0.25);
  EXPECT_EQ(options.overlap_step, 2);
  EXPECT_EQ(options.boards, 3);
  EXPECT_FALSE(parsed({"a.composition"})->step.has_value());
}

TEST(ComposeOptions, RefuseWhatCanNotBeDone) {
  EXPECT_THAT(refusal({}), HasSubstr("COMPOSITION"));
  EXPECT_THAT(refusal({"a", "-o", "a.gif"}),
              HasSubstr("--output: expected a name that ends in .png or .exr, got \"a.gif\""));
  EXPECT_THAT(refusal({"a", "--samples", "3"}), HasSubstr("--samples"));
  EXPECT_THAT(refusal({"a", "--boards", "0"}), HasSubstr("--boards"));
  EXPECT_THAT(refusal({"a", "--boards", "2", "--board", "unix:/x"}),
              HasSubstr("--boards: expected 1 with a running board, got 2"));
}

TEST(TimeOf, APictureIsThatOfTheBusiestBoard) {
  const std::vector<MediumCost> costs{{0, 1, 1, 10, 1}, {1, 1, 1, 20, 5}, {0, 1, 1, 30, 2}};
  EXPECT_EQ(time_of(costs, false), 43u);
  EXPECT_EQ(time_of(costs, true), 43u);  // the first board still loads two volumes by turns
  EXPECT_EQ(time_of({{0, 1, 1, 10, 1}, {1, 1, 1, 20, 5}}, true), 5u);
  EXPECT_EQ(time_of({}, false), 0u);
}

}  // namespace
}  // namespace gicube::samples
