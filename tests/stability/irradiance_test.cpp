// Irradiance words: saturation at 11 bits, and voxels that up to eight blocks have copies of.
#include "lighting_rig.h"
#include "stability.h"
#include "test.h"

namespace gicube::stability {
namespace {

using testing::Contains;
using testing::Not;

struct Lit {
  LightingReport report;
  std::vector<float> irradiance;
};

// A lamp in the middle of fog of that opacity a voxel.
Lit lit(const char* datapath, double fog) {
  Board board = Board::open(small_board(std::string("&set=asic.datapath=") + datapath));
  load_fog(board, {32, 32, 32}, fog);
  const std::vector<Light> lamp{PointLight{{15.2, 16.1, 15.9}, 1000}};
  Lit lit{board.illuminate(lamp, {.rays_per_face_voxel = 8}), {}};
  lit.irradiance = board.read_irradiance();
  return lit;
}

// Clipped energy is in the ledger, the words' sum and a warning, and the fullest word is `most` units.
void expect_reported(const Lit& lit, double most) {
  const LightingReport& report = lit.report;
  EXPECT_FLOAT_EQ(*std::max_element(lit.irradiance.begin(), lit.irradiance.end()),
                  static_cast<float>(most * report.unit));
  const double kept = std::accumulate(lit.irradiance.begin(), lit.irradiance.end(), 0.0);
  EXPECT_GT(report.clipped, 0.01 * report.emitted);
  EXPECT_NEAR(kept, report.deposited, 1e-5 * report.emitted);
  EXPECT_NEAR(report.deposited + report.escaped + report.scattered_away + report.clipped, report.emitted,
              1e-9 * report.emitted);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("clipped")));
}

TEST(StabilityOfIrradiance, WhatSaturatedWordsLoseIsCountedReportedAndInTheLedger) {
  const Lit paper = lit("paper", 0.02);
  expect_reported(paper, 2047);
  record("share_of_energy_that_11_bits_clip", paper.report.clipped / paper.report.emitted);
  // With 32 bits nothing is: the difference is what was counted.
  const Lit wide = lit("wide", 0.02);
  EXPECT_EQ(wide.report.clipped, 0);
  EXPECT_THAT(wide.report.warnings, Not(Contains(HasSubstr("clipped"))));
  EXPECT_NEAR(wide.report.deposited / wide.report.emitted,
              (paper.report.deposited + paper.report.clipped) / paper.report.emitted, 0.003);
}

// 32 bits have an end too: the largest ray fits 256 times into a voxel.
TEST(StabilityOfIrradiance, TheWideWordsSaturateInDenseFogAroundALampAndSaySo) {
  const Lit wide = lit("wide", 0.4);
  expect_reported(wide, 4294967295.0);
  record("share_of_energy_that_32_bits_clip_in_dense_fog", wide.report.clipped / wide.report.emitted);
}

// Red, green and blue have the same unit, so a colour with a hundredth of the light has a hundredth of the units.
TEST(StabilityOfIrradiance, AColourFarDarkerThanTheBrightestIsGrainyOnThePapersDatapathAndNotOnTheWideOne) {
  for (const std::string datapath : {"paper", "wide"}) {
    Board board = Board::open(small_board("&set=asic.irradiance_words=3&set=asic.datapath=" + datapath));
    load_fog(board, {32, 32, 32}, 0.02);
    const std::vector<Light> lamp{PointLight{{15.2, 16.1, -20}, 1000}};
    board.illuminate(lamp, {.rays_per_face_voxel = 8, .light_colours = {{1, 0.1, 0.01}}});
    const std::vector<float> words = board.read_irradiance();
    double all = 0, green = 0, blue = 0;  // squares
    for (std::size_t i = 0; i < words.size(); i += 3) {
      all += words[i] * words[i];
      green += std::pow(10 * words[i + 1] - words[i], 2);
      blue += std::pow(100 * words[i + 2] - words[i], 2);
    }
    record("grain_of_a_tenth_" + datapath, std::sqrt(green / all));
    record("grain_of_a_hundredth_" + datapath, std::sqrt(blue / all));
    EXPECT_LT(green, blue);
    if (datapath == "paper") {
      EXPECT_GT(std::sqrt(blue / all), 0.3);
    } else {
      EXPECT_LT(std::sqrt(blue / all), 0.01);
    }
  }
}

// The light stands in the corner that eight blocks share.
TEST(StabilityOfIrradiance, CopiesInAllBlocksThatShareAVoxelAreEqual) {
  constexpr int kSize = 24, kBlock = 8;
  emu::LitScene lit({kSize, kSize, kSize}, kBlock, false);
  lit.medium(0.4, 0.5, wire::Bsdf::kIsotropic);
  lit.light(emu::light_of(wire::LightKind::kPoint, 200'000, {8, 8, 8}, 4));
  int copied = 0, eightfold = 0;
  for (int i = 0; i < kSize * kSize * kSize; ++i) {
    const std::array<int, 3> at{i % kSize, i / kSize % kSize, i / kSize / kSize};
    int copies = 0;
    for (int b = 0; b < 27; ++b) {
      const std::array<int, 3> block{b % 3, b / 3 % 3, b / 9};
      std::array<int, 3> place{};
      bool holds = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        place[axis] = at[axis] - kBlock * block[axis];
        holds = holds && place[axis] >= 0 && place[axis] <= kBlock;
      }
      if (!holds) continue;
      const std::uint32_t* words = lit.irradiance.view(static_cast<std::size_t>(b));
      const int word = place[0] + (kBlock + 1) * (place[1] + (kBlock + 1) * place[2]);
      ASSERT_EQ(words == nullptr ? 0 : words[word], lit.irradiance_at(at[0], at[1], at[2])) << i << " in block " << b;
      ++copies;
    }
    copied += copies > 1 && lit.irradiance_at(at[0], at[1], at[2]) > 0;
    eightfold += copies == 8 && lit.irradiance_at(at[0], at[1], at[2]) > 0;
  }
  EXPECT_GT(copied, 1000);
  EXPECT_GE(eightfold, 4);
}

}  // namespace
}  // namespace gicube::stability
