// Files in a process of another locale, as applications with Qt or GTK are: a decimal comma, and a Turkish i.
#include <OpenImageIO/imageio.h>

#include <clocale>
#include <cstdio>

#include "gicube/scene/scene.h"
#include "gicube/scene/transfer_function_file.h"
#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

// Compiles the locale, since few machines have it.
class LocaleTest : public testing::Test {
 protected:
  explicit LocaleTest(std::string name) : name_(std::move(name)) {}
  ~LocaleTest() override {
    std::setlocale(LC_ALL, "C");
    ::unsetenv("LOCPATH");
  }

  void SetUp() override {
    if (!std::filesystem::exists("/usr/share/i18n/locales/" + name_))
      GTEST_SKIP() << "no /usr/share/i18n/locales/" << name_ << ": script/bootstrap installs the package locales";
    const std::string full = name_ + ".UTF-8";
    static const TemporaryFolder locales;  // for all tests: a locale takes seconds
    const std::string made = (locales.path() / full).string();
    if (!std::filesystem::exists(made)) {
      // Its exit code is 1 for a mere warning.
      [[maybe_unused]] const int code =
          std::system(("localedef -i " + name_ + " -f UTF-8 " + made + " >/dev/null 2>&1").c_str());
    }
    ::setenv("LOCPATH", locales.path().c_str(), 1);
    ASSERT_NE(std::setlocale(LC_ALL, full.c_str()), nullptr) << "localedef made no " << made;
    std::array<char, 8> half{};
    std::snprintf(half.data(), half.size(), "%.1f", 0.5);
    ASSERT_STREQ(half.data(), "0,5");
  }

  const TemporaryFolder folder_;

 private:
  const std::string name_;
};
class DecimalComma : public LocaleTest {
 protected:
  DecimalComma() : LocaleTest("de_DE") {}
};
class TurkishLetters : public LocaleTest {
 protected:
  TurkishLetters() : LocaleTest("tr_TR") {}
};

TEST_F(DecimalComma, IsNoneInSpacings) {
  const std::string bytes = stored(ramp<std::uint8_t>());
  const std::string nrrd = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: raw\n";
  const auto spacing = [&](const std::string& name, const std::string& header) {
    return read_volume(folder_.write(name, header + bytes)).spacing;
  };
  const Vec3 expected{1.5, 1.25, 3.75};
  EXPECT_EQ(spacing("s.nrrd", nrrd + "spacings: 1.5 1.25 3.75\n\n"), expected);
  EXPECT_EQ(spacing("d.nrrd", nrrd + "space: left-posterior-superior\nspace directions: (1.5,0,0) (0,1.25,0) "
                                     "(0,0,3.75)\nspace origin: (-10.5,3.25,0)\n\n"),
            expected);
  EXPECT_EQ(spacing("m.mha",
                    "NDims = 3\nDimSize = 2 3 4\nElementSpacing = 1.5 1.25 3.75\nElementType = MET_UCHAR\n"
                    "ElementDataFile = LOCAL\n"),
            expected);
  const auto tiff = folder_.path() / "t.tif";
  OIIO::ImageSpec spec(2, 3, 1, OIIO::TypeDesc::UINT8);
  spec["ImageDescription"] =
      R"(<OME><Image><Pixels SizeZ="1" PhysicalSizeX="1.5" PhysicalSizeY="1.25" PhysicalSizeZ="3.75"/></Image></OME>)";
  const auto output = OIIO::ImageOutput::create("tiff");
  ASSERT_TRUE(output->open(tiff.string(), spec) && output->write_image(spec.format, bytes.data()) && output->close());
  EXPECT_EQ(read_volume(tiff).spacing, expected);
}

TEST_F(DecimalComma, IsNoneInNumbersOfText) {
  const auto nrrd = folder_.write(
      "a.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 2\nspacings: 1 1 1\nencoding: ascii\n\n0.25 -1.5");
  EXPECT_EQ(values_of(read_volume(nrrd)), (std::vector<float>{0.25F, -1.5F}));
  const TransferFunctionFile look = parse_transfer_function("colour 0 1 .5 0\nopacity 0.25 0.75\n", "a.tf");
  EXPECT_EQ(look.function.opacities.front().value, 0.25);
  EXPECT_EQ(look.function.opacities.front().opacity, 0.75);
  const Scene scene = parse_scene("volume { builtin: \"buckyball\" } step: 0.25", "a.scene", ".");
  EXPECT_EQ(scene.view.step, 0.25);
}

TEST_F(DecimalComma, IsNotWritten) {
  const std::vector<float> values{0.5F, 1.5F};
  const FloatVolume volume{{1, 1, 2}, {0.5, 1.25, 2}, {-1.5, 2, 7.25}, values};
  for (const char* name : {"a.nrrd", "a.mha", "a.nii"}) {
    write_volume(volume, folder_.path() / name);
    EXPECT_EQ(read_volume(folder_.path() / name).spacing, volume.spacing) << name;
  }
  EXPECT_THAT(text_of(folder_.path() / "a.nrrd"), HasSubstr("space directions: (0.5,0,0) (0,1.25,0) (0,0,2)\n"));
  EXPECT_THAT(text_of(folder_.path() / "a.nrrd"), HasSubstr("space origin: (-1.5,2,7.25)\n"));
  EXPECT_THAT(text_of(folder_.path() / "a.mha"), HasSubstr("Offset = -1.5 2 7.25\nElementSpacing = 0.5 1.25 2\n"));
}

// tolower('I') is another letter than i there.
TEST_F(TurkishLetters, OfNamesInCapitalsAreKnown) {
  const std::vector<float> values{0.5F, 1.5F};
  write_volume({{1, 1, 2}, {1, 1, 1}, {}, values}, folder_.path() / "A.NII");
  EXPECT_EQ(values_of(read_volume(folder_.path() / "A.NII")), values);
}

}  // namespace
}  // namespace gicube::scene
