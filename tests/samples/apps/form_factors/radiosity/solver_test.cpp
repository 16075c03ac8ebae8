// Radiosity over links whose exchange areas are known.
#include "form_factors/radiosity/solver.h"

#include "test.h"

namespace gicube::samples {
namespace {

Leaf leaf(std::uint8_t facing, int x, double emission, double albedo, std::uint8_t tag = 0) {
  Leaf out;
  out.element = {ElementKind::kPatch, {double(x), 0, 0}, {1, 0, 0}, {0, 1, 0}, {}};
  out.facing = facing;
  out.tag = tag;
  out.cell = {x, 0, 0};
  out.weight = 1;
  out.albedo = {albedo, albedo, albedo};
  out.emission = {emission, 0.5 * emission, 0};
  return out;
}

// Two infinite planes face to face: all that one sends the other gets. Per area, with E = 1 and 0:
// B_1 = 1 / (1 - a b), B_2 = b / (1 - a b).
TEST(RadiositySolver, TwoPlanesReflectEachOthersLight) {
  const Forest forest = make_forest({leaf(4, 0, 1, 0.5), leaf(5, 0, 0, 0.8)}, {1, 1, 1}, 1);
  const std::vector<Link> links{{.a = 0, .b = 1, .exchange = 1}};
  for (const Solver way : {Solver::kGathering, Solver::kShooting}) {
    RadiositySolver solver(forest);
    std::vector<Iteration> iterations;
    solver.solve(links, {.solver = way, .convergence = 1e-9}, false, iterations);
    RadiosityResult result;
    result.links = links;
    solver.results(result);
    EXPECT_NEAR(result.outgoing[0][0], 1 / 0.6, 1e-8);
    EXPECT_NEAR(result.outgoing[1][0], 0.8 / 0.6, 1e-8);
    EXPECT_NEAR(result.outgoing[1][1], 0.4 / 0.6, 1e-8);
    EXPECT_NEAR(result.incident[0][0], 0.8 / 0.6, 1e-8);
    for (std::size_t i = 1; i < iterations.size(); ++i) EXPECT_LT(iterations[i].residual, iterations[i - 1].residual);
    EXPECT_NEAR(result.statistics.energy.absorbed_by_faces[0], 1, 1e-8);
    EXPECT_NEAR(result.statistics.energy.closure[0], 0, 1e-12);
  }
}

// Four leaves in two clusters; a link of the clusters, and one of two leaves.
class TwoLevels : public testing::Test {
 protected:
  Forest forest =
      make_forest({leaf(4, 0, 1, 0.5), leaf(4, 1, 3, 0.5), leaf(5, 0, 0, 0.2), leaf(5, 1, 0, 0.6)}, {1, 1, 1}, 1);
  // clusters: 0 and 1 the roots, 2 3 and 4 5 their leaves
  std::vector<Link> links{{.a = 0, .b = 1, .exchange = 1}, {.a = 2, .b = 4, .exchange = 0.25}};

  RadiosityResult solve(Solver way, bool balance) {
    RadiositySolver solver(forest);
    RadiosityResult result;
    result.links = links;
    solver.solve(links, {.solver = way, .convergence = 1e-10}, balance, result.statistics.iterations);
    solver.results(result);
    return result;
  }
};

TEST_F(TwoLevels, WhatAClusterReceivesIsSpreadOverItsLeaves) {
  // Exchange areas by leaf: 1 / 4 for each pair, and 1 / 4 more for the first of both.
  const auto result = solve(Solver::kGathering, false);
  const auto& out = result.outgoing;
  EXPECT_NEAR(result.incident[2][0], 0.5 * out[0][0] + 0.25 * out[1][0], 1e-8);
  EXPECT_NEAR(result.incident[3][0], 0.25 * out[0][0] + 0.25 * out[1][0], 1e-8);
  EXPECT_NEAR(result.incident[0][0], 0.5 * out[2][0] + 0.25 * out[3][0], 1e-8);
  const EnergyBalance& energy = result.statistics.energy;
  EXPECT_NEAR(energy.emitted[0], 4, 1e-12);
  EXPECT_NEAR(energy.absorbed_by_faces[0] + energy.closure[0], 4, 1e-8);
  EXPECT_GT(energy.closure[0], 0.5);  // the links' sums miss as much
}

TEST_F(TwoLevels, ShootingAndGatheringAgree) {
  const auto gathered = solve(Solver::kGathering, false), shot = solve(Solver::kShooting, false);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(gathered.outgoing[i][0], shot.outgoing[i][0], 1e-8);
}

TEST_F(TwoLevels, BalancedLinksLoseNoPowerIfTheyAreUncertain) {
  links[0].spread = links[1].standard_error = 1;
  const auto result = solve(Solver::kShooting, true);
  const EnergyBalance& energy = result.statistics.energy;
  EXPECT_NEAR(energy.closure[0], 0, 1e-4);
  EXPECT_NEAR(energy.absorbed_by_faces[0], 4, 1e-4);
  EXPECT_GT(energy.measured_closure[0], 0.5);
}

TEST_F(TwoLevels, WhatIsCertainStaysAsItWas) {
  const auto as_measured = solve(Solver::kGathering, false), balanced = solve(Solver::kGathering, true);
  EXPECT_EQ(as_measured.outgoing, balanced.outgoing);
}

TEST(RadiositySolver, TheVolumesEndsTakeWhatEscapes) {
  const Forest forest = make_forest({leaf(4, 0, 2, 0.5), leaf(5, 0, 0, 0, kOutside)}, {1, 1, 1}, 1);
  RadiositySolver solver(forest);
  RadiosityResult result;
  result.links = {{.a = 0, .b = 1, .exchange = 1, .standard_error = 0.1}};
  solver.solve(result.links, {.solver = Solver::kShooting, .convergence = 1e-9}, false, result.statistics.iterations);
  solver.results(result);
  EXPECT_DOUBLE_EQ(result.statistics.energy.escaped[0], 2);
  EXPECT_DOUBLE_EQ(result.statistics.energy.absorbed_by_faces[0], 0);
  EXPECT_NEAR(result.standard_error[1], 0.1 * 3, 1e-12);  // of the link, times the radiosity of red and green
}

}  // namespace
}  // namespace gicube::samples
