// Light in three irradiance words a voxel: red, green and blue in one pass.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

constexpr Colour kLamp{1, 0.5, 0.25}, kChalk{0.2, 1, 0.6};
const std::vector<Light> kLights{PointLight{{16, 16, -20}, 1000}};

std::string three_words(const std::string& more = "") {
  return std::string(kSmallBlocks) + "&set=asic.irradiance_words=3" + more;
}

Material chalk(const Colour& colour = {1, 1, 1}, double scattering = 0.6) {
  return {.scattering = scattering, .bsdf = Bsdf::kDiffuse, .scattering_colour = colour};
}

Board lit_board(const std::string& uri, const Material& material = chalk()) {
  Board board = Board::open(uri);
  load_box(board, 0.3);
  board.set_material(material);
  return board;
}

View lit_view() {
  View view = front_view(32);
  view.irradiance = true;
  view.exposure = 3;
  return view;
}

// Of `report`, in whole units of the energy words.
std::int64_t units(double energy, const LightingReport& report) { return std::llround(energy / report.unit); }

TEST(ColouredLight, TheCardSaysHowManyIrradianceWordsItsVoxelsHave) {
  EXPECT_EQ(Board::open("emu:").info().irradiance_words, 1);
  EXPECT_EQ(Board::open(three_words()).info().irradiance_words, 3);
}

TEST(ColouredLight, WhiteLightOnGreyMaterialsLeavesInEachWordTheBitsOfACardWithOne) {
  for (const char* more : {"", "&set=asic.datapath=wide"}) {
    for (const Albedo albedo : {Albedo::kLow, Albedo::kHigh}) {
      const Illumination settings{.albedo = albedo, .rays_per_face_voxel = 2};
      Board one = lit_board(std::string(kSmallBlocks) + more), three = lit_board(three_words(more));
      const LightingReport expected = one.illuminate(kLights, settings), report = three.illuminate(kLights, settings);
      EXPECT_EQ(report.rays, expected.rays);
      ASSERT_EQ(report.colours.size(), 3u);
      for (const LightEnergy& colour : report.colours) EXPECT_EQ(colour.deposited, expected.deposited);
      const std::vector<float> words = one.read_irradiance(), all = three.read_irradiance();
      ASSERT_EQ(all.size(), 3 * words.size());
      for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], words[i / 3]) << i;
      EXPECT_EQ(three.render(lit_view()), one.render(lit_view()));
    }
  }
}

// A pass each for red, green and blue is what one pass of three words is held against.
TEST(ColouredLight, OnePassLeavesWhatAPassForEachColourDoes) {
  for (const EnergyRules rules : {EnergyRules::kConserving, EnergyRules::kAsPrinted}) {
    for (const Albedo albedo : {Albedo::kLow, Albedo::kHigh}) {
      Illumination settings{.albedo = albedo, .rules = rules, .rays_per_face_voxel = 32};
      Board one = lit_board(std::string(kSmallBlocks) + "&set=asic.datapath=wide");
      Board three = lit_board(three_words("&set=asic.datapath=wide"), chalk(kChalk));
      settings.light_colours = {kLamp};
      const LightingReport report = three.illuminate(kLights, settings);
      settings.light_colours.clear();
      settings.seed = 5;
      for (std::size_t c = 0; c < 3; ++c) {
        one.set_material(chalk({1, 1, 1}, 0.6 * kChalk[c]));
        const Light light = PointLight{{16, 16, -20}, 1000 * kLamp[c]};
        const LightingReport expected = one.illuminate(std::array{light}, settings);
        EXPECT_NEAR(report.colours[c].emitted, expected.emitted, 1e-3 * expected.emitted) << c;
        const auto expect_near = [&](double got, double right) {  // both passes have the error of photons at most
          EXPECT_NEAR(got, right, 4 * std::sqrt(2) * standard_error(expected, right) + 1e-3 * expected.emitted) << c;
        };
        expect_near(report.colours[c].deposited, expected.deposited);
        expect_near(report.colours[c].escaped, expected.escaped);
        expect_near(report.colours[c].scattered_away, expected.scattered_away);
      }
    }
  }
}

TEST(ColouredLight, NoEnergyOfAnyColourIsLost) {
  for (const EnergyRules rules : {EnergyRules::kConserving, EnergyRules::kAsPrinted}) {
    for (const Albedo albedo : {Albedo::kLow, Albedo::kHigh}) {
      Board board = lit_board(three_words(), chalk(kChalk, 0.9));
      const Illumination settings{
          .albedo = albedo, .rules = rules, .rays_per_face_voxel = 4, .lifetime = 3, .light_colours = {kLamp}};
      const LightingReport report = board.illuminate(kLights, settings);
      LightEnergy sum;
      for (const LightEnergy& colour : report.colours) {
        EXPECT_GT(units(colour.emitted, report), 0);
        EXPECT_EQ(units(colour.emitted, report), units(colour.deposited, report) + units(colour.escaped, report) +
                                                     units(colour.scattered_away, report) +
                                                     units(colour.clipped, report));
        sum.emitted += colour.emitted;
        sum.deposited += colour.deposited;
      }
      EXPECT_EQ(units(sum.emitted, report), units(report.emitted, report));
      EXPECT_EQ(units(sum.deposited, report), units(report.deposited, report));
    }
  }
}

TEST(ColouredLight, IsTheSameAtAllLevels) {
  const Illumination settings{.rays_per_face_voxel = 2, .light_colours = {kLamp}};
  std::vector<float> words;
  Image picture;
  for (const char* level : {"functional", "cycle"}) {
    Board board = lit_board(three_words(std::string("&fidelity=") + level), chalk(kChalk));
    board.illuminate(kLights, settings);
    if (words.empty()) {
      words = board.read_irradiance();
      picture = board.render(lit_view());
    } else {
      EXPECT_EQ(board.read_irradiance(), words) << level;
      EXPECT_EQ(board.render(lit_view()), picture) << level;
    }
  }
}

TEST(ColouredLight, ValuesThatAreWrittenAreReadAgainAndSeen) {
  Board board = lit_board(three_words());
  board.clear_irradiance(0.01);
  const VoxelBox box{{4, 5, 6}, {20, 11, 9}};
  std::vector<float> values;
  for (int i = 0; i < 20 * 11 * 9; ++i) values.insert(values.end(), {static_cast<float>(i % 100) / 100, 1, 0});
  board.write_irradiance(box, values);
  const std::vector<float> read = board.read_irradiance(box);
  ASSERT_EQ(read.size(), values.size());
  for (std::size_t i = 0; i < read.size(); ++i) ASSERT_NEAR(read[i], values[i], 0.0051) << i;
  values.pop_back();
  EXPECT_THROWS(BadArgument, "values: expected 5940, 3 per voxel of the box, got 5939",
                board.write_irradiance(box, values));

  const VoxelBox all{{0, 0, 0}, {32, 32, 32}};
  values.clear();
  for (int i = 0; i < 32 * 32 * 32; ++i) values.insert(values.end(), {0.08F, 0.04F, 0});
  board.write_irradiance(all, values);
  const Pixel pixel = board.render(lit_view()).pixels[16 * 32 + 16];
  EXPECT_GT(pixel.red, 40);
  EXPECT_NEAR(pixel.green, pixel.red / 2, 2);
  EXPECT_EQ(pixel.blue, 0);
}

// A material absorbs more of some colours than of others: a sample shows what fell on it.
TEST(ColouredLight, IsSeenAsInAPictureForEachColour) {
  Board one = lit_board(kSmallBlocks), three = lit_board(three_words(), chalk(kChalk));
  std::vector<float> words, all;
  for (int i = 0; i < 32 * 32 * 32; ++i) {
    words.push_back(static_cast<float>(i % 17) / 200);
    all.insert(all.end(), 3, words.back());
  }
  const VoxelBox whole{{0, 0, 0}, {32, 32, 32}};
  three.clear_irradiance(0.001);
  three.write_irradiance(whole, all);
  const Image picture = three.render(lit_view());
  one.clear_irradiance(0.001);
  one.write_irradiance(whole, words);
  constexpr std::uint8_t Pixel::*kChannels[] = {&Pixel::red, &Pixel::green, &Pixel::blue};
  for (std::size_t c = 0; c < 3; ++c) {
    one.set_material(chalk({1, 1, 1}, 0.6 * kChalk[c]));
    const Image expected = one.render(lit_view());
    for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
      ASSERT_NEAR(picture.pixels[i].*kChannels[c], expected.pixels[i].*kChannels[c], 1) << c << ", pixel " << i;
    }
  }
}

TEST(ColouredLight, HostRaysDepositWhiteEnergy) {
  Board board = lit_board(three_words());
  board.clear_irradiance(0.01);
  const HostRay ray{.position = {16, 16, 0}, .direction = {0, 0, 1}, .energy = 1};
  const Ticket ticket = board.submit(std::array{ray}, {.type = RayType::kDeposit});
  const BatchReport report = board.receive(ticket, std::span<TracedRay>());
  ASSERT_TRUE(report.lighting);
  ASSERT_EQ(report.lighting->colours.size(), 3u);
  for (const LightEnergy& colour : report.lighting->colours) EXPECT_NEAR(colour.emitted, 1, 0.01);
  EXPECT_NEAR(report.lighting->emitted, 3, 0.03);
}

TEST(ColouredLight, IsRefusedByACardOfOneWordAndInAWrongNumber) {
  Board one = lit_board(kSmallBlocks), three = lit_board(three_words());
  const auto fault_of = [](Board& board, std::vector<Colour> colours) -> std::string {
    return message_of<BadArgument>(
        [&] { board.illuminate(kLights, Illumination{.light_colours = std::move(colours)}); });
  };
  EXPECT_THAT(fault_of(one, {kLamp}), HasSubstr("light_colours: expected none on a board with one irradiance word"));
  EXPECT_THAT(fault_of(three, {kLamp, kLamp}),
              HasSubstr("light_colours: expected one for each of the 1 lights, or none"));
  EXPECT_THAT(fault_of(three, {{0, 0, 0}}), HasSubstr("light_colours[0]: expected a colour with a factor above 0"));
  EXPECT_THAT(fault_of(three, {{1, -1, 0}}), HasSubstr("light_colours[0]: expected 0.."));
  EXPECT_EQ(fault_of(three, {{4, 1, 0}}), "none");
  EXPECT_THROWS(BadArgument, "material.scattering_colour: expected white on a board with one",
                one.set_material(chalk(kChalk)));
  EXPECT_THROWS(BadArgument, "material.scattering_colour: expected 0..1", three.set_material(chalk({1, 1, 1.1})));
}

TEST(ColouredLight, WhatTheRaysOfThreeEnergiesCanNotDoIsUnsupportedAndTheBoardLivesOn) {
  Board board = lit_board(three_words());
  board.clear_irradiance(1);
  const HostRay ray{.position = {16, 16, 0}, .direction = {0, 0, 1}, .length = 4, .energy = 1};
  EXPECT_THROWS(Unsupported, "backprojection into irradiance words",
                board.submit(std::array{ray}, {.type = RayType::kBackproject, .words = SumWords::kIrradiance}));
  board.set_material({.scattering = 1, .bsdf = Bsdf::kTrap, .routine = kHostRoutine});
  board.set_scattering_routine([](const ScatterEvent&) { return ScatterAnswer{}; });
  EXPECT_THROWS(Unsupported, "scattered by the application, whose rays have one energy", board.illuminate(kLights, {}));
  EXPECT_EQ(board.read_irradiance().size(), 3u * 32 * 32 * 32);  // it is not scattered
  board.set_material(chalk());
  EXPECT_GT(board.illuminate(kLights, {}).deposited, 0);

  Board small = Board::open("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32&set=asic.irradiance_words=3");
  small.load_volume(BoxVolume(48, 8, 40).view());
  EXPECT_THAT([&] { small.illuminate(kLights, {}); }, testing::Throws<Unsupported>());
}

}  // namespace
}  // namespace gicube
