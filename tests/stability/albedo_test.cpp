// Low albedo where scattering matters, and high albedo with few photons.
#include "stability.h"
#include "test.h"

namespace gicube::stability {
namespace {

using testing::Contains;
using testing::Not;

// A lamp in the middle of fog of `thickness` free paths a voxel.
class StabilityOfAlbedo : public testing::Test {
 protected:
  void fog(int size, double thickness, double scattering) {
    load_fog(board_, {size, size, size}, -std::expm1(-thickness));
    Material mist;
    mist.scattering = scattering;
    mist.bsdf = Bsdf::kIsotropic;
    board_.set_material(mist);
    middle_ = (size - 1) / 2.0;
  }
  LightingReport light(const Illumination& settings) {
    const std::vector<Light> lamp{PointLight{{middle_, middle_, middle_}, 1000}};
    return board_.illuminate(lamp, settings);
  }

  // Light that the words around the lamp could not hold was absorbed too.
  static double absorbed(const LightingReport& report) { return (report.deposited + report.clipped) / report.emitted; }

  Board board_ = Board::open(small_board("&set=asic.datapath=wide"));
  double middle_ = 0;
};

using StabilityOfLowAlbedo = StabilityOfAlbedo;
using StabilityOfHighAlbedo = StabilityOfAlbedo;

TEST_F(StabilityOfLowAlbedo, ThePrintedRulesLoseAllThatIsScatteredAndSaySo) {
  for (const double scattering : {0.0, 0.5, 0.9}) {
    fog(33, 1, scattering);
    Illumination settings{.rules = EnergyRules::kAsPrinted, .step = 0.25, .lifetime = 1023};
    const LightingReport printed = light(settings);
    EXPECT_NEAR(absorbed(printed), 1 - scattering, 0.003);
    EXPECT_NEAR(printed.scattered_away / printed.emitted, scattering, 0.003);
    if (scattering > 0) {
      EXPECT_THAT(printed.warnings, Contains(HasSubstr("printed rules of low albedo lost")));
    } else {
      EXPECT_THAT(printed.warnings, Not(Contains(HasSubstr("printed rules"))));
    }
    settings.rules = EnergyRules::kConserving;
    const LightingReport conserving = light(settings);
    EXPECT_NEAR(absorbed(conserving), 1, 0.003);
    EXPECT_THAT(conserving.warnings, Not(Contains(HasSubstr("printed rules"))));
    if (scattering == 0.9) record("share_kept_by_the_printed_rules_at_ks_0.9", absorbed(printed));
  }
}

// Variance over independent seeds, a mean over cubes of 4^3 voxels, in units of what standard_error() says.
TEST_F(StabilityOfHighAlbedo, VarianceFallsWithThePhotonsAndTheErrorBarsSayHowMuch) {
  constexpr int kSize = 16, kCube = 4, kSeeds = 24;
  constexpr std::size_t kCubes = 64;
  fog(kSize, 0.2, 0.8);
  std::vector<double> variances;
  for (const int rays : {1, 4, 16}) {
    std::vector<double> sum(kCubes), squares(kCubes), error(kCubes);
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
      const LightingReport report =
          light({.albedo = Albedo::kHigh, .rays_per_face_voxel = rays, .lifetime = 1023, .seed = seed});
      const std::vector<float> irradiance = board_.read_irradiance();
      std::vector<double> cubes(kCubes);
      for (std::size_t i = 0; i < irradiance.size(); ++i) {
        const std::size_t x = i % kSize / kCube, y = i / kSize % kSize / kCube, z = i / kSize / kSize / kCube;
        cubes[x + 4 * (y + 4 * z)] += double{irradiance[i]};
      }
      for (std::size_t c = 0; c < kCubes; ++c) {
        sum[c] += cubes[c] / kSeeds;
        squares[c] += cubes[c] * cubes[c] / kSeeds;
        error[c] += standard_error(report, cubes[c]) / kSeeds;
      }
    }
    double variance = 0, predicted = 0;
    for (std::size_t c = 0; c < kCubes; ++c) {
      variance += (squares[c] - sum[c] * sum[c]) * kSeeds / (kSeeds - 1);
      predicted += error[c] * error[c];
    }
    variances.push_back(variance);
    record("spread_over_error_bar_k_" + std::to_string(rays), std::sqrt(variance / predicted));
    EXPECT_NEAR(std::sqrt(variance / predicted), 1, 0.2) << rays;
  }
  record("variance_of_k_1_over_k_16", variances[0] / variances[2]);
  EXPECT_NEAR(variances[0] / variances[1], 4, 1);
  EXPECT_NEAR(variances[1] / variances[2], 4, 1);
}

}  // namespace
}  // namespace gicube::stability
