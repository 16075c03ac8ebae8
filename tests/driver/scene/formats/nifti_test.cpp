#include <nifti2_io.h>

#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

nifti_1_header header_1(int datatype) {
  nifti_1_header header{};
  header.sizeof_hdr = 348;
  const short sizes[] = {3, 2, 3, 4, 1, 1, 1, 1};
  std::copy(std::begin(sizes), std::end(sizes), header.dim);
  header.datatype = static_cast<short>(datatype);
  header.pixdim[1] = 0.5f;
  header.pixdim[2] = -2;
  header.pixdim[3] = 1.5f;
  header.vox_offset = 352;
  std::memcpy(header.magic, "n+1", 4);
  return header;
}

nifti_2_header header_2(int datatype) {
  nifti_2_header header{};
  header.sizeof_hdr = 540;
  const std::int64_t sizes[] = {3, 2, 3, 4, 1, 1, 1, 1};
  std::copy(std::begin(sizes), std::end(sizes), header.dim);
  header.datatype = static_cast<short>(datatype);
  header.pixdim[1] = 1;
  header.pixdim[2] = 2;
  header.pixdim[3] = 3;
  header.vox_offset = 544;
  std::memcpy(header.magic, "n+2\0\r\n\032\n", 8);
  return header;
}

void swap(nifti_1_header& header) { nifti_swap_as_nifti1(&header); }
void swap(nifti_2_header& header) { nifti_swap_as_nifti2(&header); }

// Header, an empty extension list, samples.
template <typename Header>
std::string file_of(Header header, const std::string& samples, Order order = Order::kLittle) {
  if ((order == Order::kBig) != (std::endian::native == std::endian::big)) swap(header);
  return std::string(reinterpret_cast<const char*>(&header), sizeof(header)) + std::string(4, '\0') + samples;
}

template <typename Sample>
void expect_samples(const TemporaryFolder& folder, int datatype, SampleType type) {
  for (const Order order : {Order::kLittle, Order::kBig}) {
    const std::string samples = stored(ramp<Sample>(), order);
    const std::string one = file_of(header_1(datatype), samples, order);
    const std::string two = file_of(header_2(datatype), samples, order);
    for (const auto& file : {folder.write("1.nii", one), folder.write("1.nii.gz", gzip(one)),
                             folder.write("2.nii", two), folder.write("2.nii.gz", gzip(two))}) {
      const Volume volume = read_volume(file);
      EXPECT_EQ(volume.type, type) << file;
      EXPECT_EQ(volume.dims, kRampDims) << file;
      EXPECT_FALSE(volume.range.has_value()) << file;
      if (type == SampleType::kFloat32) {
        EXPECT_EQ(samples_of<float>(volume), as<float>(ramp<Sample>())) << file;
      } else {
        EXPECT_EQ(samples_of<Sample>(volume), ramp<Sample>()) << file;
      }
    }
  }
}

TEST(NiftiFile, ReadsEveryTypeInBothVersionsAndByteOrdersPlainAndGzipped) {
  const TemporaryFolder folder;
  expect_samples<std::uint8_t>(folder, NIFTI_TYPE_UINT8, SampleType::kUint8);
  expect_samples<std::uint16_t>(folder, NIFTI_TYPE_UINT16, SampleType::kUint16);
  expect_samples<std::int16_t>(folder, NIFTI_TYPE_INT16, SampleType::kInt16);
  expect_samples<float>(folder, NIFTI_TYPE_FLOAT32, SampleType::kFloat32);
  expect_samples<std::int8_t>(folder, NIFTI_TYPE_INT8, SampleType::kFloat32);
  expect_samples<std::int32_t>(folder, NIFTI_TYPE_INT32, SampleType::kFloat32);
  expect_samples<std::uint32_t>(folder, NIFTI_TYPE_UINT32, SampleType::kFloat32);
  expect_samples<double>(folder, NIFTI_TYPE_FLOAT64, SampleType::kFloat32);
}

TEST(NiftiFile, TakesAbsoluteSpacing) {
  const TemporaryFolder folder;
  const std::string samples = stored(ramp<std::uint8_t>());
  EXPECT_EQ(read_volume(folder.write("1.nii", file_of(header_1(2), samples))).spacing, (Vec3{0.5, 2, 1.5}));
  EXPECT_EQ(read_volume(folder.write("2.nii", file_of(header_2(2), samples))).spacing, (Vec3{1, 2, 3}));
}

TEST(NiftiFile, SkipsExtensionsBeforeTheData) {
  const TemporaryFolder folder;
  auto header = header_1(NIFTI_TYPE_UINT8);
  header.vox_offset = 368;
  const std::string file = file_of(header, std::string(16, 'x') + stored(ramp<std::uint8_t>()));
  EXPECT_EQ(samples_of<std::uint8_t>(read_volume(folder.write("v.nii", file))), ramp<std::uint8_t>());
  EXPECT_EQ(samples_of<std::uint8_t>(read_volume(folder.write("v.nii.gz", gzip(file)))), ramp<std::uint8_t>());
}

TEST(NiftiFile, AppliesSlopeAndInterceptAndScalesTheRangeOfBytes) {
  const TemporaryFolder folder;
  auto header = header_1(NIFTI_TYPE_UINT8);
  header.scl_slope = -2;
  header.scl_inter = 10;
  const Volume volume = read_volume(folder.write("v.nii", file_of(header, stored(ramp<std::uint8_t>()))));
  EXPECT_EQ(volume.type, SampleType::kFloat32);
  EXPECT_EQ(samples_of<float>(volume)[3], 10.0f - 2 * 16);
  EXPECT_EQ(volume.range, (ValueRange{10 - 2 * 255, 10}));
}

TEST(NiftiFile, TakesASlopeOfZeroOrNaNAsUnscaled) {
  const TemporaryFolder folder;
  for (const float slope : {0.0f, std::nanf("")}) {
    auto header = header_1(NIFTI_TYPE_INT16);
    header.scl_slope = slope;
    header.scl_inter = 7;
    const Volume volume = read_volume(folder.write("v.nii", file_of(header, stored(ramp<std::int16_t>()))));
    EXPECT_EQ(samples_of<std::int16_t>(volume), ramp<std::int16_t>());
  }
}

TEST(NiftiFile, TakesTheFirstOfSeveralVolumesOrTheOneAskedFor) {
  const TemporaryFolder folder;
  auto header = header_1(NIFTI_TYPE_UINT8);
  header.dim[0] = 4;
  const std::string samples = stored(ramp<std::uint8_t>());
  EXPECT_EQ(read_volume(folder.write("v.nii", file_of(header, samples))).dims, kRampDims);
  header.dim[4] = 2;
  VolumeSource source;
  source.file = folder.write("v.nii", file_of(header, std::string(24, 'a') + std::string(24, 'b')));
  const Warnings warnings;
  EXPECT_EQ(read_volume(source).samples.front(), std::byte{'a'});
  EXPECT_THAT(warnings.texts, ElementsAre(HasSubstr("volume: expected a part, 1..2, got none; 1 is taken")));
  source.part = "2";
  EXPECT_EQ(read_volume(source).samples.back(), std::byte{'b'});
  EXPECT_EQ(bytes_in_planes(open_volume(source), 1).front(), std::byte{'b'});
  source.part = "3";
  EXPECT_THROW(read_volume(source), FileError);
}

template <typename Change>
std::string error_after(const TemporaryFolder& folder, Change change) {
  auto header = header_1(NIFTI_TYPE_UINT8);
  change(header);
  return read_error(folder.write("v.nii", file_of(header, stored(ramp<std::uint8_t>()))));
}

TEST(NiftiFile, ReadsPairsAndAnalyze) {
  const TemporaryFolder folder;
  const std::string samples = stored(ramp<std::uint8_t>());
  for (const char* magic : {"ni1", ""}) {
    auto header = header_1(NIFTI_TYPE_UINT8);
    std::memset(header.magic, 0, 4);
    std::memcpy(header.magic, magic, std::strlen(magic));
    header.vox_offset = 2;
    const std::string start = file_of(header, "").substr(0, 348);
    for (const bool packed : {false, true}) {
      const TemporaryFolder pair;
      const auto head = pair.write(packed ? "v.hdr.gz" : "v.hdr", packed ? gzip(start) : start);
      const auto image = pair.write(packed ? "v.img.gz" : "v.img", packed ? gzip("xx" + samples) : "xx" + samples);
      for (const auto& file : {head, image})
        EXPECT_EQ(samples_of<std::uint8_t>(read_volume(file)), ramp<std::uint8_t>());
    }
  }
  const RawLayout raw{.dims = kRampDims};  // many programs call raw samples so
  EXPECT_EQ(samples_of<std::uint8_t>(read_volume(folder.write("raw.img", samples), raw)), ramp<std::uint8_t>());
}

TEST(NiftiFile, HasColours) {
  const TemporaryFolder folder;
  auto header = header_1(NIFTI_TYPE_RGB24);
  std::string bytes(72, '\0');
  bytes[3] = 10, bytes[4] = 20, bytes[5] = 30;
  const Volume volume = read_volume(folder.write("v.nii", file_of(header, bytes)));
  EXPECT_EQ(volume.colours.size(), 72u);
  EXPECT_EQ(volume.colours[4], 20);
  EXPECT_EQ(volume.samples[1], std::byte{19});  // luma
}

TEST(NiftiFile, RefusesSpacingThatIsNone) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_after(folder, [](auto& header) { header.pixdim[3] = 0; }),
              HasSubstr("v.nii: spacing: expected three finite numbers, none of them 0, got 0.5 -2 0"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.pixdim[1] = std::nanf(""); }), HasSubstr("got nan -2 1.5"));
}

TEST(NiftiFile, RefusesABadDataOffset) {
  const TemporaryFolder folder;
  for (const float offset : {0.0f, 351.0f, -1.0f, 352.5f, std::nanf(""), HUGE_VALF}) {
    EXPECT_THAT(error_after(folder, [&](auto& header) { header.vox_offset = offset; }), HasSubstr("vox_offset"))
        << offset;
  }
  EXPECT_THAT(error_after(folder, [](auto& header) { header.vox_offset = 1e9f; }), HasSubstr("truncated"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.vox_offset = 353; }), HasSubstr("got 23 (truncated"));
}

TEST(NiftiFile, RefusesSizesThatTheFileCannotHold) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_after(folder, [](auto& header) { header.dim[1] = -2; }), HasSubstr("-2 x 3 x 4"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.dim[2] = 0; }), HasSubstr("2 x 0 x 4"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.dim[3] = 4096; }),
              HasSubstr("expected 24576 bytes, got 24"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.dim[0] = 2; }), HasSubstr("dim[0]"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.dim[0] = 300; }), HasSubstr("dim[0]"));
  auto header = header_2(NIFTI_TYPE_UINT8);
  header.dim[1] = std::int64_t{1} << 40;
  EXPECT_THAT(read_error(folder.write("v.nii", file_of(header, "x"))), HasSubstr("1099511627776 x 3 x 4"));
}

TEST(NiftiFile, RefusesWhatItCannotRead) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_after(folder, [](auto& header) { header.datatype = NIFTI_TYPE_COMPLEX64; }),
              HasSubstr("COMPLEX64"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.datatype = 12345; }),
              AllOf(HasSubstr("datatype"), HasSubstr("12345")));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.magic[1] = 'x'; }), HasSubstr("ni1"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.magic[1] = 'i'; }),
              HasSubstr("v.img: file: expected a file"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.sizeof_hdr = 1; }), HasSubstr("sizeof_hdr"));
  EXPECT_THAT(error_after(folder, [](auto& header) { header.scl_slope = HUGE_VALF; }), HasSubstr("scl_slope"));
  EXPECT_THAT(read_error(folder.write("v.nii", "short")), HasSubstr("sizeof_hdr"));
}

TEST(NiftiFile, RefusesADamagedOrTruncatedGzipStream) {
  const TemporaryFolder folder;
  std::string bytes = gzip(file_of(header_1(NIFTI_TYPE_UINT8), stored(ramp<std::uint8_t>())));
  EXPECT_THAT(read_error(folder.write("t.nii.gz", bytes.substr(0, bytes.size() / 2))), HasSubstr("truncated"));
  EXPECT_THAT(read_error(folder.write("t.nii.gz", bytes.substr(0, bytes.size() - 3))), HasSubstr("truncated"));
  bytes[bytes.size() - 7] ^= 1;
  EXPECT_THAT(read_error(folder.write("d.nii.gz", bytes)), HasSubstr("compressed data"));
}

TEST(NiftiFile, ReadsAGzipFileOfSeveralStreams) {
  const TemporaryFolder folder;
  const std::string bytes = file_of(header_1(NIFTI_TYPE_UINT8), stored(ramp<std::uint8_t>()));
  const Volume volume = read_volume(folder.write("v.nii.gz", gzip(bytes.substr(0, 100)) + gzip(bytes.substr(100))));
  EXPECT_EQ(samples_of<std::uint8_t>(volume), ramp<std::uint8_t>());
}

}  // namespace
}  // namespace gicube::scene
