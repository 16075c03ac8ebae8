#include "reference/photons.h"
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

class Lighting : public ::testing::Test {
 protected:
  void SetUp() override { load(board_); }
  static void load(Board& board) {
    load_box(board, 0.5);
    Material chalk;
    chalk.scattering = 0.6;
    chalk.bsdf = Bsdf::kDiffuse;
    board.set_material(chalk);
  }
  std::string refusal(const Light& light, const Illumination& settings = {}) {
    try {
      board_.illuminate(std::array{light}, settings);
    } catch (const BadArgument& error) {
      return error.field();
    }
    return "none";
  }
  static View lit_view() {
    View view = front_view(32);
    view.irradiance = true;
    return view;
  }

  Board board_ = Board::open(kSmallBlocks);
  const std::vector<Light> lamp_{PointLight{{16, 16, -20}, 1000}};
};

double sum(const LightingReport& report) {
  return report.deposited + report.escaped + report.scattered_away + report.clipped;
}

// A slab that fills the volume, 15 long along `axis` and 127 x 64 across, lit from its low face. What left by each face
// of the volume, as shares of what was emitted.
std::array<double, 6> slab_shares(Board& board, int axis, double depth, double albedo, const Illumination& settings) {
  constexpr int kThick = 16, kWide = 128;
  constexpr double kEdge = 64;
  Dims dims{kWide, kWide, kWide};
  Vec3 spacing{kEdge, kEdge, kEdge}, towards;
  dims[static_cast<std::size_t>(axis)] = kThick;
  constexpr std::array kAxes{&Vec3::x, &Vec3::y, &Vec3::z};
  spacing.*kAxes[static_cast<std::size_t>(axis)] = 1;
  towards.*kAxes[static_cast<std::size_t>(axis)] = -1;
  const std::vector<std::byte> samples(std::size_t{kThick} * kWide * kWide, std::byte{100});
  board.load_volume({.samples = samples, .dims = dims, .spacing = spacing, .find_gradients = false});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, -std::expm1(-depth / (kThick - 1))}}});
  Material fog;
  fog.scattering = albedo;
  fog.bsdf = Bsdf::kIsotropic;
  board.set_material(fog);
  const LightingReport report = board.illuminate(std::array<Light, 1>{DirectionalLight{towards, 1}}, settings);
  double all = 0;
  std::array<double, 6> shares = report.escaped_by_face;
  for (double& share : shares) all += share, share /= report.emitted;
  EXPECT_NEAR(all, report.escaped, 1e-12 * report.escaped);
  return shares;
}

constexpr const char* kWideBoard =
    "emu:?set=asic.datapath=wide&set=asic.block_voxels=16&set=asic.max_volume_voxels=128";

TEST(LightingReport, TellsTheTransmittanceOfASlabThatAbsorbsWhicheverWayItLies) {
  Board board = Board::open(kWideBoard);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double depth : {0.3, 2.0}) {
      const auto shares = slab_shares(board, axis, depth, 0, {});
      for (std::size_t face = 0; face < 6; ++face) {
        const bool far = face == 2 * static_cast<std::size_t>(axis) + 1;
        EXPECT_NEAR(shares[face], far ? std::exp(-depth) : 0, far ? 0.003 * std::exp(-depth) : 0)
            << "face " << face << ", axis " << axis << ", depth " << depth;
      }
    }
  }
}

TEST(LightingReport, TellsReflectanceAndTransmittanceOfASlabThatScatters) {
  Board board = Board::open(kWideBoard);
  for (const auto& [axis, depth, albedo, rays] :
       {std::tuple{2, 4.0, 0.95, Albedo::kLow}, {0, 1.0, 0.5, Albedo::kHigh}, {1, 0.5, 0.9, Albedo::kLow}}) {
    const reference::Fates expected = reference::slab(depth, albedo, 1'000'000, 7);
    const Illumination settings{.albedo = rays, .rays_per_face_voxel = 8, .lifetime = 1000};
    const auto shares = slab_shares(board, axis, depth, albedo, settings);
    const auto low = 2 * static_cast<std::size_t>(axis);
    const double photons = 127.0 * 127 * settings.rays_per_face_voxel;
    for (const auto& [share, right] : {std::pair{shares[low], expected.back}, {shares[low + 1], expected.through}}) {
      const double error = std::hypot(std::sqrt(right.mean * (1 - right.mean) / photons), right.error);
      EXPECT_NEAR(share, right.mean, std::max(3 * error, 0.005 * right.mean)) << "axis " << axis;
    }
  }
}

TEST_F(Lighting, EmitsThePowerThatFallsIntoTheVolumeAndAccountsForAllOfIt) {
  const LightingReport report = board_.illuminate(lamp_, {});
  EXPECT_GT(report.rays, 0u);
  EXPECT_GT(report.deposited, 0);
  EXPECT_NEAR(sum(report), report.emitted, 1e-9 * report.emitted);
  // The nearest face is seen under this solid angle from 20 voxels away.
  const double half = 15.5, distance = 20, solid = 4 * std::asin(half * half / (half * half + distance * distance));
  EXPECT_NEAR(report.emitted / 1000, solid / (4 * std::acos(-1.0)), 0.01);
  const std::vector<float> irradiance = board_.read_irradiance();
  EXPECT_NEAR(std::accumulate(irradiance.begin(), irradiance.end(), 0.0), report.deposited, 1e-5 * report.deposited);
}

TEST_F(Lighting, TheSideTowardsTheLightIsBrightAndTheOtherDark) {
  board_.illuminate(lamp_, {});
  const std::vector<float> irradiance = board_.read_irradiance();
  const auto slice = [&irradiance](std::size_t z) {
    return std::accumulate(irradiance.begin() + static_cast<std::ptrdiff_t>(z * 1024),
                           irradiance.begin() + static_cast<std::ptrdiff_t>((z + 1) * 1024), 0.0);
  };
  EXPECT_GT(slice(8), 50 * (slice(22) + slice(23)));
  EXPECT_EQ(slice(2), 0);  // clear air keeps nothing
}

TEST_F(Lighting, APictureLitByIrradianceIsNotBlackAndAnIlluminationServesManyPictures) {
  board_.illuminate(lamp_, {});
  const Image first = board_.render(lit_view()), second = board_.render(lit_view());
  EXPECT_GT(first.at(16, 16).red, 20);
  EXPECT_EQ(first.pixels, second.pixels);
  View local = lit_view();
  local.irradiance = false;
  const Image shaded = board_.render(local);
  EXPECT_NE(shaded.pixels, first.pixels);
  EXPECT_EQ(board_.render(lit_view()).pixels, first.pixels);  // the tables have come back
}

TEST_F(Lighting, TwiceTheExposureIsTwiceAsBright) {
  board_.illuminate(lamp_, {});
  View view = lit_view();
  view.shade = false;
  view.exposure = 4;
  const int once = board_.render(view).at(16, 16).red;
  view.exposure = 8;
  ASSERT_GT(once, 10);
  ASSERT_LT(once, 120);
  EXPECT_NEAR(board_.render(view).at(16, 16).red, 2 * once, 2);
}

TEST_F(Lighting, ProgressEndsWithAllParts) {
  std::uint32_t done = 1, all = 2;
  const std::vector<Light> lamps(2, lamp_.front());
  board_.illuminate(lamps, {}, [&](std::uint32_t d, std::uint32_t a) { done = d, all = a; });
  EXPECT_EQ(done, all);
  EXPECT_GT(all, 0u);
}

TEST_F(Lighting, AnotherPassBeginsAnew) {
  const LightingReport first = board_.illuminate(lamp_, {});
  board_.illuminate(lamp_, {});
  const std::vector<float> irradiance = board_.read_irradiance();
  EXPECT_NEAR(std::accumulate(irradiance.begin(), irradiance.end(), 0.0), first.deposited, 1e-5 * first.deposited);
  board_.illuminate({}, {});
  const std::vector<float> none = board_.read_irradiance();
  EXPECT_EQ(*std::max_element(none.begin(), none.end()), 0);
}

TEST_F(Lighting, SeedsAreIndependentExperimentsOfOneMean) {
  Illumination settings;
  settings.albedo = Albedo::kHigh;
  settings.rays_per_face_voxel = 32;
  const LightingReport one = board_.illuminate(lamp_, settings);
  settings.seed = 7;
  const LightingReport other = board_.illuminate(lamp_, settings);
  EXPECT_NE(one.deposited, other.deposited);
  EXPECT_NEAR(one.deposited / other.deposited, 1, 0.05);
}

TEST_F(Lighting, TheWideDatapathAgreesWithThePapersWithinItsNoise) {
  Board wide = Board::open(std::string(kSmallBlocks) + "&set=asic.datapath=wide");
  EXPECT_TRUE(wide.info().wide);
  load(wide);
  Illumination settings;
  settings.rays_per_face_voxel = 4;
  const LightingReport exact = wide.illuminate(lamp_, settings), coarse = board_.illuminate(lamp_, settings);
  EXPECT_NEAR(coarse.deposited / exact.deposited, 1, 0.02);
  EXPECT_LT(exact.unit, coarse.unit / 1000);
  EXPECT_NEAR(board_.render(lit_view()).at(16, 16).red, wide.render(lit_view()).at(16, 16).red, 12);
}

TEST_F(Lighting, ThePrintedRulesLoseWhatIsScatteredAndSaySo) {
  Illumination settings;
  settings.rules = EnergyRules::kAsPrinted;
  const LightingReport report = board_.illuminate(lamp_, settings);
  EXPECT_GT(report.scattered_away, 0.3 * report.deposited);
  ASSERT_FALSE(report.warnings.empty());
  EXPECT_THAT(report.warnings.front(), HasSubstr("printed rules"));
}

TEST_F(Lighting, WarnsOfALightInASolid) {
  const std::vector<Light> buried{PointLight{{16, 16, 16}, 1000}};
  const LightingReport report = board_.illuminate(buried, {});
  EXPECT_NEAR(sum(report), report.emitted, 1e-9 * report.emitted);
  EXPECT_THAT(report.warnings, testing::Contains(HasSubstr("lights[0] is in a solid")));
}

TEST_F(Lighting, WarnsWhereEnergyIsClipped) {
  Illumination settings;
  settings.rays_per_face_voxel = 16;
  const std::vector<Light> near{PointLight{{16, 16, 7}, 1000}};
  const LightingReport report = board_.illuminate(near, settings);
  EXPECT_NEAR(sum(report), report.emitted, 1e-9 * report.emitted);
  ASSERT_GT(report.clipped, 0.01 * report.emitted);
  EXPECT_THAT(report.warnings, testing::Contains(HasSubstr("clipped")));
}

TEST_F(Lighting, LightsWithoutSenseAreRefusedByTheirField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(PointLight{{0, 0, nan}, 1}), "lights[0].position.z");
  EXPECT_EQ(refusal(PointLight{{0, 0, 0}, 0}), "lights[0].power");
  EXPECT_EQ(refusal(PointLight{{0, 0, 0}, -3}), "lights[0].power");
  EXPECT_EQ(refusal(DirectionalLight{{0, 0, 0}, 1}), "lights[0].towards");
  EXPECT_EQ(refusal(DirectionalLight{{0, 0, 1}, nan}), "lights[0].irradiance");
  EXPECT_EQ(refusal(RectangleLight{{0, 0, -9}, {3, 0, 0}, {6, 0, 0}, 1}), "lights[0].edge_u x edge_v");
  EXPECT_EQ(refusal(SphereLight{{0, 0, -9}, 0, 1}), "lights[0].radius");
  Illumination settings;
  settings.rays_per_face_voxel = 0;
  EXPECT_EQ(refusal(lamp_[0], settings), "rays_per_face_voxel");
  settings = {};
  settings.lifetime = 1024;
  EXPECT_EQ(refusal(lamp_[0], settings), "lifetime");
  EXPECT_EQ(refusal(lamp_[0]), "none");
}

TEST_F(Lighting, MaterialsWithoutSenseAreRefusedByTheirField) {
  const auto field = [this](const Material& material, int tag = 0) -> std::string {
    try {
      board_.set_material(material, tag);
    } catch (const BadArgument& error) {
      return error.field();
    }
    return "none";
  };
  EXPECT_EQ(field({.scattering = 1.01}), "material.scattering");
  EXPECT_EQ(field({.gloss = -1}), "material.gloss");
  EXPECT_EQ(field({.routine = 256}), "material.routine");
  EXPECT_EQ(field({.parameters = std::vector<float>(33)}), "material.parameters");
  EXPECT_EQ(field({}, 4), "tag");
  EXPECT_EQ(field({.scattering = 1, .bsdf = Bsdf::kIsotropic}), "none");
}

TEST_F(Lighting, ARoutineThatTheBoardDoesNotHaveIsRefusedWithTheMaterialsTag) {
  Material strange;
  strange.bsdf = Bsdf::kTrap;
  strange.routine = 99;
  board_.set_material(strange, 2);
  try {
    board_.illuminate(lamp_, {});
    FAIL() << "taken";
  } catch (const Rejected& error) {
    EXPECT_THAT(error.what(), HasSubstr("material 2"));
    EXPECT_THAT(error.what(), HasSubstr("99"));
  }
  board_.set_material({}, 2);
  EXPECT_GT(board_.illuminate(lamp_, {}).deposited, 0);
}

TEST_F(Lighting, RaysThatBounceForEverAreGivenUpAfterTheirLifetime) {
  Material mist;  // scatters all, absorbs nothing
  mist.scattering = 1;
  mist.bsdf = Bsdf::kIsotropic;
  board_.set_material(mist);
  Illumination settings;
  settings.lifetime = 2;
  const LightingReport report = board_.illuminate(lamp_, settings);
  EXPECT_GT(report.given_up, 0);
  EXPECT_EQ(report.deposited, 0);
  EXPECT_NEAR(sum(report), report.emitted, 1e-9 * report.emitted);
}

TEST_F(Lighting, IrradianceIsAskedForOnlyAfterAPass) {
  Board fresh = Board::open(kSmallBlocks);
  EXPECT_THROW(fresh.illuminate(lamp_, {}), Rejected);
  fresh.load_volume(BoxVolume(32, 8, 23).view());
  EXPECT_THROW(fresh.read_irradiance(), Rejected);
  EXPECT_THROW(fresh.render(lit_view()), Rejected);
}

TEST_F(Lighting, ANewVolumeHasNoIrradianceYet) {
  board_.illuminate(lamp_, {});
  board_.load_volume(BoxVolume(32, 4, 12).view());
  EXPECT_THROW(board_.read_irradiance(), Rejected);
}

TEST_F(Lighting, CutPlanesOfAViewDoNotKeepLightOut) {
  const LightingReport before = board_.illuminate(lamp_, {});
  View view = lit_view();
  view.cut_planes.push_back({{0, 0, 1}, 16});
  board_.render(view);
  EXPECT_EQ(board_.illuminate(lamp_, {}).deposited, before.deposited);
}

TEST_F(Lighting, FidelityBusAndThreadsChangeNoWordAndNoPixel) {
  board_.illuminate(lamp_, {});
  View view = lit_view();
  view.scatter = true;
  const std::vector<float> words = board_.read_irradiance();
  const Image image = board_.render(view);
  for (const char* other : {"&fidelity=cycle", "&fidelity=cycle&bus=agp4x&set=asic.processors=3", "&threads=1"}) {
    Board board = Board::open(std::string(kSmallBlocks) + other);
    load(board);
    board.illuminate(lamp_, {});
    EXPECT_EQ(board.read_irradiance(), words) << other;
    EXPECT_EQ(board.render(view).pixels, image.pixels) << other;
  }
}

}  // namespace
}  // namespace gicube
