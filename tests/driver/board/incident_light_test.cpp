// Pictures of a field that holds what falls on a sample, as a solution of radiosity writes it.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

constexpr int kSize = 24;
constexpr const char* kUri = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32";

View view_of_field(double exposure) {
  View view = front_view(kSize);
  view.width = view.height = 24;
  view.irradiance = view.incident = true;
  view.exposure = exposure;
  view.opacity_threshold = 1;
  return view;
}

// A box of some colour, as opaque as asked, in a field that grows along x.
void fill(Board& board, double opacity, double unit) {
  board.load_volume(BoxVolume(kSize, 4, 19).view());
  board.set_transfer_function({.colours = {{0, {0.8, 0.5, 0.25}}}, .opacities = {{99, 0}, {100, opacity}}});
  Material chalk;
  chalk.scattering = 0.6;
  chalk.bsdf = Bsdf::kDiffuse;
  board.set_material(chalk);
  board.clear_irradiance(unit);
  std::vector<float> field;
  for (int i = 0; i < kSize * kSize * kSize; ++i) field.push_back(static_cast<float>(i % kSize) / kSize);
  board.write_irradiance({{0, 0, 0}, {kSize, kSize, kSize}}, field);
}

TEST(IncidentLight, IsShownAsColourTimesIrradianceTimesExposureWhateverTheOpacity) {
  for (const char* set : {"", "&set=asic.datapath=wide"}) {
    Board board = Board::open(std::string(kUri) + set);
    for (const double opacity : {0.05, 0.4, 1.0}) {
      const double unit = board.info().wide ? 1.0 / 2048 / 65536 : 1.0 / 2048;
      fill(board, opacity, unit);
      const Image image = board.render(view_of_field(0.5));
      for (const int x : {8, 12, 15}) {
        const Pixel& pixel = image.pixels[12 * 24 + static_cast<std::size_t>(x)];
        const double covered = pixel.alpha / 4095.0;
        ASSERT_GT(covered, 0.4) << opacity;
        const double light = pixel.red / 255.0 / covered / 0.8 / 0.5;
        EXPECT_NEAR(pixel.green, 0.5 / 0.8 * pixel.red, 1.5);
        EXPECT_NEAR(pixel.blue, 0.25 / 0.8 * pixel.red, 1.5);
        EXPECT_GT(light, 0.2) << opacity << ' ' << x;
        EXPECT_LT(light, 0.8) << opacity << ' ' << x;
      }
    }
  }
}

TEST(IncidentLight, InAFieldThatIsTheSameEverywhereIsKnownExactly) {
  Board board = Board::open(kUri);
  for (const double opacity : {0.05, 1.0}) {
    fill(board, opacity, 1.0 / 1024);
    board.write_irradiance({{0, 0, 0}, {kSize, kSize, kSize}}, std::vector<float>(kSize * kSize * kSize, 0.75F));
    const Image image = board.render(view_of_field(0.8));
    const Pixel& pixel = image.pixels[12 * 24 + 12];
    const double covered = pixel.alpha / 4095.0;
    EXPECT_NEAR(pixel.red / covered, 255 * 0.8 * 0.75 * 0.8, 2) << opacity;
    // What was absorbed is divided by what absorbs.
    View absorbed = view_of_field(0.8);
    absorbed.incident = false;
    const Pixel brighter = board.render(absorbed).pixels[12 * 24 + 12];
    EXPECT_GT(brighter.red, 1.2 * pixel.red) << opacity;
    EXPECT_EQ(brighter.alpha, pixel.alpha) << opacity;
  }
}

TEST(IncidentLight, IsTheSameBitsOnEveryLevel) {
  std::vector<Pixel> expected;
  for (const char* level : {"functional", "cycle"}) {
    Board board = Board::open(std::string(kUri) + "&fidelity=" + level);
    fill(board, 0.3, 1.0 / 2048);
    const Image image = board.render(view_of_field(1));
    if (expected.empty()) expected = image.pixels;
    EXPECT_EQ(image.pixels, expected) << level;
  }
  EXPECT_GT(expected[12 * 24 + 12].red, 20);
}

}  // namespace
}  // namespace gicube
