#include "classify.h"

#include <gtest/gtest.h>

namespace gicube::reference {
namespace {

constexpr ValueRange kRange{0, 4095};

Material at(const TransferFunction& function, double value, const Quantisers& quantisers = {}) {
  return classify(function, {value, value}, kRange, quantisers);
}

TEST(Classification, IsLinearBetweenPointsAndConstantBeyondThem) {
  const TransferFunction function{{{100, {0, 0.5, 1}}, {300, {1, 0.5, 0}}}, {{0, 0.2}, {1000, 0.6}}};
  EXPECT_DOUBLE_EQ(at(function, 150).colour[0], 0.25);
  EXPECT_DOUBLE_EQ(at(function, 150).colour[2], 0.75);
  EXPECT_DOUBLE_EQ(at(function, 0).colour[2], 1);
  EXPECT_DOUBLE_EQ(at(function, 4000).colour[0], 1);
  EXPECT_DOUBLE_EQ(at(function, 250).opacity, 0.3);
}

TEST(Classification, TakesTheSecondSideOfAStep) {
  const TransferFunction function{{{0, {1, 1, 1}}}, {{0, 0}, {500, 0.1}, {500, 0.8}, {1000, 1}}};
  EXPECT_DOUBLE_EQ(at(function, 500).opacity, 0.8);
  EXPECT_NEAR(at(function, 499.999).opacity, 0.1, 1e-6);
  EXPECT_DOUBLE_EQ(at(function, 750).opacity, 0.9);
  const TransferFunction at_the_end{{{0, {1, 1, 1}}}, {{500, 0}, {500, 1}}};
  EXPECT_DOUBLE_EQ(at(at_the_end, 500).opacity, 1);
  EXPECT_DOUBLE_EQ(at(at_the_end, 499).opacity, 0);
}

TEST(Classification, WithoutATransferFunctionIsInvisible) { EXPECT_EQ(at({}, 7).opacity, 0); }

TEST(Classification, ByTheLutTakesTheNearestDensity) {
  const TransferFunction function{{{0, {0, 0, 0}}, {4095, {1, 1, 1}}}, {{0, 0}, {4095, 1}}};
  Quantisers quantisers;
  quantisers.colour = true;
  EXPECT_DOUBLE_EQ(at(function, 100.5, quantisers).colour[1], 101 / 4095.0);
  EXPECT_DOUBLE_EQ(at(function, 100.5, quantisers).opacity, 100.5 / 4095);
  quantisers.opacity = true;
  EXPECT_DOUBLE_EQ(at(function, 100.25, quantisers).opacity, 1600 / 65535.0);
}

}  // namespace
}  // namespace gicube::reference
