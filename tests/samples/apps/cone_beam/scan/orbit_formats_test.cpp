// RTK's geometries, Nikon's files and vectors of ASTRA: each by a place that an independent reading of the format's
// documents puts in a certain pixel, off all axes, so that no mirror and no exchange of axes goes unseen.
#include "cone_beam/scan/formats.h"
#include "cone_beam/scan/scan.h"
#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

class OrbitFormats : public testing::Test {
 protected:
  static SeenAt seen_in_file(const ScanDescription& scan, std::size_t view, Vec3 place) {
    SeenAt seen = seen_at(pose(scan.geometry, view), place - scan.centre);
    if (scan.columns_reversed) seen.column = -seen.column;
    if (scan.rows_reversed) seen.row = -seen.row;
    return {seen.column + (scan.geometry.detector.columns - 1) / 2.0,
            seen.row + (scan.geometry.detector.rows - 1) / 2.0};
  }

  const reference::TemporaryDirectory folder_;
};

// By RTK's page: the product of its four matrices, applied to a place in RTK's axes, is where the place is on the
// detector.
TEST_F(OrbitFormats, RtkPutsPlacesWhereItsMatricesDo) {
  const double gantry = 35, out_of_plane = 4, in_plane = -7, sid = 500, sdd = 1000, sx = 3, sy = -2, px = 11, py = 5;
  const auto file = folder_.write("g.xml", R"(<?xml version="1.0"?><!DOCTYPE RTKGEOMETRY>
    <RTKThreeDCircularGeometry version="3"><SourceToIsocenterDistance>500</SourceToIsocenterDistance>
    <SourceToDetectorDistance> 1000 </SourceToDetectorDistance><SourceOffsetX>3</SourceOffsetX>
    <Projection><GantryAngle>35</GantryAngle><OutOfPlaneAngle>4</OutOfPlaneAngle><InPlaneAngle>-7</InPlaneAngle>
    <SourceOffsetY>-2</SourceOffsetY><ProjectionOffsetX>11</ProjectionOffsetX><ProjectionOffsetY>5</ProjectionOffsetY>
    </Projection><Projection><GantryAngle>80</GantryAngle></Projection></RTKThreeDCircularGeometry>)");
  const ScanDescription scan = read_description(file, {}, {40, 30, 2});
  ASSERT_FALSE(scan.geometry.circular());
  const Vec3 place{12, -7, 20};  // ours; RTK's is (y, z, x)
  std::array<double, 3> p{place.y, place.z, place.x};
  const auto turn = [&p](int a, int b, double degrees) {
    const double c = std::cos(degrees * kRadians), s = std::sin(degrees * kRadians);
    const double x = p[std::size_t(a)], y = p[std::size_t(b)];
    p[std::size_t(a)] = c * x - s * y;
    p[std::size_t(b)] = s * x + c * y;
  };
  turn(2, 0, -gantry);  // about y: z and x
  turn(1, 2, -out_of_plane);
  turn(0, 1, -in_plane);
  const double depth = p[2] - sid;
  const double u = -sdd * (p[0] - sx) / depth + sx - px, v = -sdd * (p[1] - sy) / depth + sy - py;
  const SeenAt seen = seen_in_file(scan, 0, place);
  EXPECT_NEAR(seen.column, u / 2 + 19.5, 1e-9);
  EXPECT_NEAR(seen.row, v / 2 + 14.5, 1e-9);
}

TEST_F(OrbitFormats, RtksCirclesAreCircles) {
  std::string text =
      "<?xml version=\"1.0\"?><RTKThreeDCircularGeometry version=\"3\">"
      "<SourceToIsocenterDistance>500</SourceToIsocenterDistance>"
      "<SourceToDetectorDistance>1000</SourceToDetectorDistance><ProjectionOffsetX>8</ProjectionOffsetX>";
  for (int i = 0; i < 8; ++i)
    text += "<Projection><GantryAngle>" + std::to_string(45 * i) + "</GantryAngle></Projection>";
  const auto file = folder_.write("g.xml", text + "</RTKThreeDCircularGeometry>");
  // The projections' header has the pixels, and where the first is: two off the middle.
  write_stack({10, 6, std::vector<float>(8 * 60), false}, folder_.file("p.mhd"));
  folder_.write("p.mhd",
                "ObjectType = Image\nNDims = 3\nDimSize = 10 6 8\nElementSpacing = 1.5 2 1\nOffset = -4.75 -5 0\n"
                "ElementType = MET_FLOAT\nElementDataFile = p.raw\n");
  const ScanDescription scan = read_description(file, {{folder_.file("p.mhd")}, {}});
  ASSERT_TRUE(scan.geometry.circular());
  EXPECT_NEAR(scan.geometry.source_to_axis, 500, 1e-9);
  EXPECT_NEAR(scan.geometry.source_to_detector, 1000, 1e-9);
  EXPECT_EQ(scan.geometry.detector.columns, 10);
  EXPECT_NEAR(scan.geometry.detector.pitch_v, 2, 1e-12);
  EXPECT_NEAR(scan.geometry.detector.offset_u, 8 - 4.75 + 4.5 * 1.5, 1e-9);
  EXPECT_NEAR(scan.geometry.angles[1], 45 * kRadians, 1e-12);
  EXPECT_FALSE(scan.columns_reversed || scan.rows_reversed);
}

TEST_F(OrbitFormats, ComeBackAsTheyWereWritten) {
  ConeGeometry geometry;
  geometry.detector.columns = 40;
  geometry.detector.rows = 30;
  for (int i = 0; i < 6; ++i) {  // a helix of tilted detectors
    const double angle = 1.1 * i, tilt = 0.03 * i, c = std::cos(angle), s = std::sin(angle);
    const Vec3 u{-s, c, 0}, v{std::sin(tilt) * c, std::sin(tilt) * s, std::cos(tilt)};
    geometry.poses.push_back({{400 * c, 400 * s, 5.0 * i}, {-300 * c, -300 * s, 5.0 * i + 2}, 1.5 * u, 2.0 * v});
    geometry.angles.push_back(angle);
  }
  write_rtk(geometry, folder_.file("a.xml"));
  write_astra(geometry, folder_.file("a.txt"));
  write_stack({40, 30, std::vector<float>(6 * 1200), false}, folder_.file("p.mhd"));
  folder_.write("p.mhd",
                "ObjectType = Image\nNDims = 3\nDimSize = 40 30 6\nElementSpacing = 1.5 2 1\nElementType = MET_FLOAT\n"
                "ElementDataFile = p.raw\n");
  const Vec3 place{3, 40, -8};
  for (const char* name : {"a.xml", "a.txt"}) {
    const ScanDescription scan = read_description(folder_.file(name), {{folder_.file("p.mhd")}, {}});
    for (std::size_t view = 0; view < 6; ++view) {
      const SeenAt seen = seen_in_file(scan, view, place), wanted = seen_at(geometry.poses[view], place);
      EXPECT_NEAR(seen.column, wanted.column + 19.5, 1e-8) << name;
      EXPECT_NEAR(seen.row, wanted.row + 14.5, 1e-8) << name;
    }
  }
}

// CIL's: the source at the origin, the detector beyond it along y; the object turns about an axis beside y. In the
// first view by 180 degrees less InitialAngle.
TEST_F(OrbitFormats, NikonPutsPlacesWhereCilDoes) {
  const auto file =
      folder_.write("s.xtekct",
                    "[XTekCT]\r\nName=walnut\r\nVoxelsX=64\nVoxelsY=60\nVoxelsZ=50\nVoxelSizeX=3\n"
                    "DetectorPixelsX=96\nDetectorPixelsY=16\nDetectorPixelSizeX=4\nDetectorPixelSizeY=4\n"
                    "SrcToObject=500\nSrcToDetector=1000\nProjections=90\nInitialAngle=10\nAngularStep=4\n"
                    "WhiteLevel=60000\nCentreOfRotationTop=0.5\nCentreOfRotationBottom=0.5\n[Other]\nName=x\n");
  std::ofstream(folder_.file("walnut_0001.tif")) << "x";
  std::ofstream(folder_.file("other.tif")) << "x";
  const ScanDescription scan = read_description(file);
  EXPECT_TRUE(scan.intensities);
  EXPECT_EQ(scan.full, 60000);
  EXPECT_EQ(scan.projections.files.size(), 1u);
  EXPECT_EQ(scan.geometry.volume.dims, (Dims{64, 60, 50}));
  ASSERT_TRUE(scan.geometry.circular());
  EXPECT_NEAR(scan.geometry.detector.offset_u, 0.5, 1e-6);
  const Vec3 place{20, -35, 6};
  for (const int view : {0, 7}) {
    const double turn = (180 - 10 - 4 * view) * kRadians, c = std::cos(turn), s = std::sin(turn);
    // The object turns; its axis is at x = -0.25.
    const Vec3 at{c * place.x - s * place.y - 0.25, s * place.x + c * place.y + 500, place.z};
    const double x = 1000 * at.x / at.y, z = 1000 * at.z / at.y;
    const SeenAt seen = seen_in_file(scan, static_cast<std::size_t>(view), place);
    EXPECT_NEAR(seen.column, 47.5 - x / 4, 0.02);  // the first column has the greatest x, the first row the greatest z
    EXPECT_NEAR(seen.row, 7.5 - z / 4, 0.02);
  }
}

TEST_F(OrbitFormats, NikonsTiltedAxesGivePoses) {
  const auto file = folder_.write("s.xtekct",
                                  "[XTekCT]\nDetectorPixelsX=96\nDetectorPixelsY=96\nDetectorPixelSizeX=4\n"
                                  "DetectorPixelSizeY=4\nSrcToObject=500\nSrcToDetector=1000\nProjections=9\n"
                                  "AngularStep=40\nWhiteLevel=60000\nObjectTilt=2\nObjectRoll=0\n");
  const ScanDescription scan = read_description(file);
  ASSERT_FALSE(scan.geometry.circular());
  // A place on the axis stays where it is seen.
  const SeenAt first = seen_in_file(scan, 0, {0, 0, 30});
  for (std::size_t view = 1; view < 9; ++view) {
    EXPECT_NEAR(seen_in_file(scan, view, {0, 0, 30}).column, first.column, 1e-9);
    EXPECT_NEAR(seen_in_file(scan, view, {0, 0, 30}).row, first.row, 1e-9);
  }
  EXPECT_NEAR(first.column, 47.5, 1e-9);
}

TEST_F(OrbitFormats, AreRefusedWithWhatIsWrong) {
  const auto expect = [&](const std::string& name, const std::string& text, const std::string& part) {
    const auto file = folder_.write(name, text);
    EXPECT_THAT(message_of<InputError>([&] { read_description(file, {}, {8, 8, 1}); }), HasSubstr(part)) << text;
  };
  const std::string begin = "<RTKThreeDCircularGeometry>", end = "</RTKThreeDCircularGeometry>";
  expect("a.xml", "<a/>", "a.xml: root element: expected RTKThreeDCircularGeometry, got a");
  expect("a.xml", "<a", "expected XML");
  expect("a.xml", begin + end, "Projection: expected at least 2, got 0");
  expect("a.xml", begin + "<Projection><GantryAngle>x</GantryAngle></Projection>" + end,
         "Projection 1, GantryAngle: expected a number, got \"x\"");
  expect("a.xml", begin + "<Projection/>" + end, "SourceToDetectorDistance: expected a number but 0: parallel beams");
  expect("a.xml",
         begin +
             "<SourceToDetectorDistance>5</SourceToDetectorDistance><RadiusCylindricalDetector>2"
             "</RadiusCylindricalDetector><Projection/>" +
             end,
         "cylindrical detectors are not supported");
  expect("a.txt", "1 2 3 4 5 6 7 8 9 10 11\n", "a.txt: line 1: expected twelve numbers, got 11");
  expect("a.txt", "500 0 0 -500 0 0 0 1 0 0 0 1\n1 2 3 4 5 6 7 8 9 10 11 x\n", "line 2: expected numbers, got \"x\"");
  expect("a.txt", "500 0 0 -500 0 0 0 1 0 0 2 0\n", "line 1: expected steps between pixels in two directions");
  expect("a.txt", "500 0 0 -500 0 0 0 1 0 0 0 1\n", "views: expected at least 2, got 1");
  expect("a.xtekct", "Name=x\n", "section: expected [XTekCT] with keys");
  expect("a.xtekct", "[XTekCT]\nDetectorPixelsX=8\nDetectorPixelsY=many\n", "DetectorPixelsY: expected a number");
  const auto file = folder_.write("b.xml", begin + end);
  EXPECT_THAT(message_of<InputError>([&] { read_description(file); }),
              HasSubstr("or the detector's pixels (--detector), got none"));
}

TEST_F(OrbitFormats, OtherFilesAreNamedByWhatTheyAre) {
  using namespace std::string_literals;
  for (const auto& [bytes, name] : {std::pair{"\x89HDF\r\n\x1a\n"s, "an HDF5 file"},
                                    {"II*\0abc"s, "a TIFF picture"},
                                    {"NRRD0004\n"s, "an NRRD file"},
                                    {"\x93NUMPY"s, "an array of numpy"},
                                    {std::string(128, '\0') + "DICM", "a DICOM file"},
                                    {"\x7f"
                                     "ELF\2\1\1"s,
                                     "a binary file of an unknown kind"}}) {
    const auto file = folder_.write("scan.dat", bytes);
    EXPECT_THAT(message_of<InputError>([&] { read_description(file); }), HasSubstr(name));
  }
  EXPECT_EQ(kind_of(folder_.write("a", "# vectors\n1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12\n")), ScanKind::kAstra);
  EXPECT_EQ(kind_of(folder_.write("a", "source_to_axis: 5\n")), ScanKind::kScanFile);
}

}  // namespace
}  // namespace gicube::samples
