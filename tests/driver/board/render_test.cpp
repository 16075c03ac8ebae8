#include <malloc.h>

#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

class Render : public ::testing::Test {
 protected:
  void SetUp() override { load_box(board_); }
  Board board_ = Board::open(kSmallBlocks);
};

TEST_F(Render, ReadingBeforeTheFirstPictureIsRejected) { EXPECT_THROW(board_.read_framebuffer(), Rejected); }

TEST_F(Render, ABoxOfConstantOpacityHasBeersAlpha) {
  View view = front_view(32);
  view.opacity_threshold = 1;
  const Image image = board_.render(view);
  ASSERT_EQ(image.width, 32);
  ASSERT_EQ(image.pixels.size(), 32u * 32);
  EXPECT_EQ(image.at(2, 2).alpha, 0);
  // Density 200 lies between the voxels 8 and 23; towards 0 on either side it passes 100 half a voxel further out.
  const double expected = 1 - std::pow(0.9, 16);
  EXPECT_NEAR(image.at(16, 16).alpha / 4095.0, expected, 0.01);
}

TEST_F(Render, AnOddImageLargerThanOneLinkPayloadArrivesWhole) {
  View view = front_view(32);
  view.width = 1201;
  view.height = 999;  // 5.4 MB at 36 bits, the link takes 4 MB at a time
  const Image image = board_.render(view);
  ASSERT_EQ(image.pixels.size(), 1201u * 999);
  EXPECT_EQ(image.at(0, 0).alpha, 0);
  EXPECT_GT(image.at(600, 499).alpha, 0);
  // The box is in the middle, so the picture is its own mirror image, seam of the transfers or not.
  const auto rows = [&](int y) {
    return std::count_if(image.pixels.begin() + y * 1201, image.pixels.begin() + (y + 1) * 1201,
                         [](const Pixel& pixel) { return pixel.alpha > 0; });
  };
  EXPECT_EQ(rows(300), rows(998 - 300));
  EXPECT_EQ(rows(780), rows(998 - 780));
}

// Memory is never zero here until somebody writes zeros.
TEST_F(Render, EveryByteOfAPictureIsDefined) {
  mallopt(M_PERTURB, 0x5A);
  const Image image = board_.render(front_view(20));
  mallopt(M_PERTURB, 0);
  std::vector<unsigned char> bytes(image.pixels.size() * sizeof(Pixel));
  std::memcpy(bytes.data(), image.pixels.data(), bytes.size());
  constexpr std::size_t kBetween = offsetof(Pixel, blue) + 1;
  static_assert(kBetween + 1 == offsetof(Pixel, alpha));
  for (std::size_t i = kBetween; i < bytes.size(); i += sizeof(Pixel)) ASSERT_EQ(bytes[i], 0) << i;
}

TEST_F(Render, TheFramebuffersTransferTakesItsBytesOverTheBus) {
  View view = front_view(32);
  view.width = 512;
  view.height = 512;
  board_.render_to_framebuffer(view);
  const Picoseconds before = board_.now();
  board_.read_framebuffer();
  const double seconds = static_cast<double>(board_.now() - before) * 1e-12;
  const double closed_form = 512.0 * 512 * 36 / 32 * (256 + 3) / 256 * 30e-9;
  EXPECT_NEAR(seconds, closed_form, 0.001 * closed_form);
}

TEST_F(Render, OnlyWhatHasChangedIsSent) {
  View view = front_view(32);
  view.shade = true;
  view.cut_planes = {{{1, 0, 0}, 12}};
  board_.render_to_framebuffer(view);
  const Counters first = board_.counters();
  board_.render_to_framebuffer(view);
  const Counters second = board_.counters();
  EXPECT_EQ((second - first).value("bus.down.bytes"), 112u);  // the rendering command
  board_.set_shading({.phong = {}, .light = {1, 1, -1}});
  board_.render_to_framebuffer(view);
  EXPECT_GE((board_.counters() - second).value("bus.down.bytes"), 112u + 6 * 128 * 128);
}

TEST_F(Render, ProgressEndsWithAllPartsHoweverQuickThePictureIs) {
  std::uint32_t done = 1, all = 2;
  board_.render(front_view(8), [&](std::uint32_t d, std::uint32_t a) { done = d, all = a; });
  EXPECT_EQ(done, all);
  EXPECT_GT(all, 0u);
}

TEST_F(Render, CutPlanesCutAndGoAgain) {
  const Image whole = board_.render(front_view(32));
  View view = front_view(32);
  view.cut_planes = {{{1, 0, 0}, 15.5}};
  const Image cut = board_.render(view);
  EXPECT_NE(cut, whole);
  const auto visible = [](const Image& image) {
    return std::count_if(image.pixels.begin(), image.pixels.end(), [](const Pixel& p) { return p.alpha > 0; });
  };
  EXPECT_NEAR(static_cast<double>(visible(cut)), static_cast<double>(visible(whole)) / 2, 40);
  EXPECT_EQ(board_.render(front_view(32)), whole);
}

TEST_F(Render, ABadViewLeavesTheFramebuffer) {
  const Image before = board_.render(front_view(32));
  View view = front_view(32);
  view.step = 0;
  EXPECT_THROW(board_.render(view), BadArgument);
  view = front_view(32);
  view.width = 5000;
  EXPECT_THROW(board_.render(view), BadArgument);
  EXPECT_EQ(board_.read_framebuffer(), before);
}

TEST_F(Render, WhatTheBoardRefusesIsRejectedInItsWordsAndTheBoardGoesOn) {
  Board board = Board::open(std::string(kSmallBlocks) + "&set=dsp.framebuffer_mb=1");
  board.load_volume(BoxVolume(32, 8, 23).view());
  const Image before = board.render(front_view(32));
  View view = front_view(32);
  view.width = 4000;
  view.height = 4000;
  EXPECT_THROWS(Rejected, "framebuffer_mb", board.render(view));
  EXPECT_EQ(board.read_framebuffer(), before);
}

TEST_F(Render, SeveralThreadsTakeTurns) {
  const Image expected = board_.render(front_view(32));
  std::vector<std::thread> threads;
  std::array<bool, 4> same{};
  for (std::size_t i = 0; i < same.size(); ++i) {
    threads.emplace_back([this, &expected, &same, i] {
      for (int picture = 0; picture < 5; ++picture) same[i] = board_.render(front_view(32)) == expected;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(same, (std::array<bool, 4>{true, true, true, true}));
}

TEST_F(Render, ThePhongModelShowsInThePicture) {
  View view = front_view(32);
  view.shade = true;
  const Image lit = board_.render(view);
  board_.set_shading({.phong = {.ambient = 0, .diffuse = 0, .specular = 0}, .light = {}});
  const Image dark = board_.render(view);
  EXPECT_NE(lit, dark);
  const auto light = [](const Image& image) {
    long total = 0;
    for (const Pixel& pixel : image.pixels) total += pixel.red;
    return total;
  };
  EXPECT_GT(light(lit), light(dark));
}

// Noise that is opaque everywhere has gradients in all directions; the face that a plane cuts through it has one
// colour.
TEST(CutFace, ShowsTheColourOfItsSamplesWithoutShade) {
  for (const char* datapath : {"", "&set=asic.datapath=wide"}) {
    Board board = Board::open(std::string(kSmallBlocks) + datapath);
    std::vector<std::byte> samples(32 * 32 * 32);
    std::uint32_t random = 1;
    for (std::byte& sample : samples) {
      random = 1664525 * random + 1013904223;
      sample = static_cast<std::byte>(100 + (random >> 24) % 100);
    }
    board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {32, 32, 32}});
    board.set_transfer_function({.colours = {{0, {0.6, 0.4, 0.2}}}, .opacities = {{0, 1}}});
    board.set_shading({.phong = {0.25, 0.7, 0.35, 24}, .light = {0.4, 0.5, -1}});
    View view = front_view(32);
    view.shade = true;
    const auto count_plain = [&] {
      const Image image = board.render(view);
      return std::ranges::count(image.pixels, Pixel{153, 102, 51, 4095});
    };
    const std::ptrdiff_t shaded = count_plain();
    const Vec3 along = view.look_at - view.eye;
    view.cut_planes = {{along, dot(along, Vec3{15.5, 15.5, 15.5})}};
    view.jitter = datapath[0] == 0;
    const std::ptrdiff_t cut = count_plain();
    view.shade = false;
    EXPECT_EQ(cut, count_plain());
    EXPECT_GT(cut, 200);
    EXPECT_LT(shaded, cut / 4);
  }
}

}  // namespace
}  // namespace gicube
