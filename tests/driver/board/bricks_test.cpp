// Pictures of volumes that the card does not store whole have the same bits as on a card that does.
#include <sys/resource.h>

#include <csignal>

#include "brick_scenes.h"
#include "gicube/testing.h"
#include "test.h"

namespace gicube::reference {
namespace {

void expect_same_pictures(const std::string& base, const std::string& card, const std::string& endless, int scenes,
                          int least, int most, int pixels, unsigned seed, const OpenOptions& options = {}) {
  std::mt19937 random(seed);
  BrickBoards boards(base, card, endless, options);
  auto& [small, large] = boards;
  for (int scene = 0; scene < scenes; ++scene) {
    const Blobs blobs = make_blobs(random, least, most);
    const TransferFunction function = fog_and_balls(scene % 3 == 0 ? 0 : 0.02);
    for (Board* board : {&small, &large}) {
      board->set_transfer_function(function);
      board->load_volume(blobs.view());
    }
    for (int frame = 0; frame < 2; ++frame) {
      const View view = make_view(random, blobs.dims, pixels);
      const Image expected = large.render(view);
      ASSERT_EQ(small.render(view).pixels, expected.pixels) << base << ", scene " << scene << ", picture " << frame;
    }
  }
  EXPECT_GT(small.counters().value("dsp.waits"), 0u);
  EXPECT_EQ(small.counters().value("pipeline.samples"), large.counters().value("pipeline.samples"));
}

TEST(Bricks, GiveTheBitsOfAnEndlessCard) {
  expect_same_pictures("emu:?set=asic.block_voxels=8", "32", "128", 25, 36, 90, 40, 1);
}

TEST(Bricks, GiveTheBitsOfAnEndlessCardThatStoresEightBlocks) {
  expect_same_pictures("emu:?set=asic.block_voxels=16", "32", "128", 15, 36, 90, 40, 2);
}

TEST(Bricks, GiveTheBitsOfAnEndlessCardOnTheWideDatapath) {
  expect_same_pictures("emu:?set=asic.block_voxels=8&set=asic.datapath=wide", "32", "128", 10, 36, 90, 40, 3);
}

// So many files without a name does this process have open.
std::ptrdiff_t scratch_files() {
  return std::ranges::count_if(std::filesystem::directory_iterator("/proc/self/fd"), [](const auto& entry) {
    std::error_code gone;
    return std::filesystem::read_symlink(entry, gone).string().find("gicube-volume") != std::string::npos;
  });
}

TEST(Bricks, GiveTheBitsOfAnEndlessCardIfRaysWaitInAFile) {
  const OpenOptions options{.max_waiting_rays = 1024};
  const std::ptrdiff_t before = scratch_files();
  expect_same_pictures("emu:?set=asic.block_voxels=8", "32", "128", 4, 50, 80, 60, 6, options);
  expect_same_pictures("emu:?fidelity=cycle&set=asic.block_voxels=16", "32", "128", 1, 50, 60, 36, 7, options);
  EXPECT_EQ(scratch_files(), before) << "they go with their boards";
}

// Files of this process may not grow beyond a size while it lives.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : before_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &limit_);
    const rlimit full{bytes, limit_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &full);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &limit_);
    std::signal(SIGXFSZ, before_);
  }

 private:
  rlimit limit_{};
  void (*before_)(int);
};

TEST(Bricks, NameTheFolderIfItIsFullOfRaysThatWaitAndTheBoardLivesOn) {
  std::mt19937 random(8);
  const Blobs blobs = make_blobs(random, 60, 80);
  BrickBoards boards("emu:?set=asic.block_voxels=8", "32", "128", {.max_waiting_rays = 1024});
  View view = make_view(random, blobs.dims, 120);
  for (Board* board : boards.both()) {
    board->set_transfer_function(fog_and_balls(0.02));
    board->load_volume(blobs.view());
  }
  view.eye = {40, 40, -150};
  view.look_at = {40, 40, 40};
  const Image expected = boards.large.render(view);
  {
    const FullDisk full(64 * 1024);
    EXPECT_THROWS(Error, "volume: expected a folder /", boards.small.render(view));
    EXPECT_THROW(boards.small.read_framebuffer(), Rejected);
  }
  EXPECT_EQ(boards.small.render(view).pixels, expected.pixels);
  EXPECT_EQ(scratch_files(), 1);
}

TEST(Bricks, GiveTheBitsOfAnEndlessCardAtTheCycleLevel) {
  expect_same_pictures("emu:?fidelity=cycle&set=asic.block_voxels=16", "32", "128", 3, 36, 60, 16, 4);
}

TEST(Bricks, GiveTheBitsOfAnEndlessCardAtTheCycleLevelOnTheWideDatapath) {
  expect_same_pictures("emu:?fidelity=cycle&set=asic.block_voxels=16&set=asic.datapath=wide", "32", "128", 1, 36, 60,
                       16, 5);
}

// 32 x 32 x 128 voxels in 2 x 2 x 8 blocks of 16^3, on a card of 8 blocks: two layers.
class Column : public testing::Test {
 protected:
  static constexpr int kLayers = 8;
  static constexpr double kBlockBytes = 16 * 16 * 16 * 9 / 2;

  static View along_z() {
    View view;
    view.eye = {15.5, 15.5, -100};
    view.look_at = {15.5, 15.5, 0};
    view.orthographic_height = 30;
    view.width = view.height = 24;
    view.shade = false;  // so that no table goes down with the picture
    return view;
  }
  Board load(std::byte value, double opacity, int from_layer = 0) {
    Board board = Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=32");
    std::vector<std::byte> samples(32 * 32 * 128);
    std::fill(samples.begin() + from_layer * 16 * 32 * 32, samples.end(), value);
    board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{50, 0}, {60, opacity}}});
    board.load_volume(
        {.samples = samples, .type = SampleType::kUint8, .dims = {32, 32, 128}, .range = ValueRange{0, 255}});
    return board;
  }
  // Blocks that go down the bus for the first picture.
  static double blocks_of(Board& board, const View& view) {
    const std::uint64_t before = board.counters().value("bus.volume.bytes");
    board.render_to_framebuffer(view);
    return static_cast<double>(board.counters().value("bus.volume.bytes") - before) / kBlockBytes;
  }
};

// A layer needs the next one's faces, which stays on the card until its own samples are taken.
TEST_F(Column, SendsEachLayerOnce) {
  Board board = load(std::byte{200}, 0.001);
  EXPECT_EQ(blocks_of(board, along_z()), kLayers * 4);
}

TEST_F(Column, SendsNoLayerBehindWhatIsOpaque) {
  Board board = load(std::byte{200}, 1);
  EXPECT_EQ(blocks_of(board, along_z()), 8);
}

TEST_F(Column, SendsNoEmptyLayer) {
  Board board = load(std::byte{200}, 0.001, 5);  // layers 5, 6, 7; the faces of 4 have some of 5
  EXPECT_EQ(blocks_of(board, along_z()), 4 * 4);
}

TEST_F(Column, StaysOnTheCardForTheNextPictureIfItFits) {
  Board board = load(std::byte{200}, 0.001, 7);
  board.render_to_framebuffer(along_z());
  const std::uint64_t waits = board.counters().value("dsp.waits");
  EXPECT_GT(waits, 0u);
  board.render_to_framebuffer(along_z());
  EXPECT_EQ(board.counters().value("dsp.waits"), waits);
}

TEST_F(Column, IsRefusedByNameWhereTheCardMustStoreItWhole) {
  Board board = load(std::byte{200}, 0.1);
  const auto expect_refused = [&](const auto& call, const char* what) {
    try {
      call();
      ADD_FAILURE() << what;
    } catch (const Unsupported& error) {
      EXPECT_THAT(error.what(), HasSubstr(std::string("dims: ") + what));
      EXPECT_THAT(error.what(), HasSubstr("at most 8 blocks of 16^3 voxels"));
      EXPECT_THAT(error.what(), HasSubstr("got 32 x 32 x 128 voxels in 32 blocks"));
    }
  };
  expect_refused([&] { board.clear_sums(1); }, "clear_sums()");
  expect_refused([&] { board.write_volume({{0, 0, 0}, {1, 1, 1}}, std::vector<float>(1)); }, "write_volume()");
  expect_refused([&] { board.verify_volume(); }, "verify_volume()");
  expect_refused([&] { board.submit(std::vector<HostRay>(1), {.type = RayType::kBackproject}); },
                 "RayType::kBackproject");
  board.set_material(
      {.scattering = 0.5, .bsdf = Bsdf::kTrap, .seen_through_scattering = true, .routine = kHostRoutine});
  board.set_scattering_routine([](const ScatterEvent& event) { return ScatterAnswer{event.direction, 1}; });
  expect_refused([&] { board.illuminate({}, {}); }, "illuminate() with the application's routine");
  View view = along_z();
  view.scatter = true;
  expect_refused([&] { board.render(view); }, "View::scatter with the application's routine");
  board.set_material({});
  EXPECT_NO_THROW(board.render(along_z()));
}

TEST_F(Column, IsForgottenByASmallerVolume) {
  Board board = load(std::byte{200}, 0.1);
  board.render_to_framebuffer(along_z());
  const BoxVolume box(32, 8, 23);
  board.load_volume(box.view());
  board.set_transfer_function(step_function(0.1));
  Board other = Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=32");
  other.load_volume(box.view());
  other.set_transfer_function(step_function(0.1));
  EXPECT_EQ(board.render(front_view(32)).pixels, other.render(front_view(32)).pixels);
  EXPECT_NO_THROW(board.verify_volume());
}

TEST_F(Column, GoesOnOnANewBoard) {
  auto [board, id] = open_board_process();
  std::vector<std::byte> samples(std::size_t{80} * 80 * 80, std::byte{200});
  board.set_transfer_function(step_function(0.01));
  board.load_volume(
      {.samples = samples, .type = SampleType::kUint8, .dims = {80, 80, 80}, .range = ValueRange{0, 255}});
  const Image before = board.render(front_view(80));
  ASSERT_GT(board.counters().value("dsp.waits"), 0u);
  kill(id, SIGKILL);
  EXPECT_THROW(board.render(front_view(80)), DeviceLost);
  EXPECT_TRUE(board.reopen().volume);
  EXPECT_EQ(board.render(front_view(80)).pixels, before.pixels);
}

TEST(BricksOfACard, NeedEightBlocks) {
  Board board = Board::open("emu:?set=asic.block_voxels=32&set=asic.max_volume_voxels=32");
  const BoxVolume box(40, 8, 23);
  try {
    board.load_volume(box.view());
    ADD_FAILURE();
  } catch (const BadArgument& error) {
    EXPECT_EQ(error.field(), "dims[0]");
  }
}

}  // namespace
}  // namespace gicube::reference
