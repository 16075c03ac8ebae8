#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

std::string header(const std::string& type, const std::string& rest, const std::string& sizes = "2 3 4") {
  return "ObjectType = Image\nNDims = 3\nDimSize = " + sizes + "\nElementType = " + type +
         "\nOffset = 1 2 3\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n" + rest;
}
const std::string kLocal = "ElementDataFile = LOCAL\n";

template <typename Sample>
void expect_kept(const TemporaryFolder& folder, const std::string& name, SampleType type) {
  for (const Order order : {Order::kLittle, Order::kBig}) {
    const std::string bytes = stored(ramp<Sample>(), order);
    const std::string msb = std::string("ElementByteOrderMSB = ") + (order == Order::kBig ? "True\n" : "False\n");
    const Volume plain = read_volume(folder.write("plain.mha", header(name, msb + kLocal) + bytes));
    const Volume packed =
        read_volume(folder.write("packed.mha", header(name, msb + "CompressedData = True\n" + kLocal) + zlib(bytes)));
    for (const Volume& volume : {plain, packed}) {
      EXPECT_EQ(volume.type, type) << name;
      EXPECT_EQ(volume.dims, kRampDims) << name;
      EXPECT_EQ(samples_of<Sample>(volume), ramp<Sample>()) << name;
    }
  }
}

TEST(MetaImageFile, ReadsEveryTypeInBothByteOrdersPlainAndCompressed) {
  const TemporaryFolder folder;
  expect_kept<std::uint8_t>(folder, "MET_UCHAR", SampleType::kUint8);
  expect_kept<std::uint16_t>(folder, "MET_USHORT", SampleType::kUint16);
  expect_kept<std::int16_t>(folder, "MET_SHORT", SampleType::kInt16);
  expect_kept<float>(folder, "MET_FLOAT", SampleType::kFloat32);
}

TEST(MetaImageFile, ConvertsOtherTypesToFloats) {
  const TemporaryFolder folder;
  const auto floats = [&](const std::string& type, const std::string& bytes) {
    const Volume volume =
        read_volume(folder.write("v.mha", header(type, "BinaryDataByteOrderMSB = True\n" + kLocal) + bytes));
    EXPECT_EQ(volume.type, SampleType::kFloat32);
    return samples_of<float>(volume);
  };
  EXPECT_EQ(floats("MET_CHAR", stored(ramp<std::int8_t>())), as<float>(ramp<std::int8_t>()));
  EXPECT_EQ(floats("MET_LONG", stored(ramp<std::int32_t>(), Order::kBig)), as<float>(ramp<std::int32_t>()));
  EXPECT_EQ(floats("MET_ULONG_LONG", stored(ramp<std::uint64_t>(), Order::kBig)), as<float>(ramp<std::uint64_t>()));
  EXPECT_EQ(floats("MET_DOUBLE", stored(ramp<double>(), Order::kBig)), as<float>(ramp<double>()));
}

TEST(MetaImageFile, ReadsDetachedDataBehindTheirHeader) {
  const TemporaryFolder folder;
  const std::string bytes = stored(ramp<std::uint16_t>());
  folder.write("v.raw", "12345" + bytes);
  folder.write("v.zraw", "12345" + zlib(bytes));
  const auto file = [&](const std::string& name, const std::string& rest) {
    return folder.write(name, header("MET_USHORT", rest));
  };
  const auto counted = file("a.mhd", "HeaderSize = 5\nElementDataFile = v.raw\n");
  const auto from_end = file("b.mhd", "HeaderSize = -1\nElementDataFile = v.raw");
  const auto packed = file("c.mhd", "HeaderSize = 5\r\nCompressedData = True\r\nElementDataFile = v.zraw\r\n");
  for (const auto& header_file : {counted, from_end, packed}) {
    EXPECT_EQ(samples_of<std::uint16_t>(read_volume(header_file)), ramp<std::uint16_t>()) << header_file;
  }
}

TEST(MetaImageFile, ReadsTextSamples) {
  const TemporaryFolder folder;
  std::string numbers;
  for (const int sample : ramp<int>()) numbers += std::to_string(sample) + ".5 ";
  const Volume volume =
      read_volume(folder.write("v.mha", header("MET_FLOAT", "BinaryData = False\n" + kLocal) + numbers));
  EXPECT_EQ(samples_of<float>(volume)[1], 158.5f);
}

TEST(MetaImageFile, TakesSpacingBeforeSizeAndOneForNone) {
  const TemporaryFolder folder;
  const std::string data = kLocal + stored(ramp<std::uint8_t>());
  const auto spacing = [&](const std::string& lines) {
    return read_volume(folder.write("v.mha", header("MET_UCHAR", lines + data))).spacing;
  };
  EXPECT_EQ(spacing("ElementSize = 9 9 9\nElementSpacing = 0.5 -2e0 3\n"), (Vec3{0.5, 2, 3}));
  EXPECT_EQ(spacing("ElementSize = 1 2 3\n"), (Vec3{1, 2, 3}));
  EXPECT_EQ(spacing(""), (Vec3{1, 1, 1}));
}

TEST(MetaImageFile, RefusesAHeaderThatLiesAboutTheSize) {
  const TemporaryFolder folder;
  const std::string bytes = stored(ramp<std::uint8_t>());
  const auto error = [&](const std::string& sizes, const std::string& rest) {
    return read_error(folder.write("v.mha", header("MET_UCHAR", rest, sizes)));
  };
  EXPECT_THAT(error("1099511627776 1 1", kLocal + bytes), AllOf(HasSubstr("DimSize"), HasSubstr("1099511627776")));
  EXPECT_THAT(error("-2 3 4", kLocal + bytes), AllOf(HasSubstr("DimSize"), HasSubstr("-2 x 3 x 4")));
  EXPECT_THAT(error("0 3 4", kLocal + bytes), HasSubstr("DimSize"));
  EXPECT_THAT(error("2 3", kLocal + bytes), HasSubstr("NDims = 3"));
  EXPECT_THAT(error("99999999999999999999 3 4", kLocal + bytes), HasSubstr("DimSize"));
  EXPECT_THAT(error("2000 2000 2000", kLocal + bytes), HasSubstr("expected 8000000000 bytes, got 24"));
  EXPECT_THAT(error("2 3 5", "CompressedData = True\n" + kLocal + zlib(bytes)), HasSubstr("expected 30 bytes, got 24"));
  EXPECT_THAT(error("2 3 4", "CompressedData = True\n" + kLocal + zlib(bytes).substr(0, 10)), HasSubstr("truncated"));
  EXPECT_THAT(error("2 3 4", "CompressedData = True\n" + kLocal + bytes), HasSubstr("compressed data"));
}

TEST(MetaImageFile, RefusesWhatItCannotRead) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& text) { return read_error(folder.write("v.mhd", text)); };
  const std::string data = kLocal + stored(ramp<std::uint8_t>());
  EXPECT_THAT(error(header("MET_STRANGE", data)), AllOf(HasSubstr("ElementType"), HasSubstr("MET_STRANGE")));
  EXPECT_THAT(error(header("MET_UCHAR", "ElementNumberOfChannels = 3\n" + data)), HasSubstr("expected 72 bytes"));
  EXPECT_THAT(error(header("MET_UCHAR", "ElementNumberOfChannels = 2\n" + data)),
              HasSubstr("part: expected a channel, 1..2"));
  EXPECT_THAT(error(header("MET_UCHAR", "TransformMatrix = 1 0 0\n" + data)), HasSubstr("TransformMatrix"));
  EXPECT_THAT(error(header("MET_UCHAR", "ElementSpacing = 1 2\n" + data)), HasSubstr("ElementSpacing"));
  EXPECT_THAT(error(header("MET_UCHAR", "ElementSpacing = a b c\n" + data)), HasSubstr("ElementSpacing"));
  EXPECT_THAT(error(header("MET_UCHAR", "CompressedData = maybe\n" + data)), HasSubstr("CompressedData"));
  EXPECT_THAT(error(header("MET_UCHAR", "HeaderSize = 5000\nElementDataFile = v.mhd\n")),
              HasSubstr("begin at byte 5000"));
  EXPECT_THAT(error(header("MET_UCHAR", "HeaderSize = -7\nElementDataFile = v.mhd\n")), HasSubstr("HeaderSize"));
  EXPECT_THAT(error(header("MET_UCHAR", "ElementDataFile = gone.raw\n")), HasSubstr("gone.raw: file: expected a file"));
  EXPECT_THAT(error(header("MET_UCHAR", "ElementDataFile = LIST\na.raw\n")), HasSubstr("a.raw"));
  EXPECT_THAT(error(header("MET_UCHAR", "ElementDataFile = s%03d.raw 1 4 1\n")), HasSubstr("s001.raw"));
  EXPECT_THAT(error(header("MET_UCHAR", "")), AllOf(HasSubstr("ElementDataFile"), HasSubstr("none")));
  EXPECT_THAT(error("ObjectType = Tube\nElementDataFile = LOCAL\n"), HasSubstr("ObjectType"));
  EXPECT_THAT(error("ObjectType = Image\nnonsense\n"), HasSubstr("nonsense"));
  EXPECT_THAT(error("something else"), HasSubstr("header"));
  EXPECT_THAT(error(""), HasSubstr("header"));
}

TEST(MetaImageFile, SkipsTheBytesOfHeaderSizeInItsOwnFileToo) {
  const TemporaryFolder folder;
  const std::string bytes = stored(ramp<std::uint16_t>());
  const auto samples = [&](const std::string& size, const std::string& rest) {
    std::string text = header("MET_USHORT", "HeaderSize = " + size + "\n" + kLocal);
    text.resize(std::max<std::size_t>(text.size(), 256), '\n');
    return samples_of<std::uint16_t>(read_volume(folder.write("v.mha", text + rest)));
  };
  EXPECT_EQ(samples("256", bytes), ramp<std::uint16_t>());
  EXPECT_EQ(samples("256", bytes + "more"), ramp<std::uint16_t>());
  EXPECT_EQ(samples("261", "12345" + bytes), ramp<std::uint16_t>());
  EXPECT_EQ(samples("-1", "12345" + bytes), ramp<std::uint16_t>());
  const auto error = [&](const std::string& size) {
    return read_error(folder.write("v.mha", header("MET_USHORT", "HeaderSize = " + size + "\n" + kLocal) + bytes));
  };
  EXPECT_THAT(error("20"), HasSubstr("HeaderSize: expected 0, "));  // within the header's own lines
  EXPECT_THAT(error("5000"), HasSubstr("begin at byte 5000"));
  EXPECT_THAT(error("-7"), HasSubstr("HeaderSize"));
}

TEST(MetaImageFile, MayBeginWithAnyKeyIfItsNameSaysWhatItIs) {
  const TemporaryFolder folder;
  const std::string rest = header("MET_UCHAR", kLocal) + stored(ramp<std::uint8_t>());
  for (const char* first : {"Comment = \"a = b\"\n", "DimSize = 2 3 4\n", "  TransformMatrix = 1 0 0 0 1 0 0 0 1\r\n"})
    EXPECT_EQ(samples_of<std::uint8_t>(read_volume(folder.write("v.mha", first + rest))), ramp<std::uint8_t>());
  EXPECT_THAT(read_error(folder.write("v.data", "Comment = x\n" + rest)), HasSubstr("an unknown format"));
}

TEST(MetaImageFile, WarnsOfDetachedDataThatAreLongerThanItSays) {
  const TemporaryFolder folder;
  const auto data = folder.write("v.raw", stored(ramp<std::uint8_t>()) + "more");
  const Warnings given;
  read_volume(folder.write("v.mhd", header("MET_UCHAR", "ElementDataFile = v.raw\n")));
  EXPECT_THAT(given.texts, ElementsAre(data.string() + ": data: expected 24 bytes by the header, got 28 (the "
                                                       "rest is ignored, or the header is wrong)"));
  read_volume(folder.write("v.mhd", header("MET_UCHAR", "HeaderSize = -1\nElementDataFile = v.raw\n")));
  read_volume(folder.write("v.mha", header("MET_UCHAR", kLocal) + stored(ramp<std::uint8_t>()) + "more"));
  EXPECT_EQ(given.texts.size(), 1u);
}

TEST(MetaImageFile, RefusesSpacingThatIsNone) {
  const TemporaryFolder folder;
  const std::string data = kLocal + stored(ramp<std::uint8_t>());
  const auto error = [&](const std::string& spacing) {
    return read_error(folder.write("v.mha", header("MET_UCHAR", "ElementSpacing = " + spacing + "\n" + data)));
  };
  EXPECT_THAT(error("0.5 2 0"),
              HasSubstr("v.mha: spacing: expected three finite numbers, none of them 0, got 0.5 2 0"));
  EXPECT_THAT(error("nan 1 1"), HasSubstr("got nan 1 1"));
  EXPECT_THAT(error("1 inf 1"), HasSubstr("got 1 inf 1"));
  VolumeSource given;
  given.file = folder.path() / "v.mha";
  given.spacing = Vec3{1, 2, 3};
  EXPECT_EQ(read_volume(given).spacing, (Vec3{1, 2, 3}));
}

TEST(MetaImageFile, NamesNoDataOutsideOfItsFolderUnlessItMay) {
  const TemporaryFolder folder;
  const std::string bytes = stored(ramp<std::uint8_t>());
  const auto outside = folder.write("v.raw", bytes), below = folder.path() / "below";
  std::filesystem::create_directories(below / "further");
  std::filesystem::copy(outside, below / "further/v.raw");
  std::filesystem::create_symlink(outside, below / "link.raw");
  VolumeSource source;
  source.file = below / "v.mhd";
  const auto naming = [&](const std::string& name) {
    folder.write("below/v.mhd", header("MET_UCHAR", "ElementDataFile = " + name + "\n"));
  };
  for (const std::string& name :
       {std::string("further/v.raw"), std::string("further/../further/v.raw"), (below / "further/v.raw").string()}) {
    naming(name);
    EXPECT_EQ(samples_of<std::uint8_t>(read_volume(source)), ramp<std::uint8_t>()) << name;
  }
  for (const std::string& name : {std::string("../v.raw"), outside.string(), std::string("link.raw")}) {
    naming(name);
    EXPECT_THAT(read_error(source.file), HasSubstr("ElementDataFile: expected a file in this file's folder or below"));
    source.allow_outside = true;
    EXPECT_EQ(samples_of<std::uint8_t>(read_volume(source)), ramp<std::uint8_t>()) << name;
    source.allow_outside = false;
  }
  // Nobody learns from the text which files there are.
  const auto told = [&](const std::string& name) {
    naming(name);
    std::string text = read_error(source.file);
    return text.erase(text.find(name));
  };
  EXPECT_EQ(told("../v.raw"), told("../gone.raw"));
  EXPECT_EQ(told("/etc/passwd"), told("/etc/none"));
}

}  // namespace
}  // namespace gicube::scene
