// Volumes whose values have a known distribution: what a survey tells of them, and the look that follows.
#include "gicube/scene/survey.h"

#include "gicube/scene/scene.h"
#include "test.h"
#include "voxels.h"

namespace gicube::scene {
namespace {

constexpr int kEdge = 48;

template <typename Sample>
Volume made(SampleType type, const std::function<double(double, double, double)>& value) {
  Volume volume;
  volume.type = type;
  volume.dims = {kEdge, kEdge, kEdge};
  volume.source = "test";
  for_each_voxel({kEdge, kEdge, kEdge}, [&](int x, int y, int z) {
    const auto at = [](int i) { return (i - 23.5) / 23.5; };
    const auto sample = static_cast<Sample>(value(at(x), at(y), at(z)));
    const auto* bytes = reinterpret_cast<const std::byte*>(&sample);
    volume.samples.insert(volume.samples.end(), bytes, bytes + sizeof sample);
  });
  return volume;
}

// A body of soft tissue with a shell of bone in air, with noise.
struct Head {
  double slope = 1, intercept = 0, noise = 15;
  mutable std::mt19937 random{7};

  double operator()(double x, double y, double z) const {
    const double r = std::sqrt(x * x + y * y + z * z);
    const double hu = r > 0.85 ? -1000 : r < 0.75 && r > 0.62 ? 1300 : 40;
    return slope * (hu + std::normal_distribution<>(0, noise)(random)) + intercept;
  }
};

// Where a look begins to show anything.
double first_visible(const TransferFunctionFile& file) {
  double last = file.function.opacities.front().value;
  for (const OpacityPoint& point : file.function.opacities) {
    if (point.opacity > 0) break;
    last = point.value;
  }
  return last;
}

TEST(Survey, TellsHounsfieldUnitsByTheirValues) {
  const Survey survey = survey_of(made<std::int16_t>(SampleType::kInt16, Head{}));
  EXPECT_EQ(survey.kind, DataKind::kCt);
  EXPECT_EQ(survey.ct, (ValueRange{-1000, 0}));
  EXPECT_TRUE(survey.has_bone);
  const AutomaticLook look = automatic_look(survey);
  EXPECT_EQ(look.name, "ct-bone");
  EXPECT_EQ(first_visible(look.function), 180);  // HU, as in the preset
  EXPECT_THAT(look.why, HasSubstr("transfer function: ct-bone, since the values are Hounsfield units"));
}

TEST(Survey, FindsAirAndTissueOfACtInOtherUnits) {
  // Linear attenuation, 0.02 a millimetre for water.
  const Survey survey = survey_of(made<float>(SampleType::kFloat32, Head{2e-5, 0.02}));
  EXPECT_EQ(survey.kind, DataKind::kCt);
  EXPECT_NEAR(survey.ct.low, 0, 0.0006);
  EXPECT_NEAR(survey.ct.high, 0.02, 0.0006);
  EXPECT_NEAR(first_visible(automatic_look(survey).function), 0.02 * 1.18, 0.0008);
}

// Ribs of 700 HU, stored without a sign. A casting with inserts may have these ratios, but not these values.
TEST(Survey, KnowsCtThatIsStoredWithoutASign) {
  std::mt19937 random{9};
  const auto chest = [&](double air) {
    return made<std::uint16_t>(SampleType::kUint16, [&, air](double x, double y, double z) {
      const double r = std::sqrt(x * x + y * y + z * z);
      const double hu = r > 0.85 ? -1000 : r > 0.8 && z > 0 ? 700 : 40;
      return (1000 + hu + std::normal_distribution<>(0, 15)(random) + 60) * air / 1000;
    });
  };
  EXPECT_EQ(automatic_look(survey_of(chest(1000))).name, "ct-bone");
  EXPECT_EQ(automatic_look(survey_of(chest(300))).name, "ct-engine");
}

TEST(Survey, ACloudWhoseDensestPartsAreRareIsNoSolid) {
  std::mt19937 random{11};
  const Survey survey = survey_of(made<float>(SampleType::kFloat32, [&](double x, double y, double z) {
    const double r = std::sqrt(x * x + y * y + z * z);
    return r > 0.9 ? 0 : std::exponential_distribution<>(6)(random) * (0.9 - r);
  }));
  EXPECT_EQ(survey.kind, DataKind::kOther);
  EXPECT_THAT(survey.why, HasSubstr("as in a cloud"));
}

TEST(Survey, LeavesPaddingAndSingleExtremeVoxelsOut) {
  const Head head;
  Volume volume = made<std::int16_t>(
      SampleType::kInt16, [&](double x, double y, double z) { return x * x + y * y > 1 ? -3024.0 : head(x, y, z); });
  const std::int16_t metal = 30000;
  std::memcpy(&volume.samples[volume.samples.size() / 2], &metal, sizeof metal);
  const Survey survey = survey_of(volume);
  EXPECT_EQ(survey.kind, DataKind::kCt);
  EXPECT_EQ(survey.padding, -3024);
  EXPECT_EQ(survey.whole, (ValueRange{-3024, 30000}));
  EXPECT_GT(survey.range.low, -1200);
  EXPECT_LT(survey.range.high, 4000);
  EXPECT_EQ(automatic_look(survey).name, "ct-bone");
  EXPECT_THAT(survey.why, HasSubstr("-3024 is padding"));
}

TEST(Survey, KnowsMasksAndLabels) {
  const auto shells = [](double x, double y, double z) {
    return std::floor(4 - 3.9 * std::min(1.0, std::sqrt(x * x + y * y + z * z)));
  };
  EXPECT_EQ(survey_of(made<std::uint8_t>(SampleType::kUint8,
                                         [&](double x, double y, double z) { return shells(x, y, z) > 1; }))
                .kind,
            DataKind::kMask);
  EXPECT_EQ(survey_of(made<std::uint8_t>(SampleType::kUint8, shells)).kind, DataKind::kLabels);
  // As some programs write label maps.
  EXPECT_EQ(survey_of(made<float>(SampleType::kFloat32, shells)).kind, DataKind::kLabels);
  // A scan of few values is none.
  EXPECT_NE(survey_of(made<std::uint8_t>(SampleType::kUint8, Head{0.02, 24, 30})).kind, DataKind::kLabels);
}

TEST(Survey, TellsASolidFromAPartWithInserts) {
  std::mt19937 random{3};
  std::normal_distribution<> noise(0, 3);
  const auto part = [&](double insert) {
    return made<std::uint8_t>(SampleType::kUint8, [&, insert](double x, double y, double z) {
      const bool inside = std::max({std::abs(x), std::abs(y), std::abs(z)}) < 0.7;
      const double value = !inside ? 20 : std::hypot(x, y) < 0.15 ? insert : 140;
      return std::clamp(value + noise(random), 0.0, 255.0);
    });
  };
  EXPECT_EQ(automatic_look(survey_of(part(140))).name, "surface");
  EXPECT_EQ(automatic_look(survey_of(part(230))).name, "ct-engine");
}

TEST(Survey, TakesTissuesThatOverlapForAnMri) {
  std::mt19937 random{5};
  const auto brain = [&](double fluid) {
    return made<float>(SampleType::kFloat32, [&, fluid](double x, double y, double z) {
      const double r = std::sqrt(x * x + y * y + z * z);
      const double tissue = std::uniform_real_distribution<>(60, 200)(random);
      return r > 0.85 ? 0 : r < 0.3 ? fluid : 0.5 * (tissue + std::uniform_real_distribution<>(60, 200)(random));
    });
  };
  EXPECT_EQ(automatic_look(survey_of(brain(120))).name, "mri-brain") << automatic_look(survey_of(brain(120))).why;
  EXPECT_EQ(automatic_look(survey_of(brain(600))).name, "mri-t2");
}

TEST(Survey, TakesValuesOnBothSidesOfZeroForAField) {
  const Survey survey = survey_of(made<float>(SampleType::kFloat32, [](double x, double y, double z) {
    return std::sin(3 * x) * std::exp(-3 * (x * x + y * y + z * z));
  }));
  EXPECT_EQ(survey.kind, DataKind::kSigned);
  EXPECT_EQ(survey.robust.low, -survey.robust.high);
}

TEST(Survey, IsOfOneValueOrOfNone) {
  EXPECT_EQ(survey_of(made<std::uint8_t>(SampleType::kUint8, [](double, double, double) { return 7; })).kind,
            DataKind::kConstant);
  EXPECT_THROW(survey_of(made<float>(SampleType::kFloat32, [](double, double, double) { return NAN; })), InputError);
}

TEST(AutomaticLook, TakesTheUsersRangeForItsEnds) {
  Survey survey;
  survey.kind = DataKind::kPart;
  survey.robust = {0, 255};
  const TransferFunctionFile preset = find_preset("ct-engine");
  const TransferFunctionFile look = automatic_look(survey, ValueRange{100, 300}).function;
  EXPECT_EQ(look.function.opacities[0].value, 100 + 200 * preset.function.opacities[0].value);
  EXPECT_EQ(look.scale, TransferScale::kAbsolute);
}

TEST(InValuesOf, PutsEachScaleInItsPlace) {
  Survey survey;
  survey.robust = {10, 30};
  survey.ct = {0, 64};
  const auto at_one = [&](TransferScale scale) {
    return in_values_of(survey, {-5, 5}, {{{{1, {1, 1, 1}}}, {{1, 1}}}, scale}).function.opacities[0].value;
  };
  EXPECT_EQ(at_one(TransferScale::kAbsolute), 1);
  EXPECT_EQ(at_one(TransferScale::kNormalised), 5);
  EXPECT_EQ(at_one(TransferScale::kRobust), 30);
  EXPECT_NEAR(at_one(TransferScale::kHounsfield), 64.064, 1e-9);
}

// A ball in the streaks of a reconstruction from few views, which fill more of the volume than it does.
TEST(Survey, FindsAMaterialAboveNoise) {
  std::mt19937 random(3);
  const Survey survey = survey_of(made<float>(SampleType::kFloat32, [&random](double x, double y, double z) {
    const bool inside = std::sqrt(x * x + y * y + z * z) < 0.3;
    const double streak = std::exponential_distribution<>(40)(random);
    return (inside ? std::normal_distribution<>(0.2, 0.035)(random) : 0) + (x + y > 0.6 ? streak : 0);
  }));
  const AutomaticLook look = automatic_look(survey);
  EXPECT_EQ(look.name, "surface") << look.why;
  EXPECT_THAT(look.why, HasSubstr("above the noise"));
  EXPECT_NEAR(survey.usual, 0.2, 0.03);
}

TEST(Survey, ACloudIsNoSurface) {
  const auto ball = [](double soft) {
    return survey_of(made<float>(SampleType::kFloat32, [soft](double x, double y, double z) {
      return std::clamp((0.9 - std::sqrt(x * x + y * y + z * z)) / soft, 0.0, 1.0);
    }));
  };
  EXPECT_EQ(automatic_look(ball(0.5)).name, "ramp");
  EXPECT_THAT(ball(0.5).why, HasSubstr("as in a cloud"));
  EXPECT_EQ(automatic_look(ball(0.05)).name, "surface");
}

}  // namespace
}  // namespace gicube::scene
