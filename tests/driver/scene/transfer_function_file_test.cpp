#include "gicube/scene/transfer_function_file.h"

#include "test.h"

namespace gicube::scene {
namespace {

std::string faults_of(std::string_view text) {
  return message_of<InputError>([&] { parse_transfer_function(text, "a.tf"); });
}

TEST(TransferFunctionFile, KeepsPointsInTheirOrder) {
  const auto file =
      parse_transfer_function("# test\ncolour 1 0 0.5 1 # blue\ncolor 2.5 1 1 1\nopacity -3 0\nopacity 7 1\n", "a.tf");
  EXPECT_EQ(file.scale, TransferScale::kAbsolute);
  ASSERT_EQ(file.function.colours.size(), 2u);
  EXPECT_EQ(file.function.colours[0].value, 1);
  EXPECT_EQ(file.function.colours[0].colour, (Colour{0, 0.5, 1}));
  EXPECT_EQ(file.function.colours[1].value, 2.5);
  ASSERT_EQ(file.function.opacities.size(), 2u);
  EXPECT_EQ(file.function.opacities[0].value, -3);
  EXPECT_EQ(file.function.opacities[1].opacity, 1);
}

TEST(TransferFunctionFile, ScalesNormalisedValuesToTheVolumesRange) {
  const auto file = parse_transfer_function("values normalised\ncolour 0.5 1 1 1\nopacity 0 0\nopacity 1 1", "a.tf");
  const TransferFunction function = in_values_of({-1000, 3000}, file);
  EXPECT_EQ(function.colours[0].value, 1000);
  EXPECT_EQ(function.opacities[0].value, -1000);
  EXPECT_EQ(function.opacities[1].value, 3000);
}

TEST(TransferFunctionFile, LeavesAbsoluteValuesAsTheyAre) {
  const auto file = parse_transfer_function("values absolute\ncolour 0.5 1 1 1\nopacity 12 0", "a.tf");
  EXPECT_EQ(in_values_of({-1000, 3000}, file).opacities[0].value, 12);
}

TEST(TransferFunctionFile, TakesTwoPointsOfOneValueAsAStepButNotThree) {
  EXPECT_EQ(faults_of("colour 0 1 1 1\nopacity 5 0\nopacity 5 1"), "none");
  EXPECT_THAT(faults_of("colour 0 1 1 1\nopacity 5 0\nopacity 5 1\nopacity 5 0"),
              HasSubstr("a.tf:4: opacity value: expected a number above 5, got 5"));
}

TEST(TransferFunctionFile, ReportsAllFaultsWithTheirLines) {
  const std::string faults = faults_of(
      "colour 0 1 1\n"
      "opacity 1 1.5\n"
      "opacity x 1\n"
      "\n"
      "shine 3\n"
      "colour 5 0 0 0\n"
      "colour 4 0 0 0\n"
      "opacity nan 0\n"
      "values sometimes\n");
  EXPECT_THAT(faults, HasSubstr("a.tf:1: colour: expected VALUE RED GREEN BLUE, got 3 values"));
  EXPECT_THAT(faults, HasSubstr("a.tf:2: opacity: expected a number from 0 to 1, got \"1.5\""));
  EXPECT_THAT(faults, HasSubstr("a.tf:3: opacity value: expected a finite number, got \"x\""));
  EXPECT_THAT(faults, HasSubstr("a.tf:5: statement: expected values, colour or opacity, got \"shine\""));
  EXPECT_THAT(faults, HasSubstr("a.tf:7: colour value: expected a number above 5, got 4"));
  EXPECT_THAT(faults, HasSubstr("a.tf:8: opacity value: expected a finite number, got \"nan\""));
  EXPECT_THAT(faults, HasSubstr("a.tf:9: values: expected one such statement, before all points, got another"));
}

TEST(TransferFunctionFile, MayHaveAByteOrderMark) {
  const std::filesystem::path file = testing::TempDir() + "bom.tf";
  std::ofstream(file, std::ios::binary) << "\xEF\xBB\xBF"
                                           "colour 0 1 1 1\nopacity 90 0\nopacity 150 0.8\n";
  const TransferFunctionFile read = read_transfer_function(file);
  EXPECT_EQ(read.function.colours.size(), 1u);
  EXPECT_EQ(read.function.opacities.back().value, 150);
  EXPECT_EQ(read.function.opacities.back().opacity, 0.8);
}

TEST(TransferFunctionFile, NeedsAPointOfEachKind) {
  EXPECT_THAT(faults_of("opacity 1 1"), HasSubstr("a.tf: colour: expected at least one point, got none"));
  EXPECT_THAT(faults_of("colour 1 1 1 1"), HasSubstr("a.tf: opacity: expected at least one point, got none"));
}

TEST(TransferFunctionFile, IsNamedInTheErrorIfItIsNotThere) {
  EXPECT_THROW(read_transfer_function("/nowhere/a.tf"), InputError);
}

TEST(TransferFunctionFile, KnowsWhatItsValuesAre) {
  const auto scale = [](const char* word) {
    return parse_transfer_function(std::string("values ") + word + "\nopacity 0 0", "a.tf").scale;
  };
  EXPECT_EQ(scale("absolute"), TransferScale::kAbsolute);
  EXPECT_EQ(scale("hounsfield"), TransferScale::kHounsfield);
  EXPECT_EQ(scale("robust"), TransferScale::kRobust);
}

TEST(Presets, AllParseAndSayWhatTheirValuesAre) {
  std::vector<std::string> names;
  for (const Preset& preset : presets()) {
    names.emplace_back(preset.name);
    const TransferFunctionFile file = find_preset(preset.name);
    EXPECT_NE(file.scale, TransferScale::kAbsolute) << preset.name;
    if (file.scale == TransferScale::kHounsfield) continue;
    EXPECT_GE(file.function.opacities.front().value, 0) << preset.name;
    EXPECT_LE(file.function.opacities.back().value, 1) << preset.name;
    if (preset.name == "diverging") continue;
    EXPECT_EQ(file.function.opacities.front().opacity, 0) << preset.name;
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("ct-bone", "ct-skin", "colours", "ct-engine", "mri-brain",
                                                   "micro-ct-bone", "ramp", "mri-t2", "diverging", "surface"));
}

TEST(Presets, AreListedWhenANameIsUnknown) {
  try {
    find_transfer_function("ct-bnoe");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("ct-bone"));
    EXPECT_THAT(error.what(), HasSubstr("\"ct-bnoe\""));
  }
}

}  // namespace
}  // namespace gicube::scene
