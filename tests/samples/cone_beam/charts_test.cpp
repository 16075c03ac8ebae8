#include "cone_beam/charts/charts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "gicube/scene/error.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
using testing::ThrowsMessage;

TEST(ConeBeamCharts, EveryPointHasANameOfItsOwnThatBeginsWithItsChart) {
  std::set<std::string> names;
  for (const Chart& chart : cone_beam_charts()) {
    for (const Series& series : chart.series) {
      EXPECT_EQ(series.name.find(','), std::string::npos) << series.name;
      EXPECT_FALSE(series.points.empty()) << series.name;
      for (const Point& point : series.points) {
        EXPECT_THAT(point.name, StartsWith(chart.name + "/"));
        EXPECT_EQ(point.name.find_first_of(" ,\""), std::string::npos) << point.name;
        EXPECT_TRUE(names.insert(point.name).second) << point.name;
      }
    }
  }
}

TEST(ConeBeamCharts, APointsRowHasItsChartsColumnsAndIsTheSameAgain) {
  ::setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1);
  for (const Chart& chart : cone_beam_charts()) {
    if (chart.name != "moire") continue;
    const Point& point = chart.series.at(0).points.at(1);
    Runner one({}), other({});
    const std::string row = point.rows(one);
    EXPECT_EQ(std::count(row.begin(), row.end(), ','), std::count(chart.header.begin(), chart.header.end(), ','));
    EXPECT_THAT(row, StartsWith("0.5,"));
    EXPECT_EQ(point.rows(other), row);
  }
}

TEST(ConeBeamCharts, WhatIsntThereIsNamed) {
  ProgressLine silent(false);
  EXPECT_THAT([&] { charts({.folder = {}, .only = {"colours"}, .point = {}, .board = {}}, silent); },
              ThrowsMessage<InputError>(HasSubstr("--only: expected cone_angle, ")));
  EXPECT_THAT([&] { charts({.folder = {}, .only = {}, .point = "views/fdk/7", .board = {}}, silent); },
              ThrowsMessage<InputError>(HasSubstr("views/fdk/7")));
}

}  // namespace
}  // namespace gicube::samples
