#include "gicube/scene/volume_file.h"

#include <nifti2_io.h>

#include "full_disk.h"
#include "gicube/scene/light_field.h"
#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

std::vector<float> ramp(int count) {
  std::vector<float> values;
  for (int i = 0; i < count; ++i) values.push_back(0.5F * static_cast<float>(i) - 3);
  return values;
}

TEST(VolumeOutput, ReadsBackWithItsSpacingInEveryFormat) {
  const TemporaryFolder folder;
  const std::vector<float> values = ramp(24);
  for (const char* name : {"a.nrrd", "a.mhd", "a.mha", "a.nii", "a.nii.gz"}) {
    const auto file = folder.write(name, "what was there before");
    ASSERT_TRUE(is_volume_output(file));
    write_volume({{2, 3, 4}, {0.5, 0.25, 2}, {-1.5, 2, 7}, values}, file);
    const Volume volume = read_volume(file);
    EXPECT_EQ(volume.dims, (Dims{2, 3, 4})) << name;
    EXPECT_EQ(volume.spacing, (Vec3{0.5, 0.25, 2})) << name;
    EXPECT_EQ(values_of(volume), values) << name;
  }
}

TEST(VolumeOutput, SaysWhereTheFirstVoxelIs) {
  const TemporaryFolder folder;
  const std::vector<float> values = ramp(8);
  const FloatVolume volume{{2, 2, 2}, {1, 1, 1}, {-1.5, 2, 7}, values};
  const auto nrrd = folder.write("a.nrrd", ""), mha = folder.write("a.mha", ""), nifti = folder.write("a.nii", "");
  write_volume(volume, nrrd);
  write_volume(volume, mha);
  write_volume(volume, nifti);
  EXPECT_THAT(text_of(nrrd), HasSubstr("space origin: (-1.5,2,7)"));
  EXPECT_THAT(text_of(mha), HasSubstr("Offset = -1.5 2 7\n"));
  // NIfTI-1: srow_x, srow_y and srow_z begin at byte 280; their fourth numbers are the origin.
  const std::string bytes = text_of(nifti);
  for (std::size_t row = 0; row < 3; ++row) {
    float offset = 0;
    std::memcpy(&offset, bytes.data() + 280 + 16 * row + 12, sizeof offset);
    EXPECT_EQ(offset, (std::array{1.5F, -2.0F, 7.0F})[row]);  // to the right, to the front and up
  }
}

// As NIfTI readers take it: both transforms of the same code, lengths in millimetres; axes run to the right and to the
// front.
TEST(VolumeOutput, NiftiSaysUnitsAndTwiceWhereTheVoxelsAre) {
  const TemporaryFolder folder;
  const std::vector<float> values = ramp(8);
  const auto file = folder.write("a.nii", "");
  write_volume({{2, 2, 2}, {0.5, 1, 2}, {-1.5, 2, 7}, values}, file);
  const std::unique_ptr<nifti_image, decltype(&nifti_image_free)> image(nifti_image_read(file.c_str(), 0),
                                                                        &nifti_image_free);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->xyz_units, NIFTI_UNITS_MM);
  EXPECT_EQ(image->sform_code, NIFTI_XFORM_SCANNER_ANAT);
  EXPECT_EQ(image->qform_code, NIFTI_XFORM_SCANNER_ANAT);
  const double expected[3][4] = {{-0.5, 0, 0, 1.5}, {0, -1, 0, -2}, {0, 0, 2, 7}};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      EXPECT_EQ(image->sto_xyz.m[row][column], expected[row][column]) << row << ' ' << column;
      EXPECT_EQ(image->qto_xyz.m[row][column], expected[row][column]) << row << ' ' << column;
    }
  }
}

TEST(VolumeOutput, RefusesWhatItCannotWrite) {
  const TemporaryFolder folder;
  const std::vector<float> values = ramp(8);
  EXPECT_FALSE(is_volume_output("a.png"));
  EXPECT_THROWS(FileError, "extension: expected .nrrd",
                write_volume({{2, 2, 2}, {1, 1, 1}, {}, values}, folder.write("a.png", "")));
  EXPECT_THROWS(FileError, "values: expected 2 x 2 x 3, got 8",
                write_volume({{2, 2, 3}, {1, 1, 1}, {}, values}, folder.write("a.nrrd", "")));
  for (const char* name : {"a.nrrd", "a.mha", "a.nii"}) {
    EXPECT_THROWS(FileError, "expected a place to write to",
                  write_volume({{2, 2, 2}, {1, 1, 1}, {}, values}, std::filesystem::path("/nowhere") / name))
        << name;
  }
}

TEST(VolumeOutput, AFullDiskIsToldAndLeavesWhatWasThere) {
  std::vector<float> noise;
  std::mt19937 random;
  for (int i = 0; i < 16 * 16 * 16; ++i) noise.push_back(static_cast<float>(random()));
  const FloatVolume volume{{16, 16, 16}, {1, 1, 1}, {}, noise};
  for (const char* name : {"a.nrrd", "a.mhd", "a.mha", "a.nii", "a.nii.gz"}) {
    for (const std::size_t room : {std::size_t{0}, reference::kDiskBlock}) {
      reference::expect_full_disk_leaves_nothing(name, room,
                                                 [&](const std::string& file) { write_volume(volume, file); });
    }
  }
  reference::expect_full_disk_leaves_nothing("a.nrrd", reference::kDiskBlock, [&](const std::string& file) {
    write_light_field({{16, 16, 16}, 1, noise}, {1, 1, 1}, {}, file);
  });
}

// Room for the samples, but not for the header behind them.
TEST(VolumeOutput, LeavesNoSamplesWithoutTheirHeader) {
  const std::vector<float> values = ramp(reference::kDiskBlock / sizeof(float));
  reference::on_full_disks("b", reference::kDiskBlock, [&](const std::string& folder, const std::string& reason) {
    if (reason == "File too large") return;  // the header is shorter than the samples
    EXPECT_THROW(write_volume({{8, 8, 16}, {1, 1, 1}, {}, values}, folder + "/a.mhd"), FileError);
    EXPECT_EQ(reference::files_in(folder).size(), 1u);
  });
  const reference::TemporaryDirectory folder;
  std::filesystem::create_directory(folder.file("a.mhd"));
  EXPECT_THROW(write_volume({{8, 8, 16}, {1, 1, 1}, {}, values}, folder.file("a.mhd")), FileError);
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.raw")));
}

}  // namespace
}  // namespace gicube::scene
