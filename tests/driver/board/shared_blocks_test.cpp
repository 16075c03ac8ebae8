// Boards that share a volume's blocks: pictures, host rays and light have the bits of one endless card.
#include <exception>

#include "brick_scenes.h"
#include "gicube/testing.h"
#include "test.h"
#include "thread_exchange.h"

namespace gicube::reference {
namespace {

struct SharedBoards {
  ThreadRanks job;
  std::vector<Board> boards;

  SharedBoards(int ranks, const std::string& uri) : job(ranks) {
    for (std::size_t rank = 0; rank < job.ranks(); ++rank) {
      boards.push_back(Board::open(uri));
      boards.back().share_blocks(job.exchange(rank));
    }
  }
  template <typename Use>
  void on_all(const Use& use) {
    const auto errors = job.run([&](RayExchange& exchange) {
      const auto rank = static_cast<std::size_t>(exchange.rank());
      use(boards[rank], rank);
    });
    for (const auto& error : errors) {
      if (error) std::rethrow_exception(error);
    }
  }
  std::uint64_t sum(const char* counter) {
    std::uint64_t out = 0;
    for (Board& board : boards) out += board.counters().value(counter);
    return out;
  }
};

void expect_same_pictures(const std::string& base, const std::string& card, int ranks, int scenes, int pixels,
                          unsigned seed) {
  std::mt19937 random(seed);
  SharedBoards shared(ranks, base + "&set=asic.max_volume_voxels=" + card);
  Board large = Board::open(base + "&set=asic.max_volume_voxels=128");
  for (int scene = 0; scene < scenes; ++scene) {
    const Blobs blobs = make_blobs(random, 20, 70);
    const TransferFunction function = fog_and_balls(scene % 3 == 0 ? 0 : 0.02);
    large.set_transfer_function(function);
    large.load_volume(blobs.view());
    shared.on_all([&](Board& board, std::size_t) {
      board.set_transfer_function(function);
      board.load_volume(blobs.view());
    });
    for (int frame = 0; frame < 2; ++frame) {
      const View view = make_view(random, blobs.dims, pixels);
      const Image expected = large.render(view);
      std::vector<Image> got(shared.boards.size());
      shared.on_all([&](Board& board, std::size_t rank) { got[rank] = board.render(view); });
      for (const Image& image : got)
        ASSERT_EQ(image.pixels, expected.pixels) << base << ", scene " << scene << ", picture " << frame;
      for (Board& board : shared.boards) ASSERT_EQ(board.now(), shared.boards[0].now());
    }
  }
  EXPECT_EQ(shared.sum("dsp.forwarded_rays"), shared.sum("dsp.arrived_rays"));
  EXPECT_EQ(shared.sum("dsp.forwarded_rays") > 0, ranks > 1);
}

TEST(SharedBlocks, GivePicturesTheBitsOfAnEndlessCard) {
  for (const int ranks : {1, 2, 3, 4}) expect_same_pictures("emu:?set=asic.block_voxels=8", "32", ranks, 6, 40, 1);
}

TEST(SharedBlocks, GivePicturesTheBitsOfAnEndlessCardOnCardsThatStoreEightBlocks) {
  expect_same_pictures("emu:?set=asic.block_voxels=16", "32", 3, 3, 40, 4);
}

TEST(SharedBlocks, GivePicturesTheBitsOfAnEndlessCardIfEachCardCouldStoreItWhole) {
  expect_same_pictures("emu:?set=asic.block_voxels=8&set=asic.datapath=wide", "128", 4, 3, 40, 5);
}

TEST(SharedBlocks, GivePicturesTheBitsOfAnEndlessCardAtTheCycleLevel) {
  expect_same_pictures("emu:?fidelity=cycle&set=asic.block_voxels=8", "32", 2, 2, 12, 6);
}

void expect_same_rays(const std::string& base, const std::string& card, int ranks, int scenes, std::uint32_t rays,
                      unsigned seed) {
  constexpr std::array kTypes{RayType::kIntegrate, RayType::kFirstHit, RayType::kSegment, RayType::kOpacity,
                              RayType::kIntegral};
  std::mt19937 random(seed);
  SharedBoards shared(ranks, base + "&set=asic.max_volume_voxels=" + card);
  Board large = Board::open(base + "&set=asic.max_volume_voxels=128");
  for (int scene = 0; scene < scenes; ++scene) {
    const Blobs blobs = make_blobs(random, 20, 60);
    const TransferFunction function = fog_and_balls(0.02);
    large.set_transfer_function(function);
    large.load_volume(blobs.view());
    shared.on_all([&](Board& board, std::size_t) {
      board.set_transfer_function(function);
      board.load_volume(blobs.view());
    });
    for (const RayType type : kTypes) {
      std::vector<std::vector<HostRay>> sent(shared.boards.size());
      std::vector<RayBatch> got(sent.size());
      const bool between = type != RayType::kIntegrate && type != RayType::kFirstHit;
      for (std::size_t rank = 0; rank < sent.size(); ++rank) {
        sent[rank] = random_rays(random, blobs.dims, rank == 2 ? 0 : rays, between);  // a rank may have none
      }
      const RayRequest request{.type = type, .opacity = 0.6};
      shared.on_all(
          [&](Board& board, std::size_t rank) { got[rank] = board.receive(board.submit(sent[rank], request)); });
      for (std::size_t rank = 0; rank < sent.size(); ++rank) {
        const RayBatch expected = large.receive(large.submit(sent[rank], request));
        ASSERT_EQ(got[rank].rays, expected.rays) << base << ", scene " << scene << ", type " << static_cast<int>(type);
      }
    }
  }
  EXPECT_EQ(shared.sum("dsp.forwarded_rays"), shared.sum("dsp.arrived_rays"));
}

TEST(SharedBlocks, GiveHostRaysTheBitsOfAnEndlessCard) {
  for (const int ranks : {1, 2, 3, 4}) expect_same_rays("emu:?set=asic.block_voxels=8", "32", ranks, 3, 60, 2);
}

void expect_same_light(const std::string& base, const std::string& card, int ranks, int scenes, int pixels,
                       unsigned seed) {
  std::mt19937 random(seed);
  SharedBoards shared(ranks, base + "&set=asic.max_volume_voxels=" + card);
  Board large = Board::open(base + "&set=asic.max_volume_voxels=128");
  for (int scene = 0; scene < scenes; ++scene) {
    SCOPED_TRACE(base + ", ranks " + std::to_string(ranks) + ", scene " + std::to_string(scene));
    const Blobs blobs = make_blobs(random, 20, 60);
    const TransferFunction function = fog_and_balls(scene % 3 == 0 ? 0 : 0.02);
    const Material material = make_material(random);
    std::vector<Light> lights{make_light(random, blobs.dims)};
    if (scene % 2 == 0) lights.push_back(make_light(random, blobs.dims));
    const Illumination settings = make_illumination(random, static_cast<std::uint32_t>(scene));
    View view = make_view(random, blobs.dims, pixels);
    view.irradiance = true;
    View scattered = view;
    scattered.scatter = true;
    scattered.high_albedo = std::bernoulli_distribution(0.5)(random);
    const auto rays = random_rays(random, blobs.dims, 40);
    const RayRequest deposits{.type = RayType::kDeposit,
                              .albedo = settings.albedo,
                              .rules = settings.rules,
                              .sampling = sampling_of(scattered)};
    struct Results {
      LightingReport report, left;
      std::vector<float> irradiance, more;
      std::vector<Pixel> lit, scattered;
    };
    const auto results = [&](Board& board, std::span<const HostRay> own) {
      board.set_transfer_function(function);
      board.set_material(material);
      board.load_volume(blobs.view());
      Results out;
      out.report = board.illuminate(lights, settings);
      out.irradiance = board.read_irradiance();
      out.lit = board.render(view).pixels;
      out.scattered = board.render(scattered).pixels;
      board.clear_irradiance(1);
      board.receive(board.submit(own, deposits));
      out.left = *board.receive(board.submit(own, deposits)).lighting;  // on top of what is there
      out.more = board.read_irradiance();
      return out;
    };
    const Results expected = results(large, rays);
    std::vector<Results> got(shared.boards.size());
    shared.on_all([&](Board& board, std::size_t rank) {
      const std::size_t each = rays.size() / got.size(),
                        last = rank + 1 == got.size() ? rays.size() : (rank + 1) * each;
      got[rank] = results(board, std::span(rays).subspan(rank * each, last - rank * each));
    });
    for (const Results& of_rank : got) {
      expect_same_accounts(of_rank.report, expected.report);
      ASSERT_EQ(of_rank.irradiance, expected.irradiance);
      ASSERT_EQ(of_rank.lit, expected.lit);
      ASSERT_EQ(of_rank.scattered, expected.scattered);
      expect_same_accounts(of_rank.left, expected.left);
      ASSERT_EQ(of_rank.more, expected.more);
    }
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_EQ(shared.sum("dsp.forwarded_rays"), shared.sum("dsp.arrived_rays"));
}

TEST(SharedBlocks, GiveLightTheBitsOfAnEndlessCardOnTheWideDatapath) {
  expect_same_light("emu:?set=asic.block_voxels=16&set=asic.datapath=wide", "32", 3, 3, 16, 7);
}

TEST(SharedBlocks, GiveLightTheBitsOfAnEndlessCardAtTheCycleLevel) {
  expect_same_light("emu:?fidelity=cycle&set=asic.block_voxels=8", "32", 2, 1, 10, 8);
}

TEST(SharedBlocks, GiveLightTheBitsOfAnEndlessCard) {
  for (const int ranks : {1, 2, 3, 4}) expect_same_light("emu:?set=asic.block_voxels=8", "32", ranks, 6, 20, 3);
}

// A picture has fewer rows than there are ranks.
TEST(SharedBlocks, GiveAPictureOfOneRow) {
  SharedBoards shared(3, "emu:?set=asic.block_voxels=8");
  std::mt19937 random(9);
  const Blobs blobs = make_blobs(random, 30, 40);
  View view = make_view(random, blobs.dims, 20);
  view.height = 1;
  Board large = Board::open("emu:?set=asic.block_voxels=8");
  large.set_transfer_function(fog_and_balls(0.02));
  large.load_volume(blobs.view());
  const Image expected = large.render(view);
  shared.on_all([&](Board& board, std::size_t) {
    board.set_transfer_function(fog_and_balls(0.02));
    board.load_volume(blobs.view());
    const Image got = board.render(view);
    EXPECT_EQ(got.height, 1);
    EXPECT_EQ(got.pixels, expected.pixels);
  });
}

// One rank's blocks have all that is visible: it gets fewer of them, and the next picture is more even.
TEST(SharedBlocks, AreDealtAnewWhereRanksHadUnequalWork) {
  SharedBoards shared(2, "emu:?set=asic.block_voxels=8");
  const Dims dims{64, 32, 32};
  std::vector<std::byte> samples(64 * 32 * 32, std::byte{1});
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i % 64 < 24) samples[i] = std::byte{200};
  }
  View view;
  view.width = view.height = 48;
  view.eye = {32, 16, -60};
  view.look_at = {32, 16, 16};
  view.opacity_threshold = 1;
  const auto samples_of_picture = [&] {
    std::vector<std::uint64_t> out;
    for (Board& board : shared.boards) out.push_back(board.counters().value("pipeline.samples"));
    shared.on_all([&](Board& board, std::size_t) { board.render_to_framebuffer(view); });
    for (std::size_t rank = 0; rank < out.size(); ++rank) {
      out[rank] = shared.boards[rank].counters().value("pipeline.samples") - out[rank];
    }
    return out;
  };
  shared.on_all([&](Board& board, std::size_t) {
    board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{100, 0}, {101, 0.01}}});
    board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = dims});
  });
  const auto first = samples_of_picture();
  samples_of_picture();
  const auto third = samples_of_picture();
  EXPECT_EQ(first[0] + first[1], third[0] + third[1]);
  const auto most = [](const auto& each) { return std::max(each[0], each[1]); };
  EXPECT_GT(most(first), (first[0] + first[1]) * 9 / 10);
  EXPECT_LT(most(third), (third[0] + third[1]) * 7 / 10);
}

TEST(SharedBlocks, RefuseWhatNeedsAWholeVolume) {
  SharedBoards shared(1, "emu:");
  Board& board = shared.boards[0];
  const Blobs blobs = [] {
    std::mt19937 random(1);
    return make_blobs(random, 30, 40);
  }();
  board.load_volume(blobs.view());
  const char* const text = " does not work on a board that shares its volume's blocks with other ranks";
  EXPECT_EQ(message_of<Unsupported>([&] { board.verify_volume(); }), std::string("verify_volume()") + text);
  EXPECT_EQ(message_of<Unsupported>([&] { board.pair_factors({}, {}); }), std::string("pair_factors()") + text);
  EXPECT_EQ(message_of<Unsupported>([&] { board.save(); }), std::string("save()") + text);
  EXPECT_THROW(board.share_blocks(shared.job.exchange(0)), Rejected);
  EXPECT_THROW(board.share_blocks(nullptr), BadArgument);
  EXPECT_THROWS(Unsupported, "that stores 8 blocks or more",
                Board::open("emu:?set=asic.max_volume_voxels=32").share_blocks(shared.job.exchange(0)));
}

}  // namespace
}  // namespace gicube::reference
