// Gradient codes: flat regions and thin sheets, which have no normal.
#include <cmath>
#include <random>
#include <vector>

#include "stability.h"

namespace gicube::stability {
namespace {

constexpr int kSize = 32;

class StabilityOfGradientCode : public testing::Test {
 protected:
  // Values are densities.
  template <typename Field>
  void load(const Field& field) {
    std::vector<float> values;
    for (int i = 0; i < kSize * kSize * kSize; ++i)
      values.push_back(field(i % kSize, i / kSize % kSize, i / kSize / kSize));
    board_.load_volume({.samples = std::as_bytes(std::span(values)),
                        .type = SampleType::kFloat32,
                        .dims = {kSize, kSize, kSize},
                        .range = ValueRange{0, 4095}});
  }
  Image picture(bool shade, double step = 0.5) {
    View view = front_view(kSize);
    view.shade = shade;
    view.step = step;
    return board_.render(view);
  }
  // How far shading changes the pixel in the middle, in units of its brightness.
  double change(double step = 0.5) {
    const double plain = picture(false, step).at(16, 16).green, shaded = picture(true, step).at(16, 16).green;
    return std::abs(shaded - plain) / std::max(plain, 1.0);
  }
  void SetUp() override {
    Shading sideways;  // so that a surface towards the eye is dark
    sideways.light = {0, 1, 0};
    sideways.phong.specular = 0;
    board_.set_shading(sideways);
  }

  Board board_ = Board::open(small_board());
};

TEST_F(StabilityOfGradientCode, FlatRegionsAreNotShaded) {
  load([](int, int, int) { return 2000.0F; });
  board_.set_transfer_function({.colours = {{0, {0.2, 0.8, 0.4}}}, .opacities = {{0, 0.05}}});
  EXPECT_EQ(picture(true).pixels, picture(false).pixels);
  EXPECT_GT(picture(false).at(16, 16).green, 100);
}

TEST_F(StabilityOfGradientCode, NoiseBelowAnEighthOfADensityHasNoNormalAndMoreHas) {
  board_.set_transfer_function({.colours = {{0, {0.2, 0.8, 0.4}}}, .opacities = {{0, 0.05}}});
  const auto change_by_noise = [&](float amplitude) {
    std::mt19937 engine(1);
    std::uniform_real_distribution<float> noise(-amplitude, amplitude);
    load([&](int, int, int) { return 2000.25F + noise(engine); });
    return change();
  };
  EXPECT_EQ(change_by_noise(0.1F), 0);
  record("change_by_noise_of_4_densities", change_by_noise(4));
  EXPECT_GT(change_by_noise(4), 0.1);
}

// A sheet one voxel thick at z = 16: both its sides' gradients meet in its middle and leave nothing. Steps that put one
// sample `beside` the middle; in the middle itself, and as near as 1/16 voxel, it keeps its colour.
TEST_F(StabilityOfGradientCode, TheMiddleOfAThinSheetIsNotShaded) {
  load([](int, int, int z) { return z == 16 ? 4000.0F : 0.0F; });
  board_.set_transfer_function({.colours = {{0, {0.2, 0.8, 0.4}}}, .opacities = {{3000, 0}, {3000, 1}}});
  const auto change_beside = [&](double beside) { return change((16 + beside) / 16); };
  EXPECT_GT(picture(false, 1).at(16, 16).green, 100);
  EXPECT_EQ(change_beside(0), 0);
  EXPECT_EQ(change_beside(0.055), 0);
  EXPECT_EQ(change_beside(-0.055), 0);
  EXPECT_GT(change_beside(0.075), 0.1);
  EXPECT_GT(change_beside(-0.075), 0.1);
  record("change_beside_the_middle_of_a_thin_sheet", change_beside(0.075));
}

}  // namespace
}  // namespace gicube::stability
