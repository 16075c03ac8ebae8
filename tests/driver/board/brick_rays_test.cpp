// Host rays of volumes that the card does not store whole have the same bits as on a card that does.
#include "brick_scenes.h"
#include "gicube/pair.h"
#include "gicube/testing.h"
#include "test.h"

namespace gicube::reference {
namespace {

class Scene {
 public:
  Scene(unsigned seed, const Dims& dims) : random_(seed), dims_(dims) {}

  double within(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  Vec3 point() { return {within(0, dims_[0] - 1), within(0, dims_[1] - 1), within(0, dims_[2] - 1)}; }
  RayRequest request(RayType type) {
    return {.type = type,
            .opacity = within(0.3, 1),
            .step = within(0, 1) < 0.5 ? 0.5 : within(0.4, 3),
            .leap = within(0, 1) < 0.7};
  }
  std::vector<HostRay> rays(RayType type, std::size_t count) {
    std::vector<HostRay> out;
    const bool between = type != RayType::kIntegrate && type != RayType::kFirstHit;
    for (std::size_t i = 0; i < count; ++i) {
      const auto id = static_cast<std::uint32_t>(i % 5);  // ids need not differ
      const Vec3 from = point(), to = point();
      out.push_back(between ? ray_between(id, from, to) : HostRay{.id = id, .position = from, .direction = to - from});
    }
    return out;
  }

 private:
  std::mt19937 random_;
  Dims dims_;
};

constexpr std::array kTypes{RayType::kIntegrate, RayType::kFirstHit, RayType::kSegment, RayType::kOpacity,
                            RayType::kIntegral};

void expect_same_rays(const std::string& base, const std::string& card, int scenes, int least, int most,
                      std::size_t rays, unsigned seed) {
  std::mt19937 random(seed);
  BrickBoards boards(base, card);
  for (int scene = 0; scene < scenes; ++scene) {
    const Blobs blobs = make_blobs(random, least, most);
    View view = make_view(random, blobs.dims, 8);
    for (Board* board : boards.both()) {
      board->set_transfer_function(fog_and_balls(scene % 3 == 0 ? 0 : 0.02));
      board->load_volume(blobs.view());
    }
    Scene of(seed * 1000 + static_cast<unsigned>(scene), blobs.dims);
    for (const RayType type : kTypes) {
      RayRequest request = of.request(type);
      request.sampling = sampling_of(view);
      const auto sent = of.rays(type, rays);
      const RayBatch expected = boards.large.receive(boards.large.submit(sent, request));
      const RayBatch got = boards.small.receive(boards.small.submit(sent, request));
      ASSERT_EQ(got.rays, expected.rays) << base << ", scene " << scene << ", type " << static_cast<int>(type);
    }
  }
  EXPECT_GT(boards.small.counters().value("dsp.waits"), 0u);
  EXPECT_EQ(boards.small.counters().value("pipeline.samples"), boards.large.counters().value("pipeline.samples"));
}

TEST(HostRaysInBricks, HaveTheBitsOfAnEndlessCard) {
  expect_same_rays("emu:?set=asic.block_voxels=8", "32", 25, 36, 64, 200, 11);
}

TEST(HostRaysInBricks, HaveTheBitsOfAnEndlessCardOnOneThatStoresEightBlocks) {
  expect_same_rays("emu:?set=asic.block_voxels=16", "32", 12, 36, 64, 200, 12);
}

TEST(HostRaysInBricks, HaveTheBitsOfAnEndlessCardOnTheWideDatapath) {
  expect_same_rays("emu:?set=asic.block_voxels=8&set=asic.datapath=wide", "32", 10, 36, 64, 200, 13);
}

TEST(HostRaysInBricks, HaveTheBitsOfAnEndlessCardAtTheCycleLevel) {
  expect_same_rays("emu:?fidelity=cycle&set=asic.block_voxels=16", "32", 2, 36, 60, 60, 14);
  expect_same_rays("emu:?fidelity=cycle&set=asic.block_voxels=16&set=asic.datapath=wide", "32", 1, 36, 60, 60, 15);
}

class HostRaysOfACard : public testing::Test {
 protected:
  HostRaysOfACard() {
    std::mt19937 random(16);
    const Blobs blobs = make_blobs(random, 60, 80);
    dims_ = blobs.dims;
    for (Board* board : boards_.both()) {
      board->set_transfer_function(fog_and_balls(0.02));
      board->load_volume(blobs.view());
    }
  }

  BrickBoards boards_{"emu:?set=asic.block_voxels=16", "32"};
  Dims dims_{};
};

TEST_F(HostRaysOfACard, GoThroughManyCommandsOfABatchTogether) {
  Scene of(17, dims_);
  const auto rays = of.rays(RayType::kOpacity, 10'000);  // three commands
  const RayRequest request{.type = RayType::kOpacity};
  const RayBatch expected = boards_.large.receive(boards_.large.submit(rays, request));
  EXPECT_EQ(boards_.small.receive(boards_.small.submit(rays, request)).rays, expected.rays);
}

TEST_F(HostRaysOfACard, AreThoseOfPairs) {
  Scene of(19, dims_);
  std::vector<Element> elements;
  std::vector<ElementPair> pairs;
  for (std::uint32_t i = 0; i < 12; ++i) {
    const auto inside = [&](int axis) { return of.within(1, dims_[static_cast<std::size_t>(axis)] - 4.0); };
    elements.push_back({.origin = {inside(0), inside(1), inside(2)}, .u = {1.5, 0, 0}, .v = {0, 1.5, 0}});
    for (std::uint32_t j = 0; j < i; ++j) pairs.push_back({j, i, 100 * i + j});
  }
  const auto expected = boards_.large.pair_factors(elements, pairs, {});
  const auto got = boards_.small.pair_factors(elements, pairs, {});
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) EXPECT_EQ(got[i].transported, expected[i].transported) << i;
}

TEST_F(HostRaysOfACard, AreCompleteWhenSubmitReturns) {
  Scene of(20, dims_);
  const auto rays = of.rays(RayType::kSegment, 50);
  const Ticket ticket = boards_.small.submit(rays, {.type = RayType::kSegment});
  EXPECT_FALSE(boards_.small.cancel(ticket));
  const Picoseconds now = boards_.small.now();
  const auto arrived = boards_.small.poll();
  ASSERT_EQ(arrived.size(), 1u);
  EXPECT_EQ(arrived[0].completed, now);
  EXPECT_EQ(arrived[0].rays.size(), rays.size());
}

TEST_F(HostRaysOfACard, LetTheVolumeBeRead) {
  const VoxelBox box{{3, 5, 7}, {40, 30, 20}};
  EXPECT_EQ(boards_.small.read_volume(box), boards_.large.read_volume(box));
}

}  // namespace
}  // namespace gicube::reference
