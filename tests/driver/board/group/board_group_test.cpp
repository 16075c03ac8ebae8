// Pictures, rays and light of several boards have the bits of one.
#include "gicube/board_group.h"
#include "../brick_scenes.h"
#include "test.h"

namespace gicube::reference {
namespace {

const std::string kBoards = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64&threads=1";

BoardGroup open_group(const std::string& base, int boards) {
  return BoardGroup::open(base + "&boards=" + std::to_string(boards));
}

View make_wide_view(std::mt19937& random, const Dims& dims) {
  View view = make_view(random, dims, 24);
  view.height = std::uniform_int_distribution(1, 61)(random);
  if (random() % 4 == 0) view.samples_per_axis = 4;
  return view;
}

std::vector<HostRay> make_rays(std::mt19937& random, const Dims& dims, std::size_t count) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  std::vector<HostRay> rays;
  for (std::size_t i = 0; i < count; ++i) {
    rays.push_back({.id = static_cast<std::uint32_t>(random()),
                    .position = {within(0, dims[0] - 1), within(0, dims[1] - 1), within(0, dims[2] - 1)},
                    .direction = {within(-1, 1), within(-1, 1), within(0.1, 1)},
                    .length = within(0, 40)});
  }
  return rays;
}

void expect_same_scenes(const std::string& base, int boards, int scenes, unsigned seed, int least, int most) {
  std::mt19937 random(seed);
  Board one = Board::open(base);
  BoardGroup group = open_group(base, boards);
  for (int scene = 0; scene < scenes; ++scene) {
    const Blobs blobs = make_blobs(random, least, most);
    const TransferFunction function = fog_and_balls(scene % 3 == 0 ? 0 : 0.02);
    const auto set_up = [&](Board& board) {
      board.set_transfer_function(function);
      board.load_volume(blobs.view());
    };
    set_up(one);
    group.on_all(set_up);
    for (int frame = 0; frame < 2; ++frame) {
      const View view = make_wide_view(random, blobs.dims);
      const Image expected = one.render(view);
      ASSERT_TRUE(group.render(view) == expected)
          << boards << " boards, scene " << scene << ", picture " << frame << ", rows " << view.height;
    }
    for (const RayType type : {RayType::kIntegrate, RayType::kFirstHit, RayType::kSegment, RayType::kOpacity}) {
      const auto rays = make_rays(random, blobs.dims, 1 + random() % 3000);
      const RayRequest request{.type = type, .opacity = 0.4};
      const RayBatch expected = one.receive(one.submit(rays, request));
      ASSERT_TRUE(group.trace(rays, request).rays == expected.rays) << boards << " boards, scene " << scene;
    }
  }
}

TEST(BoardGroup, OfOneToFourBoardsGivesThePicturesAndRaysOfOne) {
  for (const int boards : {1, 2, 3, 4}) expect_same_scenes(kBoards, boards, 8, static_cast<unsigned>(boards), 20, 60);
}

TEST(BoardGroup, GivesThePicturesAndRaysOfOneWhoseVolumeNoCardStores) {
  const std::string base = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32&threads=1";
  for (const int boards : {2, 3}) expect_same_scenes(base, boards, 4, 10 + static_cast<unsigned>(boards), 36, 60);
}

TEST(BoardGroup, GivesThePicturesOfOneAtEachLevelOnTheWideDatapathAndInRuns) {
  const std::string card = "&set=asic.block_voxels=16&set=asic.max_volume_voxels=64&threads=1";
  expect_same_scenes("emu:?fidelity=cycle" + card, 2, 1, 20, 20, 40);
  expect_same_scenes("emu:?fidelity=cycle&set=asic.datapath=wide" + card, 3, 1, 21, 20, 40);
  expect_same_scenes("emu:?set=dsp.run_rays=16" + card, 3, 3, 22, 20, 60);
}

TEST(BoardGroup, GivesThePictureOfOneInStripsOfOneRowAndLeavesBoardsWithoutRowsOut) {
  Board one = Board::open(kBoards);
  BoardGroup group = open_group(kBoards, 4);
  const auto set_up = [](Board& board) { load_box(board, 0.3); };
  set_up(one);
  group.on_all(set_up);
  for (const int height : {1, 2, 3, 5, 9}) {
    View view = front_view(32);
    view.height = height;
    view.samples_per_axis = 4;
    view.filter = PixelFilter::kTent;
    EXPECT_TRUE(group.render(view) == one.render(view)) << height << " rows";
  }
}

TEST(BoardGroup, OfDifferentLevelsAndBusesGivesThePictureOfOne) {
  Board one = Board::open(kBoards);
  const std::vector<std::string> addresses{kBoards + "&fidelity=cycle&bus=agp2x", kBoards,
                                           kBoards + "&fidelity=cycle&set=asic.processors=8"};
  BoardGroup group = BoardGroup::open(addresses, {.buses = HostBuses::kOwn});
  const BoxVolume volume(24, 4, 19);
  const auto set_up = [&](Board& board) {
    board.set_transfer_function(step_function(0.3));
    board.load_volume(volume.view());
  };
  set_up(one);
  group.on_all(set_up);
  EXPECT_TRUE(group.render(front_view(24)) == one.render(front_view(24)));
  EXPECT_LT(group.times()[0].bus, group.times()[1].bus) << "AGP 2x is faster than PCI";
}

class LitGroup : public testing::TestWithParam<const char*> {};

TEST_P(LitGroup, HasTheLightOfOneBoardAndItsPictures) {
  const std::string base = GetParam();
  std::mt19937 random(40);
  const Blobs blobs = make_blobs(random, 36, 48);
  Board one = Board::open(base);
  BoardGroup group = open_group(base, 3);
  const std::vector<Light> lights{DirectionalLight{.towards = {0.2, 1, 0.3}}};
  const auto set_up = [&](Board& board) {
    board.set_transfer_function(fog_and_balls(0.02));
    board.set_material({.scattering = 0.4, .bsdf = Bsdf::kSpecular, .seen_through_scattering = true});
    board.load_volume(blobs.view());
    board.illuminate(lights, {});
  };
  set_up(one);
  group.on_all(set_up);
  View view = make_wide_view(random, blobs.dims);
  view.height = 40;
  view.irradiance = true;
  EXPECT_TRUE(group.render(view) == one.render(view));
  view.scatter = true;
  EXPECT_TRUE(group.render(view) == one.render(view));

  auto rays = make_rays(random, blobs.dims, 500);
  for (HostRay& ray : rays) ray.energy = 1;
  const auto expected = one.receive(one.submit(rays, {.type = RayType::kDeposit}));
  const RayBatch left = group.trace(rays, {.type = RayType::kDeposit});
  ASSERT_TRUE(left.lighting && left.rays.empty());
  EXPECT_EQ(left.lighting->deposited, expected.lighting->deposited);
  const auto irradiance = one.read_irradiance();
  for (std::size_t i = 0; i < group.size(); ++i) EXPECT_EQ(group.board(i).read_irradiance(), irradiance) << i;
}

INSTANTIATE_TEST_SUITE_P(Cards, LitGroup,
                         testing::Values("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64&threads=1",
                                         "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32&threads=1"));

}  // namespace
}  // namespace gicube::reference
