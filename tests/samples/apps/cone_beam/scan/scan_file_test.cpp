#include "cone_beam/scan/formats.h"

#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr double kPi = std::numbers::pi;

constexpr const char* kScan = R"(
  source_to_axis: 500 source_to_detector: 1000
  detector { columns: 8 rows: 4 pitch_u: 1.5 offset_v: -2 rows_reversed: true }
  even_angles { count: 4 first: 90 }
  volume { size: 16 size: 17 size: 18 spacing: 0.5 centre: 1 centre: 2 centre: 3 }
  projections { file: "a.raw" file: "b.raw" type: "uint16" big_endian: true skip_bytes: 3 }
  intensities: true flat { file: "flat.mha" } dark { file: "dark.mha" })";

std::string error_of(const std::string& text) {
  return message_of<InputError>([&] { parse_scan(text, "x.textproto", "/data"); });
}

TEST(ScanFile, SaysWhereEverythingIs) {
  const ScanDescription scan = parse_scan(kScan, "x.textproto", "/data");
  EXPECT_EQ(scan.geometry.source_to_axis, 500);
  EXPECT_EQ(scan.geometry.source_to_detector, 1000);
  EXPECT_EQ(scan.geometry.detector.columns, 8);
  EXPECT_EQ(scan.geometry.detector.rows, 4);
  EXPECT_EQ(scan.geometry.detector.pitch_u, 1.5);
  EXPECT_EQ(scan.geometry.detector.pitch_v, 1.5);
  EXPECT_EQ(scan.geometry.detector.offset_v, -2);
  EXPECT_TRUE(scan.rows_reversed);
  EXPECT_FALSE(scan.columns_reversed);
  ASSERT_EQ(scan.geometry.angles.size(), 4u);
  EXPECT_NEAR(scan.geometry.angles[0], kPi / 2, 1e-12);
  EXPECT_NEAR(scan.geometry.angles[3], 2 * kPi, 1e-12);
  EXPECT_EQ(scan.geometry.volume.dims, (Dims{16, 17, 18}));
  EXPECT_EQ(scan.geometry.volume.spacing, (Vec3{0.5, 0.5, 0.5}));
  EXPECT_EQ(scan.centre, (Vec3{1, 2, 3}));
  ASSERT_EQ(scan.projections.files.size(), 2u);
  EXPECT_EQ(scan.projections.files[1], "/data/b.raw");
  ASSERT_TRUE(scan.projections.raw);
  EXPECT_EQ(scan.projections.raw->dims, (Dims{8, 4, 0}));
  EXPECT_EQ(scan.projections.raw->type, SampleType::kUint16);
  EXPECT_TRUE(scan.projections.raw->big_endian);
  EXPECT_EQ(scan.projections.raw->skip_bytes, 3u);
  EXPECT_TRUE(scan.intensities);
  EXPECT_EQ(scan.flats.files.size(), 1u);
  EXPECT_EQ(scan.darks.files.size(), 1u);
}

TEST(ScanFile, EndsAShortArcAtItsLastAngle) {
  const ScanDescription scan = parse_scan(R"(source_to_axis: 500 source_to_detector: 1000
      detector { columns: 8 rows: 4 pitch_u: 1 } even_angles { count: 3 first: 10 arc: -200 })",
                                          "x", "");
  EXPECT_NEAR(scan.geometry.angles[2], -190 * kPi / 180, 1e-12);
  EXPECT_EQ(scan.geometry.volume.dims, (Dims{0, 0, 0}));
}

TEST(ScanFile, ComesBackAsItWasWritten) {
  const reference::TemporaryDirectory folder;
  ScanDescription scan = parse_scan(kScan, "x.textproto", folder.file(""));
  write_scan_file(scan, folder.file("y.textproto"));
  const ScanDescription read = read_scan_file(folder.file("y.textproto"));
  EXPECT_EQ(scan_text(read, folder.file("")), scan_text(scan, folder.file("")));
  EXPECT_EQ(read.projections.files, scan.projections.files);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(read.geometry.angles[i], scan.geometry.angles[i], 1e-14);
}

constexpr const char* kViews = R"(detector { columns: 8 rows: 4 }
  view { source: 400 source: 0 source: 0 centre: -300 centre: 0 centre: 0 u: 0 u: 2 u: 0 v: 0 v: 0 v: -3 }
  view { source: 0 source: 400 source: 7 centre: 0 centre: -300 centre: 7 u: -2 u: 0 u: 0 v: 0 v: 0 v: -3 })";

TEST(ScanFile, HasAPoseForEachViewAndTakesACircleForOne) {
  const reference::TemporaryDirectory folder;
  const ScanDescription scan = parse_scan(kViews, "x", "");
  ASSERT_EQ(scan.geometry.poses.size(), 2u);
  EXPECT_TRUE(scan.rows_reversed);
  EXPECT_FALSE(scan.columns_reversed);
  EXPECT_EQ(scan.centre, (Vec3{0, 0, 3.5}));
  EXPECT_EQ(scan.geometry.poses[1].source, (Vec3{0, 400, 3.5}));
  EXPECT_EQ(scan.geometry.poses[1].v, (Vec3{0, 0, 3}));
  write_scan_file(scan, folder.file("y.textproto"));
  const ScanDescription read = read_scan_file(folder.file("y.textproto"));
  EXPECT_EQ(read.geometry.poses, scan.geometry.poses);
  EXPECT_EQ(read.rows_reversed, scan.rows_reversed);
  // A helix of one height is a circle.
  std::string flat = kViews;
  for (std::size_t at; (at = flat.find(": 7")) != std::string::npos;) flat.replace(at, 3, ": 0");
  const ScanDescription circle = parse_scan(flat, "x", "");
  ASSERT_TRUE(circle.geometry.circular());
  EXPECT_NEAR(circle.geometry.source_to_detector, 700, 1e-9);
  EXPECT_NEAR(circle.geometry.angles[1], kPi / 2, 1e-12);
  EXPECT_NEAR(circle.geometry.detector.pitch_v, 3, 1e-12);
}

TEST(ScanFile, RefusesAPoseThatIsNoneAndACircleBesidePoses) {
  EXPECT_THAT(error_of("detector { columns: 8 rows: 4 } view { source: 1 } view {}"),
              AllOf(HasSubstr("view[0].source: expected three numbers, got 1"),
                    HasSubstr("view[1].v: expected three numbers, got 0")));
  EXPECT_THAT(error_of(std::string(kViews) + "source_to_axis: 3"),
              HasSubstr("view: expected no distances, angles, pitches, offsets and reversals"));
  std::string text = kViews;
  text.replace(text.find("u: 0 u: 2"), 9, "u: 0 u: 0");
  EXPECT_THAT(error_of(text), HasSubstr("view[0]: expected steps between pixels in two directions"));
}

TEST(ScanFile, NamesAllFaultsAtOnce) {
  const std::string text = error_of(R"(source_to_axis: -1 detector { columns: 8 rows: 0 pitch_u: nan }
      angle: 0 angle: inf volume { size: 4 spacing: 0 } projections { file: "" type: "int64" } flat { file: "f" })");
  EXPECT_THAT(text, HasSubstr("x.textproto: source_to_axis: expected a number above 0, got -1"));
  EXPECT_THAT(text, HasSubstr("source_to_detector: expected a number above 0, got none"));
  EXPECT_THAT(text, HasSubstr("detector.rows: expected a whole number from 1 to 65536, got 0"));
  EXPECT_THAT(text, HasSubstr("detector.pitch_u: expected a number above 0, got nan"));
  EXPECT_THAT(text, HasSubstr("angle[1]: expected a finite number, got inf"));
  EXPECT_THAT(text, HasSubstr("volume.size: expected three numbers, got 1"));
  EXPECT_THAT(text, HasSubstr("volume.spacing[0]: expected a number above 0, got 0"));
  EXPECT_THAT(text, HasSubstr("projections.file: expected a file's name, got an empty one"));
  EXPECT_THAT(text, HasSubstr("projections.type: expected uint8, uint16, int16 or float32, got \"int64\""));
  EXPECT_THAT(text, HasSubstr("intensities: expected true where there are flats"));
}

TEST(ScanFile, IsStrict) {
  EXPECT_THAT(error_of("source_to_axes: 5"), HasSubstr("x.textproto:1:"));
  EXPECT_THAT(error_of("source_to_axis: \"far\""), HasSubstr("x.textproto:1:17"));
  EXPECT_THAT(error_of("angle: 1 even_angles { count: 2 }"),
              HasSubstr("angle: expected a list of angles, or even_angles, got both"));
  EXPECT_THAT(error_of("even_angles { count: 1 }"), HasSubstr("even_angles.count: expected a whole number from 2"));
  EXPECT_THAT(error_of("intensities: true"), HasSubstr("flat: expected files, or a full_intensity"));
  EXPECT_THAT(error_of("projections { file: \"a\" skip_bytes: 2 }"), HasSubstr("projections.type: expected"));
  EXPECT_THROW(read_scan_file("/nowhere/a.textproto"), InputError);
}

}  // namespace
}  // namespace gicube::samples
