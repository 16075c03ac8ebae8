// Pre-classified volumes: what a transfer function does between two voxels.
#include <algorithm>
#include <cmath>
#include <vector>

#include "stability.h"

namespace gicube::stability {
namespace {

constexpr int kSize = 32;
constexpr double kStep = 4064.0 / (kSize - 1);  // of density, from plane to plane
constexpr double kMiddle = 15.5 * kStep;        // half way between two planes

// A peak of opacity `top` at kMiddle, `half` density units wide to each side.
double peak(double density, double top, double half) {
  return top * std::max(0.0, 1 - std::abs(density - kMiddle) / half);
}

class StabilityOfPreClassifiedVolumes : public testing::Test {
 protected:
  // The middle pixel's opacity, 0..1, of densities that rise along the rays; classified by the card, or before.
  static double opacity(double half, bool before) {
    constexpr double kTop = 0.2;
    std::vector<float> values;
    for (int i = 0; i < kSize * kSize * kSize; ++i) {
      const double density = i / kSize / kSize * kStep;
      values.push_back(static_cast<float>(before ? 4095 * peak(density, kTop, half) : density));
    }
    Board board = Board::open(small_board(before ? "&set=asic.voxel_format=rgba" : ""));
    board.load_volume({.samples = std::as_bytes(std::span(values)),
                       .type = SampleType::kFloat32,
                       .dims = {kSize, kSize, kSize},
                       .range = ValueRange{0, 4095}});
    TransferFunction look{{{0, {1, 1, 1}}}, {}};
    if (before) {
      look.opacities = {{0, 0}, {4095, 1}};
    } else {
      look.opacities = {{0, 0}, {kMiddle - half, 0}, {kMiddle, kTop}, {kMiddle + half, 0}};
    }
    board.set_transfer_function(look);
    View view = front_view(kSize);
    view.shade = false;
    view.step = 1.0 / 16;
    return board.render(view).at(16, 16).alpha / 4095.0;
  }
};

TEST_F(StabilityOfPreClassifiedVolumes, APeakBetweenTwoVoxelsIsLostAndAWideOneIsNot) {
  for (const double voxels : {0.4, 0.6, 1.0, 2.0, 4.0, 8.0}) {
    const double by_card = opacity(voxels * kStep, false), before = opacity(voxels * kStep, true);
    const std::string name = std::to_string(voxels).substr(0, 3);
    record("peak " + name + " voxels by card", by_card);
    record("peak " + name + " voxels before", before);
    EXPECT_GT(by_card, 0.05) << name;
    if (voxels < 0.5) {
      EXPECT_EQ(before, 0) << "no voxel is in the peak";
    }
    // Between two voxels a straight line replaces a peak of area half * top (per voxel): its optical depth is off by
    // at most that of the triangle cut off at its top, (1/2)^2 / half.
    const auto depth = [](double opacity) { return -std::log(1 - opacity); };
    const double lost = depth(by_card) - depth(before), bound = 0.25 / voxels * 0.2 / (1 - 0.2 / 2) * 1.1;
    if (voxels >= 1) {
      EXPECT_GE(lost, -0.002) << name;
      EXPECT_LE(lost, bound + 0.002) << name;
    }
  }
}

}  // namespace
}  // namespace gicube::stability
