#include "scene/formats/readers.h"

#include <OpenImageIO/imageio.h>

#include "test.h"
#include "written_files.h"

// libpng jumps out of OpenImageIO's read callback over a string when a PNG is truncated.
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): the sanitizers' names
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:ImageInput::geterror"; }
// It has no frame pointers by which that name would be found.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "fast_unwind_on_malloc=0"; }
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

namespace gicube::scene {
namespace {

OIIO::TypeDesc type_of(const std::vector<std::uint8_t>&) { return OIIO::TypeDesc::UINT8; }
OIIO::TypeDesc type_of(const std::vector<std::uint16_t>&) { return OIIO::TypeDesc::UINT16; }
OIIO::TypeDesc type_of(const std::vector<float>&) { return OIIO::TypeDesc::FLOAT; }
OIIO::TypeDesc type_of(const std::vector<double>&) { return OIIO::TypeDesc::DOUBLE; }

template <typename Sample>
void write_image(const std::filesystem::path& path, int width, int height, int channels,
                 const std::vector<Sample>& samples) {
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(width * height * channels));
  OIIO::ImageSpec spec(width, height, channels, type_of(samples));
  spec["oiio:UnassociatedAlpha"] = 1;
  const auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output && output->open(path.string(), spec) && output->write_image(spec.format, samples.data()) &&
              output->close());
}

// Slices z = 0..3 of 2 x 3 pixels.
template <typename Sample>
std::vector<Sample> slice(std::size_t z) {
  const auto all = ramp<Sample>();
  return {all.begin() + static_cast<std::ptrdiff_t>(6 * z), all.begin() + static_cast<std::ptrdiff_t>(6 * z + 6)};
}

TEST(Slices, AreStackedInNaturalOrderAndOtherFilesIgnored) {
  const TemporaryFolder folder;
  const char* names[] = {"texture-2.png", "texture-10.png", "texture-11.PNG", "texture-100.png"};
  for (std::size_t z = 0; z < 4; ++z) write_image(folder.path() / names[z], 2, 3, 1, slice<std::uint8_t>(z));
  folder.write("SOURCE.txt", "words");
  std::filesystem::create_directory(folder.path() / "folder.png");
  const Volume volume = read_volume(folder.path());
  EXPECT_EQ(volume.dims, kRampDims);
  EXPECT_EQ(volume.type, SampleType::kUint8);
  EXPECT_EQ(volume.spacing, (Vec3{1, 1, 1}));
  EXPECT_EQ(samples_of<std::uint8_t>(volume), ramp<std::uint8_t>());
  VolumeSource source;
  source.file = folder.path();
  const Volume opened = open_volume(source);
  EXPECT_TRUE(opened.samples.empty());
  for (const int planes : {1, 3}) EXPECT_EQ(bytes_in_planes(opened, planes), volume.samples);
}

TEST(Slices, MayHaveSixteenBitsOrFloats) {
  const TemporaryFolder png, tiff;
  for (std::size_t z = 0; z < 4; ++z) {
    write_image(png.path() / (std::to_string(z) + ".png"), 2, 3, 1, slice<std::uint16_t>(z));
    write_image(tiff.path() / (std::to_string(z) + ".tif"), 2, 3, 1, slice<float>(z));
  }
  const Volume u16 = read_volume(png.path()), f32 = read_volume(tiff.path());
  EXPECT_EQ(u16.type, SampleType::kUint16);
  EXPECT_EQ(samples_of<std::uint16_t>(u16), ramp<std::uint16_t>());
  EXPECT_EQ(f32.type, SampleType::kFloat32);
  EXPECT_EQ(samples_of<float>(f32), ramp<float>());
}

TEST(Slices, MayBeColourImagesWithoutColour) {
  const TemporaryFolder folder;
  write_image<std::uint8_t>(folder.path() / "0.png", 2, 1, 4, {7, 7, 7, 100, 9, 9, 9, 255});
  write_image<std::uint8_t>(folder.path() / "1.png", 2, 1, 3, {1, 1, 1, 2, 2, 2});
  write_image<std::uint8_t>(folder.path() / "2.png", 2, 1, 2, {3, 50, 4, 60});
  EXPECT_EQ(samples_of<std::uint8_t>(read_volume(folder.path())), (std::vector<std::uint8_t>{7, 9, 1, 2, 3, 4}));
  EXPECT_TRUE(read_volume(folder.path()).colours.empty());
}

// Whole and in planes; bytes(x) brings colours of 8 and 16 bits to one form.
void expect_colours(const std::filesystem::path& folder, const std::vector<std::uint8_t>& samples,
                    const std::vector<std::uint8_t>& colours) {
  const Volume whole = read_volume(folder);
  EXPECT_EQ(whole.type, SampleType::kUint8);
  EXPECT_EQ(samples_of<std::uint8_t>(whole), samples);
  EXPECT_EQ(whole.colours, colours);
  VolumeSource source;
  source.file = folder;
  const Volume opened = open_volume(source);
  ASSERT_TRUE(opened.colour_planes != nullptr);
  std::vector<std::byte> planes(samples.size()), of_colours(colours.size());
  opened.planes(0, opened.dims[2], planes);
  opened.colour_planes(0, opened.dims[2], of_colours);
  EXPECT_EQ(planes, whole.samples);
  EXPECT_TRUE(std::ranges::equal(of_colours, std::as_bytes(std::span(colours))));
}

TEST(Slices, WithColoursHaveTheirLumaForSamples) {
  const TemporaryFolder eight, sixteen;
  write_image<std::uint8_t>(eight.path() / "0.png", 2, 1, 3, {0, 0, 0, 80, 80, 80});  // grey: the next one tells
  write_image<std::uint8_t>(eight.path() / "1.png", 2, 1, 3, {255, 0, 0, 10, 100, 200});
  const std::vector<std::uint8_t> samples{0, 80, 54, 88};  // 0.2126 red + 0.7152 green + 0.0722 blue
  const std::vector<std::uint8_t> colours{0, 0, 0, 80, 80, 80, 255, 0, 0, 10, 100, 200};
  expect_colours(eight.path(), samples, colours);
  write_image<std::uint16_t>(sixteen.path() / "0.png", 2, 1, 3, {0, 0, 0, 80 * 257, 80 * 257, 80 * 257});
  write_image<std::uint16_t>(sixteen.path() / "1.png", 2, 1, 3, {65535, 0, 0, 10 * 257, 100 * 257, 200 * 257});
  expect_colours(sixteen.path(), samples, colours);
}

TEST(Slices, WithColoursAndAlphaHaveThatForSamples) {
  const TemporaryFolder folder;
  write_image<std::uint8_t>(folder.path() / "0.png", 2, 1, 4, {9, 8, 7, 100, 1, 2, 3, 255});
  expect_colours(folder.path(), {100, 255}, {9, 8, 7, 1, 2, 3});
}

TEST(Slices, WithColoursAllNeedTheirChannels) {
  const TemporaryFolder folder;
  write_image<std::uint8_t>(folder.path() / "0.png", 2, 1, 3, {9, 8, 7, 1, 2, 3});
  write_image<std::uint8_t>(folder.path() / "1.png", 2, 1, 1, {9, 8});
  EXPECT_THAT(read_error(folder.path()), AllOf(HasSubstr("1.png: channels: expected 3"), HasSubstr("got 1")));
}

TEST(Slices, InPagesMustBeGrey) {
  const TemporaryFolder folder;
  write_image<std::uint8_t>(folder.path() / "0.png", 2, 1, 3, {9, 8, 7, 1, 2, 3});
  EXPECT_THROW(read_pages(folder.path() / "0.png"), FileError);
}

TEST(Slices, MustAgreeInSizeAndType) {
  const TemporaryFolder folder;
  write_image(folder.path() / "0.png", 2, 3, 1, slice<std::uint8_t>(0));
  write_image(folder.path() / "1.png", 3, 2, 1, slice<std::uint8_t>(1));
  EXPECT_THAT(read_error(folder.path()), AllOf(HasSubstr("1.png: size"), HasSubstr("2 x 3"), HasSubstr("3 x 2")));
  write_image(folder.path() / "1.png", 2, 3, 1, slice<std::uint16_t>(1));
  EXPECT_THAT(read_error(folder.path()), HasSubstr("1.png: sample type"));
}

TEST(Slices, MustBeWholeImagesOfAKnownType) {
  const TemporaryFolder folder;
  EXPECT_THAT(read_error(folder.path()), HasSubstr("no image file"));
  folder.write("0.png", "not an image");
  EXPECT_THAT(read_error(folder.path()), HasSubstr("0.png: image"));
  std::vector<std::uint8_t> noise(64 * 64);
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<std::uint8_t>(i * i * 7919 >> 4);
  write_image(folder.path() / "0.png", 64, 64, 1, noise);
  std::filesystem::resize_file(folder.path() / "0.png", 500);
  EXPECT_THAT(read_error(folder.path()), HasSubstr("0.png: image: expected a whole image"));
  std::filesystem::remove(folder.path() / "0.png");
  write_image(folder.path() / "0.tif", 2, 3, 1, slice<double>(0));
  EXPECT_EQ(read_volume(folder.path()).type, SampleType::kFloat32);
}

// Four pages of 2 x 3 pixels.
std::filesystem::path write_pages(const TemporaryFolder& folder, const std::string& compression) {
  const auto file = folder.path() / "pages.tif";
  const auto output = OIIO::ImageOutput::create("tiff");
  OIIO::ImageSpec spec(2, 3, 1, OIIO::TypeDesc::UINT16);
  spec["compression"] = compression;
  for (std::size_t z = 0; z < 4; ++z) {
    const auto mode = z == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage;
    const auto page = slice<std::uint16_t>(z);
    EXPECT_TRUE(output->open(file.string(), spec, mode) && output->write_image(spec.format, page.data()));
  }
  output->close();
  return file;
}

// Files that were copied in part are refused at any length, or are whole but for padding.
void expect_whole_or_refused(const std::filesystem::path& file, const std::filesystem::path& volume) {
  const std::vector<std::byte> whole = read_volume(volume).samples;
  const auto bytes = std::filesystem::file_size(file);
  int refused = 0, read = 0;
  for (std::uintmax_t length = bytes - 1; length > 0; length -= std::min<std::uintmax_t>(length, 1 + bytes / 150)) {
    std::filesystem::resize_file(file, length);
    try {
      EXPECT_EQ(read_volume(volume).samples, whole) << file << " of " << length << " bytes";
      ++read;
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr("image: expected ")) << length;
      ++refused;
    }
  }
  EXPECT_GT(refused, 60);
  EXPECT_LT(read, 5) << file;
}

TEST(Slices, ThatWereCutShortAreRefused) {
  for (const char* compression : {"none", "zip", "lzw"}) {
    const TemporaryFolder folder;
    const auto file = write_pages(folder, compression);
    expect_whole_or_refused(file, file);
  }
  std::vector<std::uint8_t> noise(64 * 64);
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<std::uint8_t>(i * i * 7919 >> 4);
  for (const char* name : {"1.tif", "1.jpg", "1.png", "1.bmp", "1.pgm"}) {
    const TemporaryFolder folder;
    for (const std::string& each : {std::string(name), std::string("0") + (name + 1)})
      write_image(folder.path() / each, 64, 64, 1, noise);
    expect_whole_or_refused(folder.path() / name, folder.path());
  }
}

// [TIFF 6.0, sections 2 and 8; libtiff's BigTIFF] Pages of 2 x 3 bytes with these NewSubfileTypes; those of page i are
// 10 i to 10 i + 5.
std::string tiff_of(const std::vector<std::uint32_t>& types, Order order = Order::kLittle, bool big = false) {
  constexpr std::uint32_t kEntries = 9;
  const auto two = [&](std::uint32_t value) {
    return stored<std::uint16_t>({static_cast<std::uint16_t>(value)}, order);
  };
  const auto four = [&](std::uint32_t value) { return stored<std::uint32_t>({value}, order); };
  const auto offset = [&](std::uint64_t value) {
    return big ? stored<std::uint64_t>({value}, order) : four(static_cast<std::uint32_t>(value));
  };
  const std::uint32_t head = big ? 16 : 8, directory = big ? 8 + 20 * kEntries + 8 : 2 + 12 * kEntries + 4;
  std::string bytes = (order == Order::kBig ? "MM" : "II") + (big ? two(43) + two(8) + two(0) : two(42)) + offset(head);
  for (std::uint32_t i = 0; i < types.size(); ++i) {
    const std::uint32_t end = head + (directory + 6) * (i + 1), data = end - 6;
    const std::uint32_t entries[kEntries][2] = {{254, types[i]}, {256, 2},    {257, 3}, {258, 8}, {259, 1},
                                                {262, 1},        {273, data}, {278, 3}, {279, 6}};
    bytes += big ? offset(kEntries) : two(kEntries);
    for (const auto& [tag, value] : entries) {
      bytes += two(tag) + two(4) + offset(1) + four(value) + (big ? four(0) : "");
    }
    bytes += offset(i + 1 < types.size() ? end : 0);
    for (std::uint32_t j = 0; j < 6; ++j) bytes += static_cast<char>(10 * i + j);
  }
  return bytes;
}

TEST(Slices, AreNoReducedPagesAndNoMasks) {
  const TemporaryFolder folder, slices;
  constexpr std::uint32_t kReduced = 1, kOfSeveral = 2, kMask = 4;
  const std::vector<std::uint32_t> types{kReduced, 0, kReduced, kOfSeveral, kMask, kOfSeveral | kReduced};
  const std::vector<std::uint8_t> expected{10, 11, 12, 13, 14, 15, 30, 31, 32, 33, 34, 35};
  for (const Order order : {Order::kLittle, Order::kBig}) {
    for (const bool big : {false, true}) {
      const Volume volume = read_volume(folder.write("v.tif", tiff_of(types, order, big)));
      EXPECT_EQ(volume.dims, (Dims{2, 3, 2}));
      EXPECT_EQ(samples_of<std::uint8_t>(volume), expected);
    }
  }
  slices.write("0.tif", tiff_of({0, kReduced}));
  EXPECT_EQ(samples_of<std::uint8_t>(read_volume(slices.path())), (std::vector<std::uint8_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_THAT(read_error(folder.write("v.tif", tiff_of({kReduced}))),
              HasSubstr("v.tif: image: expected a page of full resolution, got none"));
  std::string round = tiff_of({0, 0});
  round.replace(8 + 2 * (2 + 12 * 9 + 4) + 6 - 4, 4, stored<std::uint32_t>({8}));  // the second page leads to the first
  EXPECT_THAT(read_error(folder.write("v.tif", round)),
              HasSubstr("v.tif: image: expected pages that each lead to the next"));
  slices.write("0.tif", tiff_of({0, 0}));
  EXPECT_THAT(read_error(slices.path()), HasSubstr("0.tif: image: expected one image a file, got several"));
}

TEST(Slices, AreNoFilesWhoseNamesBeginWithADot) {
  const TemporaryFolder folder;
  for (std::size_t z = 0; z < 4; ++z) {
    const std::string name = "000" + std::to_string(z) + ".png";
    write_image(folder.path() / name, 2, 3, 1, slice<std::uint8_t>(z));
    folder.write("._" + name, std::string("\0\5\x16\7Mac OS X        ", 20));
  }
  EXPECT_EQ(samples_of<std::uint8_t>(read_volume(folder.path())), ramp<std::uint8_t>());
}

TEST(Slices, WarnOfNumbersThatAreMissing) {
  const auto warnings = [](const std::vector<std::string>& names) {
    const TemporaryFolder folder;
    for (const std::string& name : names) write_image(folder.path() / name, 2, 3, 1, slice<std::uint8_t>(0));
    const Warnings given;
    EXPECT_EQ(read_volume(folder.path()).dims[2], static_cast<int>(names.size()));
    std::string text;
    for (const std::string& each : given.texts) text += each.substr(folder.path().string().size());
    return text;
  };
  EXPECT_EQ(warnings({"0000.png", "0001.png", "0003.png", "0006.png", "0007.png"}),
            ": files: expected numbers without gaps, got 3 missing, the first between 0001.png and 0003.png");
  EXPECT_EQ(warnings({"s2_t10.png", "s2_t20.png", "s2_t40.png"}),
            ": files: expected numbers without gaps, got 1 missing, the first between s2_t20.png and s2_t40.png");
  EXPECT_EQ(warnings({"s_08.png", "s_09.png", "s_010.png", "s_011.png"}), "");
  EXPECT_EQ(warnings({"0.png", "10.png", "20.png", "preview.png", "z-3.png", "z-2.png"}), "");
  EXPECT_EQ(warnings({"1a8.png", "2a8.png", "3b8.png", "3b08.png"}), "");
}

TEST(Slices, MayBeThePagesOfOneFile) {
  const TemporaryFolder folder;
  const auto file = write_pages(folder, "none");
  const Volume volume = read_pages(file);
  EXPECT_EQ(volume.dims, kRampDims);
  EXPECT_EQ(samples_of<std::uint16_t>(volume), ramp<std::uint16_t>());
  write_image(folder.path() / "one.png", 2, 3, 1, slice<std::uint8_t>(1));
  EXPECT_EQ(read_pages(folder.path() / "one.png").dims, (Dims{2, 3, 1}));
  EXPECT_THROW(read_pages(folder.path() / "none.tif"), FileError);
}

// A tiled TIFF of 20 x 18 voxels in four planes, with a description.
std::filesystem::path write_ome(const TemporaryFolder& folder, const std::string& pixels,
                                const std::string& inside = "") {
  const auto file = folder.path() / "volume.ome.tif";
  const auto output = OIIO::ImageOutput::create("tiff");
  OIIO::ImageSpec spec(20, 18, 1, OIIO::TypeDesc::UINT16);
  spec.tile_width = spec.tile_height = 16;
  spec["compression"] = "zip";
  spec["ImageDescription"] =
      R"(<?xml version="1.0"?><ome:OME xmlns:ome="x"><ome:Image><ome:Pixels DimensionOrder="XYZCT" )" + pixels + ">" +
      inside + "</ome:Pixels></ome:Image></ome:OME>";
  for (std::uint16_t z = 0; z < 4; ++z) {
    std::vector<std::uint16_t> page(20 * 18);
    for (std::size_t i = 0; i < page.size(); ++i) page[i] = static_cast<std::uint16_t>(1000 * z + i);
    const auto mode = z == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage;
    EXPECT_TRUE(output->open(file.string(), spec, mode) && output->write_image(spec.format, page.data()));
  }
  output->close();
  return file;
}

TEST(OmeTiff, IsReadWholeOrInPlanesWithItsSpacing) {
  const TemporaryFolder folder;
  const auto file = write_ome(folder,
                              R"(SizeX="20" SizeY="18" SizeZ="4" SizeC="1" SizeT="1" )"
                              R"(PhysicalSizeX="0.5" PhysicalSizeY="0.5" PhysicalSizeZ="2")",
                              R"(<ome:TiffData IFD="0" FirstZ="0"/><ome:TiffData IFD="3" FirstZ="3"/>)");
  const Volume whole = read_volume(file);
  EXPECT_EQ(whole.dims, (Dims{20, 18, 4}));
  EXPECT_EQ(whole.spacing.x, 0.5);
  EXPECT_EQ(whole.spacing.z, 2);
  EXPECT_EQ(samples_of<std::uint16_t>(whole)[20 * 18 * 3 + 7], 3007);
  VolumeSource source;
  source.file = file;
  const Volume opened = open_volume(source);
  EXPECT_TRUE(opened.samples.empty());
  std::vector<std::byte> planes(whole.samples.size());
  opened.planes(0, 1, std::span(planes).first(20 * 18 * 2));
  opened.planes(1, 3, std::span(planes).subspan(20 * 18 * 2));
  EXPECT_EQ(planes, whole.samples);
}

TEST(OmeTiff, ThatWasCutShortIsRefused) {
  const TemporaryFolder folder;
  const auto file = write_ome(folder, R"(SizeZ="4")");
  expect_whole_or_refused(file, file);
}

TEST(OmeTiff, NamesWhatItCanNotBe) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& pixels, const std::string& inside = "") {
    return read_error(write_ome(folder, pixels, inside));
  };
  EXPECT_THAT(refused(R"(SizeZ="4" SizeC="2")"), HasSubstr("SizeZ: expected 4, a plane a page, got 8"));
  EXPECT_THAT(refused(R"(SizeZ="4" SizeT="3")"), HasSubstr("SizeZ: expected 4, a plane a page, got 12"));
  EXPECT_THAT(refused(R"(SizeZ="5")"), HasSubstr("SizeZ: expected 4, a plane a page, got 5"));
  EXPECT_THAT(refused(R"(SizeZ="4" PhysicalSizeZUnit="nm")"), HasSubstr("PhysicalSizeXUnit: expected the same unit"));
  EXPECT_THAT(refused(R"(SizeZ="4")", R"(<ome:TiffData IFD="0" FirstZ="3"/>)"),
              HasSubstr("TiffData: expected plane 3 in page 3"));
  EXPECT_THAT(refused(R"(SizeZ="4")", R"(<ome:TiffData><ome:UUID>x</ome:UUID></ome:TiffData>)"),
              HasSubstr("TiffData: expected planes in this file"));
  EXPECT_THAT(refused(R"(SizeZ="4)"), HasSubstr("ImageDescription: expected an OME document"));
}

TEST(Slices, NaturalOrderComparesNumbersAsNumbers) {
  EXPECT_TRUE(natural_less("a2.png", "a10.png"));
  EXPECT_FALSE(natural_less("a10.png", "a2.png"));
  EXPECT_TRUE(natural_less("a09b1", "a9b2"));
  EXPECT_TRUE(natural_less("a", "a1"));
  EXPECT_TRUE(natural_less("a01", "a1"));
  EXPECT_FALSE(natural_less("a1", "a01"));
  EXPECT_FALSE(natural_less("a1", "a1"));
  EXPECT_TRUE(natural_less("x99999999999999999999998", "x99999999999999999999999"));
}

}  // namespace
}  // namespace gicube::scene
