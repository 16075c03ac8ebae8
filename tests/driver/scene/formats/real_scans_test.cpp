#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

const std::filesystem::path kScans = std::filesystem::path(GICUBE_SOURCE_DIR) / "../shared/data";

struct Sum {
  double least = 0, most = 0, mean = 0;
};

template <typename Sample>
Sum sum_of(const Volume& volume) {
  const auto samples = samples_of<Sample>(volume);
  const auto [least, most] = std::ranges::minmax(samples);
  double sum = 0;
  for (const Sample sample : samples) sum += static_cast<double>(sample);
  return {static_cast<double>(least), static_cast<double>(most), sum / static_cast<double>(samples.size())};
}

// How many samples fall into each eighth of 0..255.
std::array<int, 8> eighths(const Volume& volume) {
  std::array<int, 8> counts{};
  for (const std::byte sample : volume.samples) ++counts[std::to_integer<std::size_t>(sample) / 32];
  return counts;
}

#define SKIP_WITHOUT(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no scan at " << (path)

TEST(RealScans, HeadSlicesMakeTheHead) {
  const auto path = kScans / "visible_human_female_head_ct";
  SKIP_WITHOUT(path);
  const Volume volume = read_volume(path);
  EXPECT_EQ(volume.dims, (Dims{512, 512, 234}));
  EXPECT_EQ(volume.type, SampleType::kUint8);
  const Sum sum = sum_of<std::uint8_t>(volume);
  EXPECT_EQ(sum.least, 0);
  EXPECT_EQ(sum.most, 255);
  EXPECT_NEAR(sum.mean, 7.048, 0.0005);
}

TEST(RealScans, EngineHasItsHistogram) {
  const auto path = kScans / "engine_ct/engine.nii.gz";
  SKIP_WITHOUT(path);
  const Volume volume = read_volume(path);
  EXPECT_EQ(volume.dims, (Dims{256, 256, 128}));
  EXPECT_EQ(volume.type, SampleType::kUint8);
  EXPECT_EQ(volume.spacing, (Vec3{1, 1, 1}));
  EXPECT_NEAR(sum_of<std::uint8_t>(volume).mean, 20.694, 0.0005);
  EXPECT_EQ(eighths(volume), (std::array{7008936, 180504, 140160, 213111, 749353, 33454, 27849, 35241}));
}

TEST(RealScans, MouseHasItsHistogramAndSpacing) {
  const auto path = kScans / "mouse_head_microct/C57BL6_J_.nii.gz";
  SKIP_WITHOUT(path);
  const Volume volume = read_volume(path);
  EXPECT_EQ(volume.dims, (Dims{170, 170, 147}));
  EXPECT_NEAR(volume.spacing.x, 0.1411, 5e-5);
  EXPECT_NEAR(volume.spacing.y, 0.1411, 5e-5);
  EXPECT_NEAR(volume.spacing.z, 0.1409, 5e-5);
  EXPECT_NEAR(sum_of<std::uint8_t>(volume).mean, 4.091, 0.0005);
  EXPECT_EQ(eighths(volume), (std::array{4131128, 55180, 39971, 16413, 4371, 860, 279, 98}));
}

TEST(RealScans, BrainHasItsHistogramsAndItsScaledSeriesItsSlope) {
  const auto path = kScans / "stroke_brain_mri";
  SKIP_WITHOUT(path);
  const Volume t1 = read_volume(path / "T1.nii.gz"), flair = read_volume(path / "FLAIR.nii.gz");
  EXPECT_EQ(t1.dims, (Dims{124, 160, 140}));
  EXPECT_EQ(eighths(t1), (std::array{1769769, 133790, 142847, 259234, 254321, 184091, 32947, 601}));
  EXPECT_EQ(eighths(flair), (std::array{1775701, 79557, 133819, 474109, 264171, 43844, 6089, 310}));
  const Volume t2 = read_volume(path / "T2.nii.gz");
  ASSERT_EQ(t2.type, SampleType::kFloat32);
  const Sum sum = sum_of<float>(t2);
  EXPECT_EQ(sum.least, 0);
  EXPECT_NEAR(sum.most, 251 * 2.00784, 0.001);
  EXPECT_NEAR(sum.mean, 28.878 * 2.00784, 0.002);
  ASSERT_TRUE(t2.range.has_value());
  EXPECT_NEAR(t2.range->high, 255 * 2.00784, 0.001);
}

TEST(RealScans, RawProjectionsAreSixteenBit) {
  const auto path = kScans / "ctsimu_tetra_cone_projections/projections/tetra_projections.raw";
  SKIP_WITHOUT(path);
  const Volume volume = read_volume(path, RawLayout{.dims = {150, 150, 21}, .type = SampleType::kUint16});
  const Sum sum = sum_of<std::uint16_t>(volume);
  EXPECT_EQ(sum.least, 121);
  EXPECT_EQ(sum.most, 59999);
  EXPECT_NEAR(sum.mean, 55070.958, 0.001);
}

}  // namespace
}  // namespace gicube::scene
