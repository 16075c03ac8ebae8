#include "form_factors/radiosity/field.h"

#include "test.h"

namespace gicube::samples {
namespace {

constexpr int kLong = 64;

// A row of medium, lit by a lamp far away: its halves by one link each, or all of its voxels by their own.
RadiosityResult row(bool by_halves) {
  RadiosityResult result;
  for (int x = 0; x < kLong; ++x) {
    Leaf leaf;
    leaf.facing = kMedium;
    leaf.cell = {x, 5, 5};
    leaf.weight = x < kLong / 2 ? 0.1 : 0.2;
    result.leaves.push_back(leaf);
    result.incident.push_back({x < kLong / 2 ? 1.0 : 2.0, 0, 0});
    result.outgoing.push_back({});
  }
  Leaf lamp;
  lamp.cell = {0, 60, 60};
  lamp.weight = 1;
  result.leaves.push_back(lamp);
  result.incident.push_back({});
  result.outgoing.push_back({1, 0, 0});
  const auto cluster = [&](std::uint32_t first, std::uint32_t last) {
    Cluster made;
    made.first = first, made.last = last;
    for (std::uint32_t i = first; i < last; ++i) made.weight += result.leaves[i].weight;
    made.high = {static_cast<double>(last - first), 1, 1};
    result.clusters.push_back(made);
    if (result.clusters.size() == 1) return;
    const auto at = static_cast<std::uint32_t>(result.clusters.size() - 1);
    result.links.push_back({at, 0, made.weight * result.incident[first][0], 0, 0, 8});
  };
  cluster(kLong, kLong + 1);
  const std::uint32_t part = by_halves ? kLong / 2 : 1;
  for (std::uint32_t first = 0; first < kLong; first += part) cluster(first, first + part);
  return result;
}

double power(const RadiosityResult& result, const std::vector<Power>& light) {
  double all = 0;
  for (std::size_t i = 0; i < light.size(); ++i) all += result.leaves[i].weight * light[i][0];
  return all;
}

TEST(Smoothed, TheEdgeOfAClusterIsSpreadOverItsWidthAndNoPowerIsLost) {
  const RadiosityResult result = row(true);
  const auto light = smoothed(result);
  double steepest = 0;
  for (std::size_t x = 0; x + 1 < kLong; ++x) steepest = std::max(steepest, light[x + 1][0] - light[x][0]);
  EXPECT_LT(steepest, 0.08);  // it was 1
  EXPECT_NEAR(light[2][0], 1, 0.03);
  EXPECT_NEAR(light[kLong - 3][0], 2, 0.03);
  EXPECT_NEAR(power(result, light), power(result, result.incident), 1e-9);
  EXPECT_EQ(light[kLong][0], 0);  // the lamp has no neighbour
}

TEST(Smoothed, AnEdgeThatEveryVoxelFoundForItselfStays) {
  const RadiosityResult result = row(false);
  const auto light = smoothed(result);
  EXPECT_NEAR(light[kLong / 2][0] - light[kLong / 2 - 1][0], 1, 0.2);
  EXPECT_NEAR(power(result, light), power(result, result.incident), 1e-9);
}

}  // namespace
}  // namespace gicube::samples
