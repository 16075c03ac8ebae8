// Pairs of elements that the driver proves to see each other, against the same pairs by rays.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

void load(Board& board) {
  const BoxVolume volume(40, 16, 22);  // fills part of the blocks 2 of each axis, and touches those before them
  board.load_volume(volume.view());
  board.set_transfer_function(step_function(0.3));
}

struct Problem {
  std::vector<Element> elements;
  std::vector<ElementPair> pairs;
};

// Boxes and patches anywhere, some on voxel and block faces.
Problem problem() {
  std::mt19937 engine(5);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(engine); };
  Problem made;
  for (int i = 0; i < 120; ++i) {
    Element element{i % 2 == 0 ? ElementKind::kBox : ElementKind::kPatch, {}, {2, 0, 0}, {0, 2, 0}, {}};
    element.origin = {draw(0, 37), draw(0, 37), draw(0, 37)};
    if (i % 3 == 0) element.origin = {std::floor(element.origin.x), 8.0 * (i % 5), std::floor(element.origin.z)};
    if (element.origin.y > 37) element.origin.y = 37;
    if (element.kind == ElementKind::kBox) element.w = {0, 0, 2};
    made.elements.push_back(element);
  }
  for (std::uint32_t i = 0; i < 600; ++i) made.pairs.push_back({i * 7 % 120, i * 31 % 120, i});
  return made;
}

// Without what a proof tells beyond the rays.
std::vector<PairFactor> unmarked(std::vector<PairFactor> factors) {
  for (PairFactor& factor : factors) factor.clear = false, factor.standard_error = 0;
  return factors;
}

TEST(ClearPairs, AreTheSameBitsAsWithRaysWhoeverMakesThem) {
  Board board = Board::open(kSmallBlocks);
  load(board);
  const Problem given = problem();
  for (const PairRays made : {PairRays::kByBoard, PairRays::kByHost}) {
    const PairRequest request{.rays = 33, .first = 5, .seed = 2, .made = made};
    const auto flags = board.empty_flags();
    const auto proved = board.pair_factors(given.elements, given.pairs, request);
    board.set_empty_flags(std::vector<std::uint8_t>(flags.size(), 0));
    const auto by_rays = board.pair_factors(given.elements, given.pairs, request);
    board.set_empty_flags(flags);
    const auto clear = std::count_if(proved.begin(), proved.end(), [](const auto& factor) { return factor.clear; });
    EXPECT_GT(clear, 100);
    EXPECT_LT(clear, 500);
    EXPECT_EQ(unmarked(proved), unmarked(by_rays));
    int found_more = 0;
    for (std::size_t i = 0; i < proved.size(); ++i) {
      EXPECT_LE(proved[i].standard_error, by_rays[i].standard_error);
      found_more += proved[i].standard_error < by_rays[i].standard_error ? 1 : 0;
    }
    EXPECT_GT(found_more, 50);
  }
}

TEST(ClearPairs, CostNeitherRaysNorBytesNorSimulatedTime) {
  Board board = Board::open(kSmallBlocks);
  load(board);
  const Element low{ElementKind::kBox, {1, 1, 1}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  const Element high{ElementKind::kBox, {1, 1, 36}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  for (const PairRays made : {PairRays::kByBoard, PairRays::kByHost}) {
    const Counters before = board.counters();
    const Picoseconds begin = board.now();
    const auto factor =
        board.pair_factors(std::array{low, high}, std::array{ElementPair{0, 1, 0}}, {.rays = 1000, .made = made})[0];
    EXPECT_TRUE(factor.clear);
    EXPECT_GT(factor.transported, 0);
    EXPECT_EQ(board.now(), begin);
    const Counters window = board.counters() - before;
    EXPECT_EQ(window.value("dsp.pair_rays"), 0u);
    EXPECT_EQ(window.value("pipeline.rays"), 0u);
  }
}

TEST(ClearPairs, FollowTheFlagsInForceAsTheBoardDoesAndNoneWithoutLeaping) {
  Board board = Board::open(kSmallBlocks);
  load(board);
  const Element low{ElementKind::kBox, {18, 18, 1}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  const Element high{ElementKind::kBox, {18, 18, 36}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  const auto factor = [&](bool leap = true) {
    return board.pair_factors(std::array{low, high}, std::array{ElementPair{0, 1, 0}}, {.leap = leap})[0];
  };
  const PairFactor through = factor();
  EXPECT_FALSE(through.clear);
  EXPECT_LT(through.transported, 0.2 * through.geometric);
  board.set_empty_flags(std::vector<std::uint8_t>(board.empty_flags().size(), 1));  // hides the box
  EXPECT_TRUE(factor().clear);
  EXPECT_GT(factor().transported, 0.99 * through.geometric);
  EXPECT_EQ(factor(false), through);
}

TEST(ClearPairs, CountAsDoneInTheProgress) {
  Board board = Board::open(kSmallBlocks);
  load(board);
  const Problem given = problem();
  std::uint32_t done = 0, all = 0;
  board.pair_factors(given.elements, given.pairs, {}, [&](std::uint32_t d, std::uint32_t a) { done = d, all = a; });
  EXPECT_EQ(done, 600u);
  EXPECT_EQ(all, 600u);
}

}  // namespace
}  // namespace gicube
