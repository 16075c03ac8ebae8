#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

int sum(const std::vector<std::uint8_t>& flags) { return std::accumulate(flags.begin(), flags.end(), 0); }

TEST(Load, CallsThatNeedAVolumeSaySo) {
  Board board = Board::open("emu:");
  EXPECT_THROWS(Rejected, "load_volume", board.value_range());
  EXPECT_THROW(board.blocks(), Rejected);
  EXPECT_THROW(board.empty_flags(), Rejected);
  EXPECT_THROW(board.set_empty_flags({}), Rejected);
  EXPECT_THROW(board.render_to_framebuffer(front_view(32)), Rejected);
  EXPECT_THROW(board.submit(std::span<const HostRay>{}), Rejected);
}

TEST(Load, GivesTheValueRangeAndTheBlocks) {
  Board board = Board::open(kSmallBlocks);
  board.load_volume(BoxVolume(20, 8, 12).view());
  EXPECT_EQ(board.value_range(), (ValueRange{0, 255}));
  EXPECT_EQ(board.blocks(), (Dims{3, 3, 3}));
}

TEST(Load, ABadVolumeLeavesTheFormerOne) {
  Board board = box_board(0.5);
  const Image before = board.render(front_view(32));
  std::vector<float> samples(8, 0.0f);
  samples[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(board.load_volume(
                   {.samples = std::as_bytes(std::span(samples)), .type = SampleType::kFloat32, .dims = {2, 2, 2}}),
               BadArgument);
  EXPECT_THROW(
      board.load_volume({.samples = std::as_bytes(std::span(samples)), .type = SampleType::kUint8, .dims = {65, 2, 2}}),
      BadArgument);
  EXPECT_EQ(board.blocks(), (Dims{4, 4, 4}));
  EXPECT_EQ(board.render(front_view(32)), before);
}

TEST(Load, ProgressTellsOfEachBlockThatIsSent) {
  Board board = Board::open(kSmallBlocks);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> heard;
  board.load_volume(BoxVolume(32, 9, 14).view(),
                    [&](std::uint32_t done, std::uint32_t all) { heard.emplace_back(done, all); });
  // Box and gradients fill block (1, 1, 1); its lower neighbours share its first faces: 2^3 blocks of 4^3 hold
  // something.
  ASSERT_EQ(heard.size(), 9u);
  EXPECT_EQ(heard.front(), std::pair(0u, 64u));
  EXPECT_EQ(heard[7], std::pair(1u + 4 + 16, 64u));
  EXPECT_EQ(heard.back(), std::pair(64u, 64u));
}

TEST(Load, AProgressCallbackMustNotCallItsBoardButMayAskTheTime) {
  Board board = Board::open(kSmallBlocks);
  const BoxVolume volume(32, 8, 15);
  EXPECT_THAT([&] { board.load_volume(volume.view(), [&](std::uint32_t, std::uint32_t) { board.counters(); }); },
              ThrowsMessage<Error>(HasSubstr("callback")));
  EXPECT_NO_THROW(board.load_volume(volume.view(), [&](std::uint32_t, std::uint32_t) { board.now(); }));
}

TEST(Load, ZeroBlocksCostNoBusTime) {
  const auto load_time = [](int size) {
    Board board = Board::open(kSmallBlocks);
    const Picoseconds before = board.now();
    board.load_volume(BoxVolume(size, 8, 15).view());
    return board.now() - before;
  };
  // Seven eighths of the larger volume are zero; what remains to differ are the empty flags, 56 bytes.
  EXPECT_LT(load_time(64), load_time(32) + 2'000'000);
}

TEST(Load, TheTransferTimeOfACubeIsItsPackedVoxelsOverTheBus) {
  Board board = Board::open("emu:");
  BoxVolume volume(64, 0, 63);
  board.load_volume(volume.view());  // also sends the gradient LUT
  const Picoseconds before = board.now();
  board.load_volume(volume.view());
  const double seconds = static_cast<double>(board.now() - before) * 1e-12;
  const double dwords = 64.0 * 64 * 64 * 36 / 32;
  const double closed_form = dwords * (256 + 3) / 256 * 30e-9;  // bursts of 256 dwords in n + 3 clocks of 33 1/3 MHz
  EXPECT_NEAR(seconds, closed_form, 0.01 * closed_form);        // registers and flags are extra here
}

TEST(Flags, AreFoundFromVolumeAndTransferFunctionAndAgainAfterEachEdit) {
  Board board = Board::open(kSmallBlocks);
  board.load_volume(BoxVolume(32, 8, 15).view());
  EXPECT_EQ(sum(board.empty_flags()), 64);  // nothing is visible without a transfer function
  board.set_transfer_function(step_function(0.5));
  EXPECT_EQ(sum(board.empty_flags()), 64 - 8);
  board.set_transfer_function(step_function(0));
  EXPECT_EQ(sum(board.empty_flags()), 64);
}

TEST(Flags, SetByHandHoldUntilTheNextEdit) {
  Board board = Board::open(kSmallBlocks);
  board.load_volume(BoxVolume(32, 8, 15).view());
  board.set_transfer_function(step_function(0.5));
  const Image seen = board.render(front_view(32));
  EXPECT_NE(seen.at(19, 19).alpha, 0);
  board.set_empty_flags(std::vector<std::uint8_t>(64, 7));
  EXPECT_EQ(board.empty_flags(), std::vector<std::uint8_t>(64, 1));
  EXPECT_EQ(board.render(front_view(32)).at(19, 19).alpha, 0);
  board.set_shading({});
  EXPECT_EQ(sum(board.empty_flags()), 64);
  board.set_transfer_function(step_function(0.5));
  EXPECT_EQ(board.render(front_view(32)), seen);
  EXPECT_THROW(board.set_empty_flags(std::vector<std::uint8_t>(63)), BadArgument);
}

TEST(Tables, ATransferFunctionMayComeBeforeTheVolume) {
  Board early = Board::open(kSmallBlocks);
  early.set_transfer_function(step_function(0.5));
  early.load_volume(BoxVolume(32, 8, 23).view());
  Board late = box_board(0.5);
  EXPECT_EQ(early.render(front_view(32)), late.render(front_view(32)));
}

TEST(Tables, TheTransferFunctionFollowsTheVolumesRange) {
  Board board = Board::open(kSmallBlocks);
  board.set_transfer_function(step_function(0.5));
  BoxVolume volume(32, 8, 23);
  board.load_volume(volume.view());
  const Image expected = board.render(front_view(32));
  VolumeView view = volume.view();
  view.range = ValueRange{-1000, 1000};
  board.load_volume(view);
  EXPECT_EQ(board.value_range(), (ValueRange{-1000, 1000}));
  const Image image = board.render(front_view(32));
  EXPECT_GT(image.at(16, 16).alpha, 0);
  EXPECT_NEAR(image.at(16, 16).alpha, expected.at(16, 16).alpha, 40);
}

TEST(Tables, BadArgumentsAreRefusedByName) {
  Board board = Board::open("emu:");
  EXPECT_THROW(board.set_transfer_function({}, 0), BadArgument);
  EXPECT_THROW(board.set_transfer_function(step_function(0.5), 4), BadArgument);
  EXPECT_THROW(board.set_shading({.phong = {.ambient = -1}, .light = {}}), BadArgument);
  EXPECT_THROW(board.set_gradient_codebook(std::vector<Vec3>{{1, 0, 0}}), BadArgument);
}

TEST(Tables, TheCodebookIsFixedOnceAVolumeHoldsItsCodes) {
  Board board = Board::open(kSmallBlocks);
  const std::vector<Vec3> axes{{}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  EXPECT_NO_THROW(board.set_gradient_codebook(axes));
  board.load_volume(BoxVolume(32, 8, 23).view());
  EXPECT_THROW(board.set_gradient_codebook(axes), Rejected);
}

}  // namespace
}  // namespace gicube
