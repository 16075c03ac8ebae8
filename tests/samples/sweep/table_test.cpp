#include "sweep/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "gicube/scene/error.h"
#include "scene/names.h"
#include "sweep/picture.h"
#include "sweep/run.h"

namespace gicube::samples::sweep {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

Row row(double cost, double error, bool is_reference = false) {
  Row out;
  out.point = {{"step", std::to_string(cost)}};
  out.cost = cost;
  out.error = error;
  out.is_reference = is_reference;
  out.command = "gicube-render 'a b' --step 1";
  return out;
}

TEST(ParetoFront, HasTheRowsThatNoOtherIsCheaperAndBetterThan) {
  std::vector<Row> rows{row(1, 9), row(2, 5), row(2, 7), row(3, 5), row(4, 1), row(5, 2), row(0.5, 0, true)};
  mark_front(rows);
  std::vector<bool> front;
  for (const Row& each : rows) front.push_back(each.on_front);
  EXPECT_EQ(front, (std::vector<bool>{true, true, false, false, true, false, false}));
}

TEST(ParetoFront, KeepsEqualRows) {
  std::vector<Row> rows{row(1, 1), row(1, 1)};
  mark_front(rows);
  EXPECT_TRUE(rows[0].on_front && rows[1].on_front);
}

TEST(SweepTable, IsOneLineARowWithItsCommandAndTheSameInJson) {
  Table table{"frame_ms", "picture", {"bus_ms"}, {row(2, 0.25), row(9, 0, true)}};
  table.rows[0].also = {7};
  table.rows[1].also = {8};
  mark_front(table.rows);
  EXPECT_EQ(csv(table),
            "frame_ms,error picture,front,reference,bus_ms,step,command\n"
            "2,0.25,1,0,7,2.000000,gicube-render 'a b' --step 1\n"
            "9,,0,1,8,9.000000,gicube-render 'a b' --step 1\n");
  const auto read = nlohmann::json::parse(json(table));
  EXPECT_EQ(read["points"].size(), 2u);
  ASSERT_EQ(read["front"].size(), 1u);
  EXPECT_EQ(read["front"][0]["frame_ms"], 2);
  EXPECT_EQ(read["front"][0]["command"], "gicube-render 'a b' --step 1");
  EXPECT_TRUE(read["points"][1]["error picture"].is_null());
}

TEST(SweepTable, TellsHowMuchASettingChangesTheCost) {
  const auto at = [](const std::string& step, const std::string& jitter, double cost) {
    Row out = row(cost, 0);
    out.point = {{"step", step}, {"jitter", jitter}};
    return out;
  };
  const Table table{
      "frame_ms", "picture", {}, {at("1", "off", 10), at("2", "off", 12), at("1", "on", 30), at("2", "on", 33)}};
  EXPECT_NEAR(cost_change(table, "step"), 0.2, 1e-12);
  EXPECT_NEAR(cost_change(table, "jitter"), 2, 1e-12);
}

TEST(SweepTable, QuotesCellsThatHaveCommas) {
  Table table{"frame_ms", "picture", {}, {row(1, 1)}};
  table.rows[0].point = {{"eye", "1,2,3"}};
  EXPECT_THAT(csv(table), HasSubstr(",\"1,2,3\","));
}

TEST(SweepFigure, IsANameOrAPointerAndNothingElse) {
  const auto statistics =
      nlohmann::json::parse(R"({"frame_ms": 3.5, "counters": {"bus.up": {"value": 7}}, "throughput": null})");
  EXPECT_EQ(figure(statistics, "frame_ms"), 3.5);
  EXPECT_EQ(figure(statistics, "/counters/bus.up/value"), 7);
  EXPECT_THAT([&] { figure(statistics, "throughput"); },
              ThrowsMessage<InputError>(HasSubstr("throughput: expected a number")));
  EXPECT_THAT([&] { figure(statistics, "frames"); }, ThrowsMessage<InputError>(HasSubstr("none of that name")));
  EXPECT_THAT([&] { figure(statistics, "/counters/x"); }, ThrowsMessage<InputError>(HasSubstr("none of that name")));
}

TEST(SweepRun, IsNamedByItsArguments) {
  const sweep::Run one{{"builtin:buckyball", "--step", "1"}}, same{{"builtin:buckyball", "--step", "1"}},
      other{{"builtin:buckyball", "--step", "2"}};
  EXPECT_EQ(one.key(), same.key());
  EXPECT_NE(one.key(), other.key());
  EXPECT_EQ((sweep::Run{{"my scan.nrrd", "--cut", "1,0,0,3"}}).command(),
            "gicube-render 'my scan.nrrd' --cut 1,0,0,3 -o picture.exr --stats run.json");
}

Picture flat(int width, int height, float value) {
  return {width, height, std::vector<float>(static_cast<std::size_t>(4 * width * height), value)};
}

TEST(SweepPicture, ErrorsAreRootMeanSquaresOfAllChannels) {
  Picture picture = flat(2, 2, 0.5F);
  EXPECT_EQ(rmse(picture, flat(2, 2, 0.5F)), 0);
  picture.values[5] = 0.9F;
  EXPECT_NEAR(rmse(picture, flat(2, 2, 0.5F)), 0.4 / 4, 1e-7);
}

TEST(SweepPicture, OfAnotherSizeIsResizedToTheReference) {
  Picture small = flat(2, 1, 0);
  for (std::size_t c = 4; c < 8; ++c) small.values[c] = 1;
  const Picture large = resized(small, 4, 2);
  const std::vector<float> row{0, 0.25F, 0.75F, 1};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(large.values[4 * i], row[i % 4], 1e-6) << i;
  EXPECT_NEAR(rmse(small, large), 0, 1e-6);
}

}  // namespace
}  // namespace gicube::samples::sweep
