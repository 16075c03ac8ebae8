// Radix-k gives every rank's pixels their place in the order, whatever the number of ranks; and what boxes ranks are dealt.
#include "board/hosts/radix_k.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "../thread_exchange.h"
#include "board/hosts/volume_parts.h"

namespace gicube::reference {
namespace {

using testing::ElementsAre;

std::vector<FloatPixel> random_picture(std::mt19937& random, std::size_t pixels) {
  std::uniform_real_distribution<float> share(0, 1);
  std::vector<FloatPixel> out(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (i % 7 < 3) continue;  // not active
    const float alpha = share(random) * 0.9F;
    out[i] = {share(random) * alpha, share(random) * alpha, share(random) * alpha, alpha};
  }
  return out;
}

TEST(RadixK, TakesRoundsOfAtMostEightAndOfPrimes) {
  EXPECT_THAT(radices(1), ElementsAre());
  EXPECT_THAT(radices(2), ElementsAre(2));
  EXPECT_THAT(radices(6), ElementsAre(6));
  EXPECT_THAT(radices(64), ElementsAre(8, 8));
  EXPECT_THAT(radices(12), ElementsAre(6, 2));
  EXPECT_THAT(radices(13), ElementsAre(13));
}

TEST(RadixK, CompositesInTheGivenOrder) {
  std::mt19937 random(1);
  for (const int ranks : {1, 2, 3, 4, 6, 9, 12, 13, 16}) {
    constexpr std::size_t kPixels = 101;
    std::vector<std::vector<FloatPixel>> pictures;
    for (int rank = 0; rank < ranks; ++rank) pictures.push_back(random_picture(random, kPixels));
    std::vector<int> order(static_cast<std::size_t>(ranks));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::shuffle(order, random);
    std::vector<FloatPixel> got;
    std::uint64_t sent = 0;
    const auto errors = ThreadRanks(ranks).run([&](RayExchange& exchange) {
      std::uint64_t bytes = 0;
      auto out = composite(exchange, order, pictures[static_cast<std::size_t>(exchange.rank())], 2, bytes);
      const std::uint64_t all = exchange.sum(bytes);
      EXPECT_EQ(out.empty(), exchange.rank() > 0);
      if (out.empty()) return;
      got = std::move(out);
      sent = all;
    });
    for (const auto& error : errors) ASSERT_EQ(error, nullptr);
    ASSERT_EQ(got.size(), kPixels);
    EXPECT_EQ(sent > 0, ranks > 1);
    for (std::size_t i = 0; i < kPixels; ++i) {
      double clear = 1, red = 0;
      for (const int rank : order) {
        const FloatPixel& pixel = pictures[static_cast<std::size_t>(rank)][i];
        red += clear * pixel.red;
        clear *= 1 - pixel.alpha;
      }
      ASSERT_NEAR(got[i].red, red, 1e-5) << ranks << " ranks, pixel " << i;
      ASSERT_NEAR(got[i].alpha, 1 - clear, 1e-5) << ranks << " ranks, pixel " << i;
    }
  }
}

TEST(RadixK, SendsNothingOfWhatIsNotActive) {
  const auto errors = ThreadRanks(4).run([](RayExchange& exchange) {
    const std::vector<int> order{0, 1, 2, 3};
    std::vector<FloatPixel> picture(1000);
    if (exchange.rank() == 2) picture[10] = {0, 0, 0, 0.5F};
    std::uint64_t bytes = 0;
    const auto out = composite(exchange, order, picture, 1, bytes);
    EXPECT_EQ(bytes, exchange.rank() == 2 ? 24U : 0U);  // a run's head and a pixel
    if (exchange.rank() > 0) return;
    EXPECT_EQ(out[10].alpha, 0.5F);
  });
  for (const auto& error : errors) EXPECT_EQ(error, nullptr);
}

TEST(RadixK, AddsNothingBehindTheThreshold) {
  const auto errors = ThreadRanks(2).run([](RayExchange& exchange) {
    const std::vector<int> order{1, 0};
    const std::vector<FloatPixel> picture{exchange.rank() == 1 ? FloatPixel{0.5F, 0, 0, 0.9F} : FloatPixel{0, 1, 0, 1}};
    std::uint64_t bytes = 0;
    const auto out = composite(exchange, order, picture, 0.9F, bytes);
    if (exchange.rank() == 0) {
      EXPECT_EQ(out[0].green, 0);
      EXPECT_EQ(out[0].alpha, 0.9F);
    }
  });
  for (const auto& error : errors) EXPECT_EQ(error, nullptr);
}

TEST(VolumeParts, AreEachBlockOnceAndCostTheSame) {
  std::mt19937 random(3);
  for (const int ranks : {1, 2, 3, 5, 8, 16}) {
    const Dims blocks{12, 9, 10};
    std::vector<double> costs(12 * 9 * 10);
    for (double& cost : costs) cost = std::uniform_real_distribution(0.5, 1.5)(random);
    const VolumeParts parts(blocks, costs, ranks, 1);
    std::vector<int> owners(costs.size());
    for (int rank = 0; rank < ranks; ++rank) {
      double cost = 0;
      parts.for_each_block(rank, [&](std::size_t block) {
        ++owners[block];
        cost += costs[block];
      });
      EXPECT_NEAR(cost * ranks / std::accumulate(costs.begin(), costs.end(), 0.0), 1, 0.35) << rank << " of " << ranks;
    }
    EXPECT_EQ(std::ranges::count(owners, 1), static_cast<std::ptrdiff_t>(owners.size()));
  }
  const VolumeParts few({1, 1, 2}, std::vector<double>{1, 1}, 5, 0);
  int owned = 0;
  for (int rank = 0; rank < 5; ++rank) few.for_each_block(rank, [&owned](std::size_t) { ++owned; });
  EXPECT_EQ(owned, 2);
}

// Along any ray, each box is left before one comes that is behind it.
TEST(VolumeParts, AreInTheOrderInWhichRaysComeToThem) {
  std::mt19937 random(4);
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  constexpr int n = 8;
  const Dims blocks{6, 5, 7};
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> costs(6 * 5 * 7);
    for (double& cost : costs) cost = within(0, 1) < 0.3 ? 1 : 0;
    const VolumeParts parts(blocks, costs, 7, 2);
    View view;
    view.eye = {within(-80, 120), within(-80, 120), within(-80, 120)};
    view.look_at = {24, 20, 28};
    if (trial % 2 == 0) view.orthographic_height = 50;
    const std::vector<int> order = parts.front_to_back(view, n);
    std::vector<int> owner(costs.size()), place(7);
    for (int rank = 0; rank < 7; ++rank) {
      parts.for_each_block(rank, [&](std::size_t block) { owner[block] = rank; });
      place[static_cast<std::size_t>(order[static_cast<std::size_t>(rank)])] = rank;
    }
    for (int ray = 0; ray < 20; ++ray) {
      const Vec3 through{within(0, 47), within(0, 39), within(0, 55)};
      Vec3 from = view.eye, along = through - view.eye;
      if (trial % 2 == 0) along = view.look_at - view.eye, from = through - along;
      int last = -1;
      for (double t = 0; t < 3; t += 0.002) {
        const Vec3 at = from + t * along;
        if (at.x < 0 || at.y < 0 || at.z < 0 || at.x >= 48 || at.y >= 40 || at.z >= 56) continue;
        const auto block = static_cast<std::size_t>(
            static_cast<int>(at.x) / n + 6 * (static_cast<int>(at.y) / n + 5 * (static_cast<int>(at.z) / n)));
        const int now = place[static_cast<std::size_t>(owner[block])];
        ASSERT_GE(now, last) << trial;
        last = now;
      }
    }
  }
}

}  // namespace
}  // namespace gicube::reference
