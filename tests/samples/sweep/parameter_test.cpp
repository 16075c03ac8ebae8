#include "sweep/parameter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gicube/scene/error.h"
#include "scene/names.h"

namespace gicube::samples::sweep {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(SweepParameter, HasValuesBetweenCommasOrIfTheyHaveCommasBetweenSemicolons) {
  EXPECT_EQ(parse_parameter("step=0.5,1").name, "step");
  EXPECT_THAT(parse_parameter("step=0.5,1").values, ElementsAre("0.5", "1"));
  EXPECT_THAT(parse_parameter("eye=0,-3,0;1,2,3").values, ElementsAre("0,-3,0", "1,2,3"));
  EXPECT_THAT(parse_parameter("asic.processors=4").values, ElementsAre("4"));
}

TEST(SweepParameter, IsRefusedByWhatIsWrongWithIt) {
  for (const char* text : {"step", "=3", "step=", "--step=1"})
    EXPECT_THAT([&] { parse_parameter(text); }, ThrowsMessage<InputError>(HasSubstr("NAME=VALUE"))) << text;
  EXPECT_THAT([] { parse_parameter("step=1,,2"); }, ThrowsMessage<InputError>(HasSubstr("step: expected values")));
  EXPECT_THAT([] { parse_parameter("step=1,2,1"); }, ThrowsMessage<InputError>(HasSubstr("\"1\" twice")));
}

TEST(SweepGrid, HasEveryCombinationOnce) {
  const std::vector<Point> points = grid({{"a", {"1", "2"}}, {"b", {"x", "y", "z"}}});
  ASSERT_EQ(points.size(), 6u);
  EXPECT_EQ(points[0], (Point{{"a", "1"}, {"b", "x"}}));
  EXPECT_EQ(points[4], (Point{{"a", "2"}, {"b", "y"}}));
  EXPECT_THAT(grid({}), ElementsAre(Point{}));
}

TEST(SweepPoint, ChangesReplaceSettingsAndAddThoseThatItHasNot) {
  EXPECT_EQ(changed({{"a", "1"}, {"b", "2"}}, {{"b", "3"}, {"c", "4"}}), (Point{{"a", "1"}, {"b", "3"}, {"c", "4"}}));
}

TEST(SweepPoint, BecomesTheArgumentsOfGicubeRender) {
  EXPECT_THAT(arguments({{"step", "0.5"},
                         {"input", "builtin:buckyball"},
                         {"jitter", "on"},
                         {"no-leap", "off"},
                         {"asic.processors", "8"}}),
              ElementsAre("builtin:buckyball", "--step", "0.5", "--jitter", "--set", "asic.processors=8"));
}

}  // namespace
}  // namespace gicube::samples::sweep
