#include "form_factors/program/options.h"

#include "scene/program/board_run.h"
#include "test.h"

namespace gicube::samples {
namespace {

TEST(RandomPairs, AreDrawnFromAllVoxelsAndNoneIsPairedWithItself) {
  const RandomPairs pairs = random_pairs({3, 4, 5}, 4000, 1);
  ASSERT_EQ(pairs.pairs.size(), 4000u);
  std::set<std::tuple<double, double, double>> places;
  for (const ElementPair& pair : pairs.pairs) {
    const Element &a = pairs.elements[pair.a], &b = pairs.elements[pair.b];
    EXPECT_FALSE(a.origin == b.origin);
    places.insert({a.origin.x, a.origin.y, a.origin.z});
  }
  EXPECT_EQ(places.size(), 60u);
  for (const Element& element : pairs.elements) {
    EXPECT_GE(element.origin.x, 0);
    EXPECT_LE(element.origin.x + element.u.x, 2);
    EXPECT_GT(element.w.z, 0.4);
  }
  EXPECT_EQ(random_pairs({3, 4, 5}, 10, 1).elements[7].origin, pairs.elements[7].origin);
  EXPECT_NE(random_pairs({3, 4, 5}, 10, 2).elements[7].origin, pairs.elements[7].origin);
}

Board fog_board(const std::string& options, double opacity) {
  BoardOptions board;
  board.board = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32" + options;
  Board opened = open_board(board);
  const std::vector<std::byte> samples(24 * 24 * 24, std::byte{100});
  opened.load_volume({.samples = samples, .dims = {24, 24, 24}});
  opened.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, opacity}}});
  return opened;
}

// In a uniform medium the transmittance of a pair is e^-(kappa r), up to the pair's own width.
TEST(Visibility, IsTheMeanTransmittanceOfThePairs) {
  Board board = fog_board("", 1 - std::exp(-0.05));
  const RandomPairs pairs = random_pairs({24, 24, 24}, 3000, 4);
  const Visibility seen = look(board, pairs, {.rays = 16});
  double expected = 0;
  for (const ElementPair& pair : pairs.pairs) {
    const Element &a = pairs.elements[pair.a], &b = pairs.elements[pair.b];
    const auto middle = [](const Element& e) { return e.origin + 0.5 * (e.u + e.v + e.w); };
    expected += std::exp(-0.05 * length(middle(b) - middle(a))) / 3000;
  }
  EXPECT_NEAR(seen.transmittance, expected, 0.003);
  EXPECT_EQ(seen.rays, 48'000u);
  EXPECT_EQ(seen.clear_pairs, 0u);
  EXPECT_EQ(seen.hidden, 0u);
  EXPECT_GT(seen.duration, 0u);
  EXPECT_GT(seen.standard_error, 0.001);
  EXPECT_LT(seen.standard_error, 0.01);
}

TEST(Visibility, OfAnEmptyVolumeIsKnownWithoutRays) {
  Board board = fog_board("", 0);
  const Visibility seen = look(board, random_pairs({24, 24, 24}, 100, 4), {.rays = 16});
  EXPECT_EQ(seen.clear_pairs, 100u);
  EXPECT_NEAR(seen.transmittance, 1, 1e-6);
  EXPECT_EQ(seen.duration, 0u);
}

TEST(Visibility, SaysWhichPartOfTheBoardBoundsIt) {
  const RandomPairs pairs = random_pairs({24, 24, 24}, 500, 4);
  std::vector<double> transmittances;
  for (const PairRays made : {PairRays::kByBoard, PairRays::kByHost}) {
    Board board = fog_board("&fidelity=cycle", 0.05);
    const Visibility seen = look(board, pairs, {.rays = 32, .made = made});
    transmittances.push_back(seen.transmittance);
    const Utilisation& u = seen.utilisation;
    ASSERT_TRUE(u.pipelines && u.sorter && u.memory);
    for (const double share : {u.bus_down, u.bus_up, u.dsp, *u.pipelines, *u.sorter, *u.memory}) {
      EXPECT_GT(share, 0);
      EXPECT_LE(share, 1);
    }
    if (made == PairRays::kByBoard) {
      EXPECT_EQ(u.bound(), "DSP");
      EXPECT_LT(u.bus_down, 0.2);
    } else {
      EXPECT_GT(u.bus_down, 0.3);
    }
  }
  EXPECT_EQ(transmittances[0], transmittances[1]);
}

}  // namespace
}  // namespace gicube::samples
