#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

TEST(RawFile, ReadsEveryTypeInBothByteOrders) {
  const TemporaryFolder folder;
  for (const Order order : {Order::kLittle, Order::kBig}) {
    const auto read = [&](SampleType type, const std::string& bytes) {
      const RawLayout layout{kRampDims, type, {1, 2, -3}, order == Order::kBig, 3};
      return read_volume(folder.write("v.raw", "xyz" + bytes), layout);
    };
    const Volume u8 = read(SampleType::kUint8, stored(ramp<std::uint8_t>(), order));
    EXPECT_EQ(samples_of<std::uint8_t>(u8), ramp<std::uint8_t>());
    EXPECT_EQ(u8.dims, kRampDims);
    EXPECT_EQ(u8.spacing, (Vec3{1, 2, 3}));
    const Volume u12 = read(SampleType::kUint12, stored(ramp<std::uint16_t>(), order));
    EXPECT_EQ(u12.type, SampleType::kUint12);
    EXPECT_EQ(samples_of<std::uint16_t>(u12), ramp<std::uint16_t>());
    EXPECT_EQ(samples_of<std::uint16_t>(read(SampleType::kUint16, stored(ramp<std::uint16_t>(), order))),
              ramp<std::uint16_t>());
    EXPECT_EQ(samples_of<std::int16_t>(read(SampleType::kInt16, stored(ramp<std::int16_t>(), order))),
              ramp<std::int16_t>());
    EXPECT_EQ(samples_of<float>(read(SampleType::kFloat32, stored(ramp<float>(), order))), ramp<float>());
  }
}

TEST(RawFile, ReadsGzippedSamples) {
  const TemporaryFolder folder;
  const RawLayout layout{kRampDims, SampleType::kUint16, {1, 1, 1}, false, 2};
  const Volume volume = read_volume(folder.write("v.raw.gz", gzip("xy" + stored(ramp<std::uint16_t>()))), layout);
  EXPECT_EQ(samples_of<std::uint16_t>(volume), ramp<std::uint16_t>());
  EXPECT_THAT(read_error(folder.write("v.raw.gz", gzip("xyz" + stored(ramp<std::uint16_t>()))), layout),
              HasSubstr("got more"));
}

TEST(RawFile, ReadsMoreThanOneChunkOfCompressedSamples) {
  const TemporaryFolder folder;
  std::vector<std::uint16_t> samples(256 * 256 * 48);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<std::uint16_t>(i * i >> 5);
  const RawLayout layout{{256, 256, 48}, SampleType::kUint16, {1, 1, 1}, false, 0};
  EXPECT_EQ(samples_of<std::uint16_t>(read_volume(folder.write("v.gz", gzip(stored(samples))), layout)), samples);
}

TEST(RawFile, MustHaveExactlyTheLayoutsSize) {
  const TemporaryFolder folder;
  const std::string bytes = stored(ramp<std::uint8_t>());
  const auto error = [&](const std::string& contents, RawLayout layout) {
    return read_error(folder.write("v.raw", contents), layout);
  };
  EXPECT_THAT(error(bytes, {.dims = {2, 3, 5}}), HasSubstr("v.raw: data: expected 30 bytes, got 24 (truncated"));
  EXPECT_THAT(error(bytes + "x", {.dims = kRampDims}), HasSubstr("expected 24 bytes, got more"));
  EXPECT_THAT(error(bytes, {.dims = kRampDims, .skip_bytes = 25}), HasSubstr("truncated"));
  EXPECT_THAT(error(bytes, {.dims = kRampDims, .skip_bytes = ~std::uint64_t{0}}), HasSubstr("truncated"));
}

TEST(RawFile, RefusesDimensionsOutOfRange) {
  const TemporaryFolder folder;
  const auto file = folder.write("v.raw", "x");
  for (const Dims dims : {Dims{0, 3, 4}, Dims{2, -3, 4}, Dims{2, 3, 4097}}) {
    EXPECT_THAT(read_error(file, RawLayout{.dims = dims}), AllOf(HasSubstr("dims"), HasSubstr("1..4096")));
  }
  const RawLayout large{.dims = {4096, 4096, 256}, .type = SampleType::kFloat32};
  EXPECT_THAT(read_error(file, large), HasSubstr("at most 8589934592 bytes of samples, got 17179869184"));
}

TEST(RawFile, RefusesTwelveBitSamplesAbove4095) {
  const TemporaryFolder folder;
  auto samples = ramp<std::uint16_t>();
  samples[7] = 4096;
  const RawLayout layout{.dims = kRampDims, .type = SampleType::kUint12};
  EXPECT_THAT(read_error(folder.write("v.raw", stored(samples)), layout),
              HasSubstr("sample 7: expected 0..4095, got 4096"));
}

TEST(RawFile, NeedsALayoutAndOtherFormatsNone) {
  const TemporaryFolder folder;
  EXPECT_THAT(read_error(folder.write("v.raw", stored(ramp<std::uint8_t>()))), HasSubstr("no layout"));
  EXPECT_THAT(read_error(folder.write("v.nrrd", "x"), RawLayout{.dims = kRampDims}),
              HasSubstr("layout: expected none"));
  EXPECT_THAT(read_error(folder.path(), RawLayout{.dims = kRampDims}), HasSubstr("layout: expected none"));
}

TEST(RawFile, MustBeThereAndBeAFile) {
  const TemporaryFolder folder;
  EXPECT_THAT(read_error(folder.path() / "gone.raw", RawLayout{.dims = kRampDims}), HasSubstr("nothing there"));
  EXPECT_THAT(read_error(folder.path() / "gone.nii"), HasSubstr("nothing there"));
  EXPECT_THAT(read_error(folder.path() / "gone"), HasSubstr("nothing there"));
  EXPECT_THAT(read_error("/dev/zero", RawLayout{.dims = kRampDims}), HasSubstr("a regular file"));
}

}  // namespace
}  // namespace gicube::scene
