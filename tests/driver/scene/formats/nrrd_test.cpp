#include <sys/resource.h>

#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

std::string header(const std::string& type, const std::string& rest, const std::string& sizes = "2 3 4") {
  return "NRRD0004\n# a comment\ntype: " + type + "\ndimension: 3\nsizes: " + sizes + "\n" + rest;
}

template <typename Sample>
Volume read_attached(const TemporaryFolder& folder, const std::string& type, Order order, const std::string& encoding) {
  const std::string bytes = stored(ramp<Sample>(), order);
  const std::string endian = order == Order::kBig ? "endian: big\n" : "endian: little\n";
  return read_volume(folder.write("volume.nrrd", header(type, endian + "encoding: " + encoding + "\n\n") +
                                                     (encoding == "gzip" ? gzip(bytes) : bytes)));
}

TEST(NrrdFile, ReadsEveryTypeInBothByteOrdersRawAndGzipped) {
  const TemporaryFolder folder;
  for (const Order order : {Order::kLittle, Order::kBig}) {
    for (const std::string encoding : {"raw", "gzip"}) {
      SCOPED_TRACE(encoding + (order == Order::kBig ? " big" : " little"));
      const Volume u8 = read_attached<std::uint8_t>(folder, "uchar", order, encoding);
      EXPECT_EQ(u8.type, SampleType::kUint8);
      EXPECT_EQ(u8.dims, kRampDims);
      EXPECT_EQ(samples_of<std::uint8_t>(u8), ramp<std::uint8_t>());
      const Volume u16 = read_attached<std::uint16_t>(folder, "uint16", order, encoding);
      EXPECT_EQ(u16.type, SampleType::kUint16);
      EXPECT_EQ(samples_of<std::uint16_t>(u16), ramp<std::uint16_t>());
      const Volume i16 = read_attached<std::int16_t>(folder, "short", order, encoding);
      EXPECT_EQ(i16.type, SampleType::kInt16);
      EXPECT_EQ(samples_of<std::int16_t>(i16), ramp<std::int16_t>());
      const Volume f32 = read_attached<float>(folder, "float", order, encoding);
      EXPECT_EQ(f32.type, SampleType::kFloat32);
      EXPECT_EQ(samples_of<float>(f32), ramp<float>());
    }
  }
}

template <typename Sample>
void expect_floats(const TemporaryFolder& folder, const std::string& type) {
  for (const Order order : {Order::kLittle, Order::kBig}) {
    const Volume volume = read_attached<Sample>(folder, type, order, "raw");
    EXPECT_EQ(volume.type, SampleType::kFloat32) << type;
    EXPECT_EQ(samples_of<float>(volume), as<float>(ramp<Sample>())) << type;
  }
}

TEST(NrrdFile, ConvertsTypesThatTheDriverDoesNotTakeToFloats) {
  const TemporaryFolder folder;
  expect_floats<std::int8_t>(folder, "int8");
  expect_floats<std::int32_t>(folder, "int");
  expect_floats<std::uint32_t>(folder, "uint");
  expect_floats<std::int64_t>(folder, "int64");
  expect_floats<std::uint64_t>(folder, "uint64");
  expect_floats<double>(folder, "double");
}

TEST(NrrdFile, KeepsNegativeSamplesNegative) {
  const TemporaryFolder folder;
  std::vector<std::int16_t> samples(24, -1000);
  const auto file =
      folder.write("v.nrrd", header("short", "endian: big\nencoding: raw\n\n") + stored(samples, Order::kBig));
  EXPECT_EQ(samples_of<std::int16_t>(read_volume(file)), samples);
}

TEST(NrrdFile, ReadsDetachedDataBesideTheHeader) {
  const TemporaryFolder folder;
  folder.write("data one.raw", stored(ramp<std::uint16_t>()));
  folder.write("data.gz", gzip(stored(ramp<std::uint16_t>())));
  const std::string start = header("ushort", "endian: little\n");
  // With and without the blank line at the header's end, and with carriage returns.
  const auto raw = folder.write("raw.nhdr", start + "encoding: raw\ndata file: data one.raw\n");
  const auto gz = folder.write("gz.nhdr", start + "encoding: gzip\r\ndatafile: ./data.gz\r\n\r\n");
  EXPECT_EQ(samples_of<std::uint16_t>(read_volume(raw)), ramp<std::uint16_t>());
  EXPECT_EQ(samples_of<std::uint16_t>(read_volume(gz)), ramp<std::uint16_t>());
}

TEST(NrrdFile, SkipsLinesAndBytesBeforeTheData) {
  const TemporaryFolder folder;
  const std::string bytes = stored(ramp<std::uint8_t>());
  folder.write("skip.raw", "one\ntwo\nxyz" + bytes);
  folder.write("skip.gz", "one\ntwo\n" + gzip("xyz" + bytes));
  folder.write("end.raw", "anything" + bytes);
  const std::string skips = "line skip: 2\nbyte skip: 3\n";
  const auto raw = folder.write("raw.nhdr", header("uchar", skips + "encoding: raw\ndata file: skip.raw\n"));
  const auto gz = folder.write("gz.nhdr", header("uchar", skips + "encoding: gzip\ndata file: skip.gz\n"));
  const auto end = folder.write("end.nhdr", header("uchar", "byte skip: -1\nencoding: raw\ndata file: end.raw\n"));
  for (const auto& file : {raw, gz, end}) EXPECT_EQ(samples_of<std::uint8_t>(read_volume(file)), ramp<std::uint8_t>());
}

TEST(NrrdFile, ReadsNumbersAndHexadecimalDigits) {
  const TemporaryFolder folder;
  std::string numbers, digits;
  for (const std::int16_t sample : ramp<std::int16_t>())
    numbers += std::to_string(-sample) + (sample % 3 == 0 ? "\n" : ", ");
  for (const char byte : stored(ramp<std::uint16_t>(), Order::kBig)) {
    digits += "0123456789abcdef"[(byte >> 4) & 15];
    digits += "0123456789ABCDEF"[byte & 15];
    digits += byte % 5 == 0 ? "\n" : "";
  }
  const Volume text = read_volume(folder.write("a.nrrd", header("short", "encoding: ascii\n\n") + numbers));
  const Volume hex = read_volume(folder.write("h.nrrd", header("ushort", "endian: big\nencoding: hex\n\n") + digits));
  auto negative = ramp<std::int16_t>();
  for (auto& sample : negative) sample = static_cast<std::int16_t>(-sample);
  EXPECT_EQ(samples_of<std::int16_t>(text), negative);
  EXPECT_EQ(samples_of<std::uint16_t>(hex), ramp<std::uint16_t>());
}

TEST(NrrdFile, TakesSpacingFromSpacingsOrSpaceDirections) {
  const TemporaryFolder folder;
  const std::string data = "encoding: raw\n\n" + stored(ramp<std::uint8_t>());
  const Volume plain = read_volume(folder.write("p.nrrd", header("uchar", "spacings: 0.5 3 -2\n" + data)));
  EXPECT_EQ(plain.spacing, (Vec3{0.5, 3, 2}));
  const std::string space = "space: left-posterior-superior\nspace directions: (-3,0,0) (0,3,4) (0,0,0.25)\n";
  EXPECT_EQ(read_volume(folder.write("s.nrrd", header("uchar", space + data))).spacing, (Vec3{3, 5, 0.25}));
  EXPECT_EQ(read_volume(folder.write("n.nrrd", header("uchar", data))).spacing, (Vec3{1, 1, 1}));
}

TEST(NrrdFile, RefusesSpacingThatIsNone) {
  const TemporaryFolder folder;
  const std::string data = "encoding: raw\n\n" + stored(ramp<std::uint8_t>());
  const auto error = [&](const std::string& line) {
    return read_error(folder.write("v.nrrd", header("uchar", line + "\n" + data)));
  };
  EXPECT_THAT(error("spacings: 0.5 nan 2"),
              HasSubstr("spacing: expected three finite numbers, none of them 0, got 0.5 nan 2"));
  EXPECT_THAT(error("spacings: nan nan nan"), HasSubstr("got nan nan nan"));
  const std::string space = "space: left-posterior-superior\nspace directions: ";
  EXPECT_THAT(error(space + "none (0,3,4) (0,0,1)"), HasSubstr("three axes of space"));
}

// teem compares each note with all before it, which takes it several times as long for so many.
TEST(NrrdFile, ReadsAHeaderOfAHundredAndFiftyThousandNotesWithinTenSecondsOfProcessorTime) {
  const TemporaryFolder folder;
  std::string notes;
  for (int i = 0; i < 150'000; ++i) {
    for (int rest = i + 64 * 64 * 64; rest > 1; rest /= 64) notes += static_cast<char>('0' + rest % 64);
    notes += i % 2 == 0 ? ":=\n" : "::=\n";
  }
  const auto file = folder.write("v.nrrd", header("uchar", notes + "encoding: raw\n\n") + stored(ramp<std::uint8_t>()));
  const auto read_within_limit = [&file] {
    const rlimit limit{10, 10};
    ::setrlimit(RLIMIT_CPU, &limit);
    std::_Exit(read_volume(file).dims == kRampDims ? 0 : 1);
  };
  EXPECT_EXIT(read_within_limit(), testing::ExitedWithCode(0), "");
}

TEST(NrrdFile, NamesNoDataOutsideOfItsFolderUnlessItMay) {
  const TemporaryFolder folder;
  folder.write("v.raw", stored(ramp<std::uint8_t>()));
  std::filesystem::create_directory(folder.path() / "below");
  VolumeSource source;
  source.file = folder.write("below/v.nhdr", header("uchar", "encoding: raw\ndata file: ../v.raw\n"));
  EXPECT_THAT(read_error(source.file), HasSubstr("data file: expected a file in this file's folder or below"));
  source.allow_outside = true;
  EXPECT_EQ(samples_of<std::uint8_t>(read_volume(source)), ramp<std::uint8_t>());
}

TEST(NrrdFile, SaysThatItsDataAreMissingWhereverThatIs) {
  const TemporaryFolder folder;
  const auto file = folder.write("v.nhdr", header("uchar", "encoding: raw\ndata file: gone.raw\n"));
  EXPECT_THAT(read_error(file), HasSubstr("gone.raw: file: expected a file, got nothing there"));
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  EXPECT_EQ(read_error("v.nhdr"), "gone.raw: file: expected a file, got nothing there");
  EXPECT_EQ(read_error("./v.nhdr"), "./gone.raw: file: expected a file, got nothing there");
  std::filesystem::current_path(before);
}

// Whole and in planes, and once for all times that the planes are read.
std::vector<std::string> warnings_of(const std::filesystem::path& file) {
  const Warnings given;
  EXPECT_EQ(read_volume(file).dims, kRampDims);
  VolumeSource source;
  source.file = file;
  const std::vector<std::string> whole = given.texts;
  const Volume opened = open_volume(source);
  for (const int planes : {1, 4}) bytes_in_planes(opened, planes);
  EXPECT_EQ(given.texts.size(), 2 * whole.size());
  return whole;
}

TEST(NrrdFile, WarnsOfDetachedDataThatAreLongerThanItSays) {
  const TemporaryFolder folder;
  const std::string floats = stored(ramp<float>());
  const auto data = folder.write("v.raw", floats), packed = folder.write("v.gz", gzip(floats));
  const auto with = [&](const std::string& type, const std::string& rest) {
    return warnings_of(folder.write("v.nhdr", header(type, "endian: little\n" + rest)));
  };
  const std::string why = " (the rest is ignored, or the header is wrong)";
  EXPECT_THAT(with("short", "encoding: raw\ndata file: v.raw\n"),
              ElementsAre(data.string() + ": data: expected 48 bytes by the header, got 96" + why));
  EXPECT_THAT(with("int", "encoding: raw\ndata file: v.raw\n"), IsEmpty());
  EXPECT_THAT(with("short", "encoding: raw\nbyte skip: 4\ndata file: v.raw\n"),
              ElementsAre(data.string() + ": data: expected 48 bytes by the header, got 92" + why));
  EXPECT_THAT(with("short", "encoding: raw\nbyte skip: -1\ndata file: v.raw\n"), IsEmpty());
  EXPECT_THAT(with("short", "encoding: gzip\ndata file: v.gz\n"),
              ElementsAre(packed.string() + ": data: expected 48 bytes by the header, got more" + why));
  EXPECT_THAT(with("float", "encoding: gzip\ndata file: v.gz\n"), IsEmpty());
}

TEST(NrrdFile, DropsFurtherAxesOfOneSample) {
  const TemporaryFolder folder;
  const std::string start =
      "NRRD0004\ntype: uchar\ndimension: 5\nsizes: 1 2 3 1 4\nspacings: nan 5 6 nan 7\nencoding: raw\n\n";
  const Volume volume = read_volume(folder.write("v.nrrd", start + stored(ramp<std::uint8_t>())));
  EXPECT_EQ(volume.dims, kRampDims);
  EXPECT_EQ(volume.spacing, (Vec3{5, 6, 7}));
}

TEST(NrrdFile, IgnoresCommentsAndKeyValuePairs) {
  const TemporaryFolder folder;
  const std::string more = "#\n# endian: strange\nkey:=sizes: 9 9 9\nencoding: raw\n\n";
  EXPECT_EQ(read_volume(folder.write("v.nrrd", header("uchar", more) + stored(ramp<std::uint8_t>()))).dims, kRampDims);
}

TEST(NrrdFile, IsKnownByItsContentsWhateverItsName) {
  const TemporaryFolder folder;
  const auto file = folder.write("volume.data", header("uchar", "encoding: raw\n\n") + stored(ramp<std::uint8_t>()));
  EXPECT_EQ(read_volume(file).dims, kRampDims);
}

TEST(NrrdFile, RefusesAHeaderThatLiesAboutTheSize) {
  const TemporaryFolder folder;
  const std::string data = "encoding: raw\n\n" + stored(ramp<std::uint8_t>());
  const auto error = [&](const std::string& sizes, const std::string& rest) {
    return read_error(folder.write("v.nrrd", header("uchar", rest, sizes)));
  };
  EXPECT_THAT(error("1099511627776 1 1", data), AllOf(HasSubstr("v.nrrd: sizes"), HasSubstr("1..4096")));
  EXPECT_THAT(error("1099511627776 1099511627776 1099511627776", data), HasSubstr("header"));
  EXPECT_THAT(error("4096 4096 4096", data),
              AllOf(HasSubstr("size"), HasSubstr("8589934592"), HasSubstr("68719476736")));
  EXPECT_THAT(error("2000 2000 2000", data), AllOf(HasSubstr("expected 8000000000 bytes"), HasSubstr("got 24")));
  EXPECT_THAT(error("2 3 5", data), AllOf(HasSubstr("expected 30 bytes"), HasSubstr("got 24 (truncated")));
  EXPECT_THAT(error("-2 3 4", data), AllOf(HasSubstr("header"), HasSubstr("-2 3 4")));
  EXPECT_THAT(error("0 3 4", data), AllOf(HasSubstr("header"), HasSubstr("zero")));
  EXPECT_THAT(error("2000 2000 2000", "encoding: gzip\n\n" + gzip(stored(ramp<std::uint8_t>()))),
              HasSubstr("expected 8000000000 bytes, got a compressed stream for at most"));
  EXPECT_THAT(error("2 3 5", "encoding: gzip\n\n" + gzip(stored(ramp<std::uint8_t>()))),
              HasSubstr("expected 30 bytes, got 24"));
  EXPECT_THAT(error("2000 2000 2000", "encoding: ascii\n\n1 2 3"), HasSubstr("at least 15999999999 characters"));
  EXPECT_THAT(error("2000 2000 2000", "encoding: hex\n\n0102"), HasSubstr("at least 16000000000 characters"));
}

TEST(NrrdFile, IgnoresWhatFollowsTheData) {
  const TemporaryFolder folder;
  const std::string bytes = stored(ramp<std::uint8_t>()) + "more";
  EXPECT_EQ(read_volume(folder.write("r.nrrd", header("uchar", "encoding: raw\n\n") + bytes)).dims, kRampDims);
  EXPECT_EQ(read_volume(folder.write("g.nrrd", header("uchar", "encoding: gzip\n\n") + gzip(bytes))).dims, kRampDims);
}

TEST(NrrdFile, RefusesADamagedOrTruncatedGzipStream) {
  const TemporaryFolder folder;
  const std::string start = header("uchar", "encoding: gzip\n\n");
  std::string damaged = gzip(stored(ramp<std::uint8_t>()));
  const std::string truncated = damaged.substr(0, damaged.size() - 12);
  const std::string headless = "no gzip at all";
  damaged[damaged.size() - 6] ^= 1;  // in the checksum
  EXPECT_THAT(read_error(folder.write("d.nrrd", start + damaged)), HasSubstr("compressed data"));
  EXPECT_THAT(read_error(folder.write("t.nrrd", start + truncated)), HasSubstr("truncated"));
  EXPECT_THAT(read_error(folder.write("h.nrrd", start + headless)), HasSubstr("incorrect header check"));
}

TEST(NrrdFile, RefusesWhatItCannotRead) {
  const TemporaryFolder folder;
  const std::string raw = "encoding: raw\n\n" + stored(ramp<std::uint8_t>());
  const auto error = [&](const std::string& text) { return read_error(folder.write("v.nrrd", text)); };
  EXPECT_THAT(error(header("strange", raw)), HasSubstr("strange"));
  EXPECT_THAT(error(header("short", raw)), HasSubstr("endian"));
  EXPECT_THAT(error(header("uchar", "encoding: bzip2\n\nxx" + std::string(99, 'x'))), HasSubstr("compressed data"));
  EXPECT_THAT(error(header("uchar", "encoding: raw\ndata file: gone.raw\n")),
              HasSubstr("gone.raw: file: expected a file"));
  EXPECT_THAT(error(header("uchar", "encoding: raw\ndata file: s%03d.raw 1 4 1\n")), HasSubstr("s001.raw"));
  for (const char* const range : {"-9223372036854775808 9223372036854775807 3", "-2147483648 2147483647 1"})
    EXPECT_THAT(error(header("uchar", std::string("encoding: raw\ndata file: s%d.raw ") + range + "\n")),
                HasSubstr("expected a name with one %d"));
  EXPECT_THAT(error(header("uchar", "encoding: raw\ndata file: LIST\na.raw\nb.raw\n")), HasSubstr("a.raw"));
  EXPECT_THAT(error("NRRD0004\ntype: uchar\ndimension: 2\nsizes: 2 3\nencoding: raw\n\n123456"),
              HasSubstr("three axes"));
  EXPECT_THAT(error("NRRD0004\ntype: block\ndimension: 3\nsizes: 2 3 4\nblock size: 1\nendian: big\n" + raw),
              HasSubstr("type"));
  EXPECT_THAT(error("not an nrrd"), HasSubstr("magic"));
  EXPECT_THAT(error(header("uchar", "s\n" + raw)), HasSubstr("got \"s\""));
  EXPECT_THAT(error(header("uchar", std::string("# \0\n", 4) + raw)), HasSubstr("zero byte"));
  EXPECT_THAT(error("NRRD0004\ntype: uchar\ndimension: 3\n" + raw), HasSubstr("sizes: expected a line of the header"));
  EXPECT_THAT(error("NRRD0009\ntype: uchar\ndimension: 3\nsizes: 2 3 4\n" + raw), HasSubstr("got \"NRRD0009\""));
  EXPECT_THAT(error(""), HasSubstr("magic"));
  EXPECT_THAT(error("NRRD0004\n" + std::string(2 << 20, 'x')), HasSubstr("header"));
  EXPECT_THAT(
      error(header("uchar", "encoding: ascii\n\n1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 x")),
      AllOf(HasSubstr("sample 23"), HasSubstr("\"x\"")));
  EXPECT_THAT(error(header("uchar", "encoding: ascii\n\n256" + std::string(60, ' '))), HasSubstr("\"256\""));
  EXPECT_THAT(error(header("uchar", "encoding: hex\n\n0g" + std::string(60, '0'))), HasSubstr("digit 1"));
}

TEST(NrrdFile, RefusesSamplesThatNoFloatHolds) {
  const TemporaryFolder folder;
  std::vector<double> samples = ramp<double>();
  const auto error = [&] {
    return read_error(folder.write("v.nrrd", header("double", "endian: little\nencoding: raw\n\n") + stored(samples)));
  };
  samples[5] = 1e300;
  EXPECT_THAT(error(), AllOf(HasSubstr("sample 5"), HasSubstr("1e+300")));
  samples[5] = std::nan("");
  EXPECT_THAT(error(), AllOf(HasSubstr("sample 5"), HasSubstr("nan")));
}

TEST(NrrdFile, LeavesFloatSamplesThatAreNotNumbersToTheDriver) {
  const TemporaryFolder folder;
  std::vector<float> samples = ramp<float>();
  samples[5] = std::numeric_limits<float>::quiet_NaN();
  const auto file = folder.write("v.nrrd", header("float", "endian: little\nencoding: raw\n\n") + stored(samples));
  EXPECT_TRUE(std::isnan(samples_of<float>(read_volume(file))[5]));
}

}  // namespace
}  // namespace gicube::scene
