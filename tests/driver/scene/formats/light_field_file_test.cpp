#include "gicube/scene/light_field.h"
#include "gicube/scene/volume_file.h"
#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

LightField ramp_field(int channels) {
  LightField field{{2, 3, 4}, channels, {}};
  for (int i = 0; i < 24 * channels; ++i) field.values.push_back(0.5F * static_cast<float>(i));
  return field;
}

TEST(LightFieldFile, ReadsBackAsItWasWrittenWithOneChannelOrThree) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3}) {
    const auto file = folder.write("field.nrrd", "what was there before");
    write_light_field(ramp_field(channels), {1, 1, 2}, {-1, 0, 3}, file);
    const LightField read = read_light_field(file);
    EXPECT_EQ(read.dims, (Dims{2, 3, 4}));
    EXPECT_EQ(read.channels, channels);
    EXPECT_EQ(read.values, ramp_field(channels).values);
  }
}

TEST(LightFieldFile, SaysWhereItsVoxelsAreAndNoSpacingThatIsNone) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3}) {
    const auto file = folder.write("field.nrrd", "");
    write_light_field(ramp_field(channels), {1, 1, 2}, {-1, 0, 3}, file);
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    EXPECT_THAT(text.str(), HasSubstr("space origin: (-1,0,3)"));
    EXPECT_THAT(text.str(), HasSubstr(channels == 3 ? "space directions: none (1,0,0) (0,1,0) (0,0,2)"
                                                    : "space directions: (1,0,0) (0,1,0) (0,0,2)"));
    EXPECT_EQ(text.str().substr(0, text.str().find("\n\n")).find("nan"), std::string::npos);
  }
}

TEST(LightFieldFile, OfOneChannelIsAVolumeLikeOthers) {
  const TemporaryFolder folder;
  const auto file = folder.write("field.nrrd", "");
  write_light_field(ramp_field(1), {1, 1, 2}, {-1, 0, 3}, file);
  const Volume volume = read_volume(file);
  EXPECT_EQ(volume.dims, (Dims{2, 3, 4}));
  EXPECT_EQ(volume.spacing.z, 2);
  EXPECT_EQ(samples_of<float>(volume), ramp_field(1).values);
}

TEST(LightFieldFile, WhatIsNoFieldIsNamed) {
  const TemporaryFolder folder;
  const auto fault = [&](const std::string& text) {
    const auto file = folder.write("field.nrrd", text);
    try {
      read_light_field(file);
    } catch (const FileError& error) {
      return error.field();
    }
    return std::string("none");
  };
  const std::string head = "NRRD0004\nencoding: ascii\n";
  EXPECT_EQ(fault("no field"), "file");
  EXPECT_EQ(fault(head + "type: uint8\ndimension: 3\nsizes: 1 1 2\n\n1 2\n"), "type");
  EXPECT_EQ(fault(head + "type: float\ndimension: 3\nsizes: 1 1 2\n\n1 -2\n"), "values");
  EXPECT_EQ(fault(head + "type: float\ndimension: 4\nsizes: 2 2 2 2\n\n1 2 3 4 5 6 7 8 1 2 3 4 5 6 7 8\n"), "sizes");
  EXPECT_EQ(fault(head + "type: float\ndimension: 4\nsizes: 3 1 1 2\n\n1 2 3 4 5 6\n"), "none");
  EXPECT_THROWS(FileError, "/nowhere/field.nrrd: file: expected a place to write to",
                write_light_field(ramp_field(1), {1, 1, 1}, {}, "/nowhere/field.nrrd"));
}

TEST(LightField, ItsExposureShowsNineInTenOfItsLitValuesBelowWhite) {
  LightField field{{10, 10, 1}, 1, std::vector<float>(100)};
  EXPECT_EQ(exposure_for(field), 1);
  for (std::size_t i = 0; i < 50; ++i) field.values[2 * i] = static_cast<float>(i + 1);
  EXPECT_NEAR(exposure_for(field), 0.8 / 45, 1e-9);
}

}  // namespace
}  // namespace gicube::scene
