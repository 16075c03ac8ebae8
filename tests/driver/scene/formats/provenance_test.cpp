#include "gicube/scene/provenance.h"

#include <OpenImageIO/imageio.h>
#include <nifti2_io.h>

#include "gicube/scene/image_file.h"
#include "gicube/scene/light_field.h"
#include "gicube/scene/volume_file.h"
#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

using testing::Not;

const Provenance kProvenance{"gicube-render", "0.1.0", "gicube-render 'a b.scene' -o x", "00ff", "cycle", "1234"};

Image one_pixel() { return {1, 1, {{255, 128, 0, 4095}}}; }

FloatVolume small(const std::vector<float>& values) { return {{2, 2, 2}, {0.5, 1, 2}, {-1, 2, 7}, values}; }

TEST(Provenance, LeavesOutWhatIsEmpty) {
  EXPECT_EQ(entries({}).size(), 0u);
  EXPECT_EQ(entries(kProvenance).size(), 6u);
  ASSERT_EQ(entries({.fidelity = "cycle"}).size(), 1u);
  EXPECT_EQ(entries({.fidelity = "cycle"})[0].first, "gicube.fidelity");
}

TEST(Provenance, ACommandLineIsQuotedForAShellAndNamesNoFolderOfTheProgram) {
  const std::array<const char*, 5> words{"/opt/x/gicube-render", "a b.scene", "it's", "", "--size=3x4"};
  EXPECT_EQ(command_line(5, words.data()), "gicube-render 'a b.scene' 'it'\\''s' '' --size=3x4");
}

// As bash reads it: printf '%s' $'gr\xfc\xdfe' gives the name's bytes again.
TEST(Provenance, ACommandLineIsUtf8WhateverTheNamesOfItsFiles) {
  const auto quoted = [](const char* word) {
    const std::array<const char*, 2> words{"x", word};
    return command_line(2, words.data()).substr(2);
  };
  EXPECT_EQ(quoted("gr\xfc\xdf"
                   "e.nrrd"),
            R"($'gr\xfc\xdfe.nrrd')");
  EXPECT_EQ(quoted("it's \\\n\xff"), R"($'it\x27s \x5c\x0a\xff')");
  EXPECT_EQ(quoted("gr\u00fc\u00dfe \u20ac \U0001f642"), "'gr\u00fc\u00dfe \u20ac \U0001f642'");
  // [RFC 3629] Cut short, longer than need be, a surrogate, above U+10FFFF.
  for (const char* none : {"\xe2\x82", "\xc0\xaf", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\x80"})
    EXPECT_THAT(quoted(none), StartsWith("$'"));
}

TEST(Provenance, PicturesCarryIt) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "a.exr"}) {
    write_image(one_pixel(), folder.path() / name, {}, kProvenance);
    const auto input = OIIO::ImageInput::open((folder.path() / name).string());
    ASSERT_TRUE(input) << name;
    for (const auto& [key, value] : entries(kProvenance)) {
      EXPECT_EQ(input->spec().get_string_attribute(key), value) << name << ' ' << key;
    }
  }
}

TEST(Provenance, NrrdHasItAsKeysAndValues) {
  const TemporaryFolder folder;
  const std::vector<float> values(8, 1);
  write_volume(small(values), folder.path() / "a.nrrd", kProvenance);
  EXPECT_THAT(text_of(folder.path() / "a.nrrd"), HasSubstr("\ngicube.command:=gicube-render 'a b.scene' -o x\n"));
  write_light_field({{2, 2, 2}, 1, values}, {1, 1, 1}, {}, folder.path() / "b.nrrd", kProvenance);
  EXPECT_THAT(text_of(folder.path() / "b.nrrd"), HasSubstr("\ngicube.scene_hash:=1234\n"));
  EXPECT_EQ(values_of(read_volume(folder.path() / "a.nrrd")), values);
}

TEST(Provenance, NiftiHasItAsAComment) {
  const TemporaryFolder folder;
  const std::vector<float> values{1, 2, 3, 4, 5, 6, 7, 8};
  for (const char* name : {"a.nii", "a.nii.gz"}) {
    write_volume(small(values), folder.path() / name, kProvenance);
    const std::unique_ptr<nifti_image, decltype(&nifti_image_free)> image(
        nifti_image_read((folder.path() / name).c_str(), 0), &nifti_image_free);
    ASSERT_TRUE(image);
    ASSERT_EQ(image->num_ext, 1);
    EXPECT_EQ(image->ext_list[0].ecode, NIFTI_ECODE_COMMENT);
    const std::string text(image->ext_list[0].edata, static_cast<std::size_t>(image->ext_list[0].esize - 8));
    EXPECT_THAT(text, HasSubstr("gicube.program=gicube-render\n")) << name;
    EXPECT_EQ(values_of(read_volume(folder.path() / name)), values) << name;
  }
}

// A second is what times in headers count.
TEST(Provenance, TheSameInputsGiveTheSameBytesLater) {
  const TemporaryFolder folder;
  const std::vector<float> values(8, 1);
  const std::array names{"a.png", "a.exr", "a.nrrd", "a.mha", "a.nii", "a.nii.gz"};
  const auto write = [&](const char* name) {
    const std::filesystem::path file = folder.path() / name;
    if (is_volume_output(file)) {
      write_volume(small(values), file, kProvenance);
    } else {
      write_image(one_pixel(), file, {}, kProvenance);
    }
    return text_of(file);
  };
  std::vector<std::string> first;
  for (const char* name : names) first.push_back(write(name));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(write(names[i]), first[i]) << names[i];
}

}  // namespace
}  // namespace gicube::scene
