// Files that are read in planes have the samples of those that are read whole.
#include "gicube/scene/scene.h"
#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

VolumeSource source_of(const std::filesystem::path& file, const std::optional<RawLayout>& raw = {}) {
  VolumeSource source;
  source.file = file;
  source.raw = raw;
  return source;
}

void expect_same(const VolumeSource& source) {
  SCOPED_TRACE(source.file);
  const Volume whole = read_volume(source), opened = open_volume(source);
  EXPECT_EQ(opened.dims, whole.dims);
  EXPECT_EQ(opened.type, whole.type);
  EXPECT_EQ(opened.spacing, whole.spacing);
  EXPECT_EQ(opened.range, whole.range);
  EXPECT_EQ(opened.source, whole.source);
  ASSERT_TRUE(opened.planes);
  EXPECT_TRUE(opened.samples.empty());
  for (const int planes : {1, 3, 4}) EXPECT_EQ(bytes_in_planes(opened, planes), whole.samples) << planes;
  EXPECT_EQ(value_range_of(opened), value_range_of(whole));
}

TEST(Planes, HaveTheSamplesOfEveryFormat) {
  const TemporaryFolder folder;
  const std::vector<float> values = ramp<float>();
  for (const char* name : {"v.nrrd", "v.mhd", "v.mha", "v.nii", "v.nii.gz"}) {
    write_volume({.dims = kRampDims, .spacing = {1, 2, 3}, .origin = {}, .values = values}, folder.path() / name);
    expect_same(source_of(folder.path() / name));
  }
  const RawLayout big{kRampDims, SampleType::kInt16, {1, 2, 3}, true, 3};
  expect_same(source_of(folder.write("v.raw", "abc" + stored(ramp<std::int16_t>(), Order::kBig)), big));
  expect_same(source_of(folder.write("v.gz", gzip("abc" + stored(ramp<std::int16_t>(), Order::kBig))), big));
  const std::string head = "NRRD0004\ntype: int\ndimension: 3\nsizes: 2 3 4\nendian: little\nencoding: gzip\n\n";
  expect_same(source_of(folder.write("i.nrrd", head + gzip(stored(ramp<std::int32_t>())))));  // becomes float32
}

TEST(Planes, OfTextAreReadWhole) {
  const TemporaryFolder folder;
  const VolumeSource source = source_of(
      folder.write("v.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nencoding: ascii\n\n1 2 3 4"));
  const Volume volume = open_volume(source);
  EXPECT_FALSE(volume.planes);
  EXPECT_EQ(samples_of<std::int16_t>(volume), (std::vector<std::int16_t>{1, 2, 3, 4}));
}

TEST(Planes, SayWhatIsWrongWhenItIsReached) {
  const TemporaryFolder folder;
  const RawLayout words{kRampDims, SampleType::kUint12, {1, 1, 1}, false, 0};
  const auto message = [](const Volume& volume, const char* text) {
    EXPECT_THROWS(FileError, text, bytes_in_planes(volume, 1));
  };
  const std::string bytes = stored(ramp<std::uint16_t>());
  const Volume damaged = open_volume(source_of(folder.write("damaged.gz", gzip(bytes).substr(0, 30)), words));
  message(damaged, "damaged.gz");
  EXPECT_THAT([&] { open_volume(source_of(folder.write("short.raw", bytes.substr(1)), words)); },
              ThrowsMessage<FileError>(HasSubstr("expected 48 bytes, got 47")));
  message(open_volume(source_of(folder.write("long.raw", bytes + "x"), words)), "expected 48 bytes, got more");
  std::vector<std::uint16_t> high = ramp<std::uint16_t>();
  high[20] = 4096;
  message(open_volume(source_of(folder.write("high.raw", stored(high)), words)),
          "sample 20: expected 0..4095, got 4096");
  const Volume good = open_volume(source_of(folder.write("good.raw", bytes), words));
  std::vector<std::byte> plane(12);
  EXPECT_THROWS(FileError, "planes: expected the next, 0, got 2", good.planes(2, 1, plane));
  good.planes(0, 1, plane);
  good.planes(0, 1, plane);  // from the start again
}

// 257 planes of 1024 x 1024 bytes; but for a few they are a hole in the file.
TEST(Planes, AreHowLargeFilesAreSetUp) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("large.raw", "");
  constexpr Dims kLarge{1024, 1024, 257}, kLess{1024, 1024, 256};
  std::filesystem::resize_file(file, voxels_of(kLarge));
  const auto set_up_of = [&](const Dims& dims, bool in_planes) {
    Scene scene;
    scene.volume = source_of(file, RawLayout{.dims = dims});
    scene.volume.in_planes = in_planes;
    return set_up(scene, 1);
  };
  const SceneSetup large = set_up_of(kLarge, true);
  EXPECT_TRUE(large.volume.planes);
  EXPECT_TRUE(large.volume.samples.empty());
  const SceneSetup whole = set_up_of(kLarge, false);
  EXPECT_EQ(whole.volume.samples.size(), voxels_of(kLarge));
  EXPECT_EQ(large.voxel_hash, whole.voxel_hash);
  std::filesystem::resize_file(file, voxels_of(kLess));
  EXPECT_FALSE(set_up_of(kLess, true).volume.planes);
}

}  // namespace
}  // namespace gicube::scene
