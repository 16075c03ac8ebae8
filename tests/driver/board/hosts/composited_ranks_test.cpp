// Pictures that ranks composite differ from one board's by no more than docs/guide/mpi.md says.
#include "gicube/composited_ranks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "../brick_scenes.h"
#include "../thread_exchange.h"

namespace gicube::reference {
namespace {

using testing::HasSubstr;

const std::string kCard = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64&threads=1";
const std::string kSmallCard = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32&threads=1";

std::string text_of(const std::exception_ptr& error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const std::exception& thrown) {
    return thrown.what();
  }
  return "";
}

View make_straight_view(std::mt19937& random, const Dims& dims) {
  View view = make_view(random, dims, 32);
  view.jitter = false;
  view.samples_per_axis = 1;
  view.step = std::max(view.step, 0.5);
  return view;
}

// As docs/guide/mpi.md has it, in 255ths of colour and 4095ths of alpha.
struct Bound {
  double colour, alpha;
};
Bound bound(int ranks, const View& view, const Dims& dims) {
  const double samples = length(Vec3{dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0}) / view.step + 1;
  const double beyond = 1 - view.opacity_threshold;
  return {1 + 0.54 * ranks + 0.0625 * samples + 255 * beyond, 1 + 0.5 * ranks + 0.001 * samples + 4095 * beyond};
}

struct Difference {
  int colour = 0, alpha = 0;
};
Difference between(const Image& a, const Image& b) {
  Difference most;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const Pixel &p = a.pixels[i], &q = b.pixels[i];
    most.colour =
        std::max({most.colour, std::abs(p.red - q.red), std::abs(p.green - q.green), std::abs(p.blue - q.blue)});
    most.alpha = std::max(most.alpha, std::abs(p.alpha - q.alpha));
  }
  return most;
}

// One for each rank. Opened by one thread, since it sets the environment.
std::vector<Board> open_boards(const std::string& card, int ranks) {
  std::vector<Board> boards;
  for (int rank = 0; rank < ranks; ++rank) boards.push_back(open_board(card));
  return boards;
}

// Pictures of random scenes by `ranks`, compared with those of one board; the greatest difference of those without early termination.
Difference composited(const std::string& card, int ranks, int scenes, unsigned seed) {
  std::mt19937 random(seed);
  Difference exact_end;
  for (int scene = 0; scene < scenes; ++scene) {
    const Blobs blobs = make_blobs(random, 20, 48);
    const TransferFunction function = fog_and_balls(scene % 3 == 0 ? 0 : 0.02);
    std::vector<View> views;
    for (int frame = 0; frame < 3; ++frame) views.push_back(make_straight_view(random, blobs.dims));
    Board one = open_board(card);
    one.set_transfer_function(function);
    one.load_volume(blobs.view());
    std::vector<Image> pictures;
    std::vector<std::vector<std::uint8_t>> flags(static_cast<std::size_t>(ranks));
    std::uint64_t samples = 0;
    std::vector<Board> boards = open_boards(card, ranks);
    const auto errors = ThreadRanks(ranks).run([&](RayExchange& exchange) {
      Board& board = boards[static_cast<std::size_t>(exchange.rank())];
      board.set_transfer_function(function);
      board.load_volume(blobs.view());
      CompositedRanks together(board, exchange);
      for (const View& view : views) {
        Image image = together.render(view);
        if (exchange.rank() > 0) {
          EXPECT_TRUE(image.pixels.empty());
          continue;
        }
        pictures.push_back(std::move(image));
        for (const RankReport& report : together.reports()) samples += report.samples;
      }
      flags[static_cast<std::size_t>(exchange.rank())] = board.empty_flags();
    });
    for (const auto& error : errors) EXPECT_EQ(text_of(error), "") << ranks << " ranks, scene " << scene;
    EXPECT_EQ(pictures.size(), views.size());
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const Difference found = between(pictures[i], one.render(views[i]));
      const Bound most = bound(ranks, views[i], blobs.dims);
      EXPECT_LE(found.colour, most.colour) << ranks << " ranks, scene " << scene << ", picture " << i;
      EXPECT_LE(found.alpha, most.alpha) << ranks << " ranks, scene " << scene << ", picture " << i;
      if (views[i].opacity_threshold < 1) continue;
      exact_end.colour = std::max(exact_end.colour, found.colour);
      exact_end.alpha = std::max(exact_end.alpha, found.alpha);
    }
    for (const auto& each : flags) EXPECT_EQ(each, one.empty_flags());
    EXPECT_GT(samples, 0U);
  }
  return exact_end;
}

TEST(CompositedRanks, DifferFromOneBoardByLessThanTheBound) {
  for (const int ranks : {1, 2, 3, 4, 6}) {
    const Difference most = composited(kCard, ranks, 5, static_cast<unsigned>(ranks));
    // What roundings come to in fact: much less than they could.
    EXPECT_LE(most.colour, ranks == 1 ? 0 : 2) << ranks;
    EXPECT_LE(most.alpha, ranks == 1 ? 0 : 2) << ranks;
  }
}

TEST(CompositedRanks, TakeTheSamplesOfOneBoardOnceIfNothingEndsRays) {
  std::mt19937 random(8);
  const Blobs blobs = make_blobs(random, 30, 48);
  const TransferFunction thin{.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 0.001}, {255, 0.002}}};
  const auto set_up = [&](Board& board) {
    board.set_transfer_function(thin);
    board.load_volume(blobs.view());
  };
  View view;
  view.width = view.height = 40;
  view.eye = {100, 80, -70};
  view.look_at = {20, 20, 20};
  view.opacity_threshold = 1;
  Board one = open_board(kCard);
  set_up(one);
  one.render(view);
  const std::uint64_t samples = one.counters().value("pipeline.samples");
  for (const int ranks : {2, 3, 5}) {
    std::uint64_t sum = 0;
    std::vector<Board> boards = open_boards(kCard, ranks);
    const auto errors = ThreadRanks(ranks).run([&](RayExchange& exchange) {
      Board& board = boards[static_cast<std::size_t>(exchange.rank())];
      set_up(board);
      CompositedRanks together(board, exchange);
      together.render(view);
      const std::uint64_t mine = board.counters().value("pipeline.samples");
      const std::uint64_t all = exchange.sum(mine);
      if (exchange.rank() == 0) sum = all;
    });
    for (const auto& error : errors) EXPECT_EQ(text_of(error), "");
    EXPECT_EQ(sum, samples) << ranks;
  }
}

TEST(CompositedRanks, OfAVolumeThatNoCardStoresDifferByLessThanTheBound) { composited(kSmallCard, 3, 2, 30); }

TEST(CompositedRanks, DifferByLessThanTheBoundAtEachLevelOnTheWideDatapathAndInRuns) {
  const std::string card = "&set=asic.block_voxels=16&set=asic.max_volume_voxels=64&threads=1";
  composited("emu:?fidelity=cycle&set=dsp.run_rays=16" + card, 2, 1, 40);
  composited("emu:?fidelity=cycle&set=asic.datapath=wide" + card, 3, 1, 41);
}

// The picture shows the upper half of the box: half of the ranks have little to do at first.
TEST(CompositedRanks, EvenOutTheirSamplesFromPictureToPicture) {
  const BoxVolume box(64, 4, 59);
  double first = 0, last = 0;
  std::vector<Board> boards = open_boards(kCard, 4);
  const auto errors = ThreadRanks(4).run([&](RayExchange& exchange) {
    Board& board = boards[static_cast<std::size_t>(exchange.rank())];
    board.set_transfer_function(step_function(0.01));
    board.load_volume(box.view());
    View view = front_view(64);
    view.look_at.y = view.eye.y = 48;
    view.orthographic_height = 24;
    CompositedRanks together(board, exchange);
    for (int frame = 0; frame < 5; ++frame) {
      together.render(view);
      if (exchange.rank() > 0) continue;
      double most = 0, sum = 0;
      for (const RankReport& report : together.reports()) {
        most = std::max(most, static_cast<double>(report.samples));
        sum += static_cast<double>(report.samples);
      }
      last = 4 * most / sum;
      if (frame == 0) first = last;
    }
  });
  for (const auto& error : errors) EXPECT_EQ(text_of(error), "");
  EXPECT_GT(first, 1.6);
  EXPECT_LT(last, 1.4);
}

TEST(CompositedRanks, MakeRaysOfTheRowsAloneInWhichTheirPartsAreSeen) {
  const BoxVolume box(64, 4, 59);
  std::vector<Board> boards = open_boards(kCard, 4);
  const auto errors = ThreadRanks(4).run([&](RayExchange& exchange) {
    Board& board = boards[static_cast<std::size_t>(exchange.rank())];
    board.set_transfer_function(step_function(0.01));
    board.load_volume(box.view());
    View view = front_view(64);
    view.width = view.height = 128;
    CompositedRanks(board, exchange).render(view);
    EXPECT_LE(board.counters().value("dsp.viewing_rays"), 128U * 70);
  });
  for (const auto& error : errors) EXPECT_EQ(text_of(error), "");
}

TEST(CompositedRanks, RefuseWhatCannotBeComposited) {
  const auto refused = [](const auto& change) {
    View view = front_view(32);
    change(view);
    std::vector<Board> boards = open_boards(kCard, 2);
    const auto errors = ThreadRanks(2).run([&](RayExchange& exchange) {
      Board& board = boards[static_cast<std::size_t>(exchange.rank())];
      board.set_transfer_function(step_function(0.1));
      const BoxVolume box(32, 8, 23);
      board.load_volume(box.view());
      CompositedRanks(board, exchange).render(view);
    });
    EXPECT_EQ(text_of(errors[0]), text_of(errors[1]));
    return text_of(errors[0]);
  };
  Board shares = open_board(kCard);
  ThreadRanks one(1);
  shares.share_blocks(one.exchange(0));
  const auto errors = one.run([&](RayExchange& exchange) { CompositedRanks(shares, exchange).render(front_view(32)); });
  EXPECT_THAT(text_of(errors[0]), HasSubstr("CompositedRanks::render() is not for a board that shares"));
  EXPECT_THAT(refused([](View& view) { view.jitter = true; }), HasSubstr("jitter: expected false"));
  EXPECT_THAT(refused([](View& view) { view.irradiance = true; }), HasSubstr("irradiance: expected false"));
  EXPECT_THAT(refused([](View& view) { view.scatter = true; }), HasSubstr("scatter: expected false"));
  EXPECT_THAT(refused([](View& view) { view.samples_per_axis = 2; }), HasSubstr("samples_per_axis: expected 1"));
}

}  // namespace
}  // namespace gicube::reference
