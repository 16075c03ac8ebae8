#include "studies/results/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace gicube::samples::results {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(ResultPage, AQuarterIsCountedFromTheNearerEndOfTheRange) {
  EXPECT_FALSE(differs(2.5, 2, 4));
  EXPECT_FALSE(differs(1.5, 2, 4));
  EXPECT_TRUE(differs(1.49, 2, 4));
  EXPECT_FALSE(differs(5, 2, 4));
  EXPECT_TRUE(differs(5.01, 2, 4));
}

TEST(ResultPage, TableHasTheSameCellsAsItsCsv) {
  const Table table{"t", {"name", "value"}, {{"a, b", "1"}, {"say \"c\"", "2"}}};
  EXPECT_EQ(to_markdown(table), "| name | value |\n| --- | --- |\n| a, b | 1 |\n| say \"c\" | 2 |\n");
  EXPECT_EQ(to_csv(table), "name,value\n\"a, b\",1\n\"say \"\"c\"\"\",2\n");
}

TEST(ResultPage, ChartLeavesAMissingValueEmpty) {
  const Chart chart{"c",   "Title",        "x",
                    "y",   true,           false,
                    false, {"one", "two"}, {{1, {0.5, 2}}, {2, {std::numeric_limits<double>::quiet_NaN(), 3}}}};
  EXPECT_EQ(to_csv(chart), "x,one,two\n1,0.5,2\n2,,3\n");
  const std::string script = to_gnuplot(chart);
  EXPECT_THAT(script, HasSubstr("set logscale x"));
  EXPECT_THAT(script, Not(HasSubstr("set logscale y")));
  EXPECT_THAT(script, HasSubstr("set output 'c.svg'"));
  EXPECT_THAT(script, Not(HasSubstr("png")));
  EXPECT_THAT(script, HasSubstr("using 1:3"));
}

TEST(ResultPage, ClaimThatDiffersMustSayWhy) {
  Page page;
  EXPECT_THROW(page.claim({5, "bandwidth", "2", "1", true, ""}), std::logic_error);
  page.claim({6, "use", "40%", "41%", false, ""});
  page.claim({5, "bandwidth", "2", "1", true, "because"});
  const std::string claims = page.claims();
  EXPECT_LT(claims.find("| 5 | bandwidth"), claims.find("| 6 | use"));
  EXPECT_THAT(claims, HasSubstr("- **5, bandwidth**: because\n"));
  EXPECT_THAT(claims, Not(HasSubstr("- **6")));
}

TEST(ResultPage, NumbersArePrintedWithTheirDigits) {
  EXPECT_EQ(number(1.25, 1), "1.2");
  EXPECT_EQ(number(-3, 0), "-3");
  EXPECT_EQ(percent(0.375, 1), "37.5%");
}

}  // namespace
}  // namespace gicube::samples::results
