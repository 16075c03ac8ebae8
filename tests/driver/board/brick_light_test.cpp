// Light in volumes that the card does not store whole: its irradiance, its accounts and the pictures that it lights
// have the same bits as on a card that stores them whole.
#include "brick_scenes.h"
#include "gicube/testing.h"
#include "test.h"

namespace gicube::reference {
namespace {

void expect_same_light(const std::string& base, const std::string& card, int scenes, int least, int most, int pixels,
                       unsigned seed, const OpenOptions& options = {}) {
  std::mt19937 random(seed);
  BrickBoards boards(base, card, "128", options);
  auto& [small, large] = boards;
  for (int scene = 0; scene < scenes; ++scene) {
    SCOPED_TRACE(base + ", scene " + std::to_string(scene));
    const Blobs blobs = make_blobs(random, least, most);
    const Material material = make_material(random);
    const double fog = scene % 3 == 0 ? 0 : 0.02;
    for (Board* board : boards.both()) {
      board->set_transfer_function(fog_and_balls(fog));
      board->set_material(material);
      board->load_volume(blobs.view());
    }
    std::vector<Light> lights{make_light(random, blobs.dims)};
    if (scene % 2 == 0) lights.push_back(make_light(random, blobs.dims));
    const auto flip = [&] { return std::bernoulli_distribution(0.5)(random); };
    const Illumination settings = make_illumination(random, static_cast<std::uint32_t>(scene));
    expect_same_accounts(small.illuminate(lights, settings), large.illuminate(lights, settings));
    ASSERT_EQ(small.read_irradiance(), large.read_irradiance());

    View view = make_view(random, blobs.dims, pixels);
    view.irradiance = true;
    ASSERT_EQ(small.render(view).pixels, large.render(view).pixels) << "lit";
    view.scatter = true;
    view.high_albedo = flip();
    view.irradiance = flip();
    ASSERT_EQ(small.render(view).pixels, large.render(view).pixels) << "scattered";

    const auto rays = random_rays(random, blobs.dims, 50);
    for (Board* board : boards.both()) board->clear_irradiance(1);
    const RayRequest deposits{
        .type = RayType::kDeposit, .albedo = settings.albedo, .rules = settings.rules, .sampling = sampling_of(view)};
    const RayBatch got = small.receive(small.submit(rays, deposits));
    const RayBatch expected = large.receive(large.submit(rays, deposits));
    expect_same_accounts(*got.lighting, *expected.lighting);
    ASSERT_EQ(small.read_irradiance(), large.read_irradiance());
    if (testing::Test::HasFailure()) return;
  }
  const Counters counters = small.counters();
  EXPECT_GT(counters.value("dsp.waits"), 0u);
  EXPECT_GT(counters.value("dsp.host_deposits"), 0u);
  EXPECT_GE(counters.value("dsp.block_loads"), counters.value("dsp.min_block_loads"));
  EXPECT_GT(counters.value("dsp.min_block_loads"), 0u);
  EXPECT_EQ(counters.value("pipeline.samples"), large.counters().value("pipeline.samples"));
  EXPECT_EQ(counters.value("pipeline.deposits"), large.counters().value("pipeline.deposits"));
}

TEST(LightInBricks, HasTheBitsOfAnEndlessCard) {
  expect_same_light("emu:?set=asic.block_voxels=8", "32", 32, 36, 70, 24, 21);
}

TEST(LightInBricks, HasTheBitsOfAnEndlessCardOnOneThatStoresEightBlocks) {
  expect_same_light("emu:?set=asic.block_voxels=16", "32", 16, 36, 70, 24, 22);
}

TEST(LightInBricks, HasTheBitsOfAnEndlessCardOnTheWideDatapath) {
  expect_same_light("emu:?set=asic.block_voxels=8&set=asic.datapath=wide", "32", 8, 36, 70, 24, 23);
}

TEST(LightInBricks, HasTheBitsOfAnEndlessCardIfRaysWaitInAFile) {
  expect_same_light("emu:?set=asic.block_voxels=8", "32", 4, 36, 70, 24, 21, {.max_waiting_rays = 1024});
}

TEST(LightInBricks, HasTheBitsOfAnEndlessCardAtTheCycleLevel) {
  expect_same_light("emu:?fidelity=cycle&set=asic.block_voxels=8", "32", 2, 36, 56, 12, 48);
  expect_same_light("emu:?fidelity=cycle&set=asic.block_voxels=8&set=asic.datapath=wide", "32", 1, 36, 56, 12, 48);
}

}  // namespace
}  // namespace gicube::reference
