#include "cone_beam/scan/formats.h"

#include <nlohmann/json.hpp>

#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples {
namespace {

using nlohmann::json;

constexpr double kPi = std::numbers::pi;

json mm(double value) { return {{"value", value}, {"unit", "mm"}}; }
json point(double x, double y, double z) { return {{"x", mm(x)}, {"y", mm(y)}, {"z", mm(z)}}; }
json along(double x, double y, double z) {
  return {{"x", {{"value", x}}}, {"y", {{"value", y}}}, {"z", {{"value", z}}}};
}
json stand(const json& centre, const json& u, const json& w) {
  return {{"center", centre}, {"vector_u", u}, {"vector_w", w}, {"deviations", json::array()}};
}

// As the CTSimU toolbox's tetrahedron: the source at the origin, x the beam, rows of pixels that run down.
json scenario() {
  json out;
  out["file"] = {{"file_type", "CTSimU Scenario"}};
  out["geometry"]["source"] = stand(point(0, 0, 0), along(0, -1, 0), along(1, 0, 0));
  out["geometry"]["source"]["type"] = "cone";
  out["geometry"]["stage"] = stand(point(300, 0, 0), along(1, 0, 0), along(0, 0, 1));
  out["geometry"]["detector"] = stand(point(400, 0, 0), along(0, -1, 0), along(1, 0, 0));
  out["detector"] = {{"columns", {{"value", 8}, {"unit", "px"}}},
                     {"rows", {{"value", 6}, {"unit", "px"}}},
                     {"pixel_pitch", {{"u", mm(1.3)}, {"v", mm(1.1)}}}};
  out["acquisition"] = {{"start_angle", {{"value", 0}, {"unit", "deg"}}},
                        {"stop_angle", {{"value", 360}, {"unit", "deg"}}},
                        {"direction", "CCW"},
                        {"number_of_projections", 5},
                        {"include_final_angle", true}};
  return out;
}

json metadata() {
  json out;
  out["file"] = {{"file_type", "CTSimU Metadata"}};
  json& projections = out["output"]["projections"];
  projections = {{"filename", "views.raw"}, {"number", 5}, {"max_intensity", 60000}, {"datatype", "uint16"}};
  projections["byteorder"] = "big";
  projections["headersize"] = {{"file", 16}, {"image", 0}};
  projections["dimensions"] = {{"x", {{"value", 8}, {"unit", "px"}}}, {"y", {{"value", 6}, {"unit", "px"}}}};
  projections["flat_field"] = {{"number", 3}, {"filename", "flat_%03d.raw"}, {"projections_corrected", false}};
  projections["dark_field"] = {{"number", 1}, {"filename", "dark.raw"}, {"projections_corrected", true}};
  json& tomogram = out["output"]["tomogram"];
  tomogram["dimensions"] = {{"x", {{"value", 8}}}, {"y", {{"value", 9}}}, {"z", {{"value", 10}}}};
  tomogram["voxelsize"] = point(0.5, 0.5, 0.75);
  out["acquisition_geometry"] = {{"path_to_CTSimU_JSON", "scenario.json"}};
  return out;
}

class Ctsimu : public testing::Test {
 protected:
  ScanDescription read(const json& value, const std::string& name = "scenario.json") const {
    std::ofstream(folder_.file(name)) << value;
    return read_ctsimu(folder_.file(name));
  }
  std::string error_of(const json& value, const std::string& name = "scenario.json") const {
    return message_of<FileError>([&] { read(value, name); });
  }

  const reference::TemporaryDirectory folder_;
};

TEST_F(Ctsimu, StandsOnTheStage) {
  const ScanDescription scan = read(scenario());
  const ConeGeometry& geometry = scan.geometry;
  EXPECT_TRUE(geometry.circular());
  EXPECT_NEAR(geometry.source_to_axis, 300, 1e-9);
  EXPECT_NEAR(geometry.source_to_detector, 400, 1e-9);
  EXPECT_EQ(geometry.detector.columns, 8);
  EXPECT_EQ(geometry.detector.rows, 6);
  EXPECT_NEAR(geometry.detector.pitch_u, 1.3, 1e-12);
  EXPECT_NEAR(geometry.detector.pitch_v, 1.1, 1e-12);
  EXPECT_NEAR(geometry.detector.offset_u, 0, 1e-9);
  EXPECT_FALSE(scan.columns_reversed);
  EXPECT_TRUE(scan.rows_reversed);
  // The source begins at -x of the stage; the stage turns counter-clockwise, so it goes clockwise.
  const std::vector<double> wanted{kPi, kPi / 2, 0, -kPi / 2, -kPi};
  ASSERT_EQ(geometry.angles.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(std::remainder(geometry.angles[i] - wanted[i], 2 * kPi), 0, 1e-9);
  }
  EXPECT_TRUE(scan.projections.empty());
}

TEST_F(Ctsimu, TurnsTheOtherWayAndLeavesTheLastAngleOut) {
  json value = scenario();
  value["acquisition"]["direction"] = "CW";
  value["acquisition"]["include_final_angle"] = false;
  value["acquisition"]["start_angle"] = 0.0;  // a bare number is degrees
  const ScanDescription scan = read(value);
  EXPECT_NEAR(std::remainder(scan.geometry.angles[1] - scan.geometry.angles[0], 2 * kPi), 2 * kPi / 5, 1e-9);
}

TEST_F(Ctsimu, KnowsAStageThatIsTurnedAndADetectorThatIsShifted) {
  json value = scenario();
  value["geometry"]["stage"]["vector_u"] = along(0, 1, 0);  // 90 degrees about z
  value["geometry"]["detector"]["center"] = {{"x", {{"value", 0.4}, {"unit", "m"}}}, {"y", mm(-2)}, {"z", mm(3)}};
  const ScanDescription scan = read(value);
  EXPECT_NEAR(scan.geometry.angles[0], kPi / 2, 1e-12);
  EXPECT_NEAR(scan.geometry.detector.offset_u, 2, 1e-9);  // columns run along -y
  EXPECT_NEAR(scan.geometry.detector.offset_v, 3, 1e-9);
  EXPECT_NEAR(length(scan.centre), 0, 1e-9);
}

// Stages beside the ray, and tilted ones: each view as a stage that turns about its own axis by the angle has it.
TEST_F(Ctsimu, KnowsTiltedStagesAndDetectors) {
  json value = scenario();
  value["geometry"]["stage"]["center"] = point(300, 4, 0);
  value["geometry"]["stage"]["vector_w"] = along(0, 0.1, 1);
  const ScanDescription scan = read(value);
  ASSERT_FALSE(scan.geometry.circular());
  const Vec3 u{1, 0, 0}, w = (1 / std::hypot(0.1, 1)) * Vec3{0, 0.1, 1}, v = cross(w, u);
  for (std::size_t i = 0; i < 5; ++i) {
    const double angle = static_cast<double>(i) * kPi / 2, c = std::cos(angle), s = std::sin(angle);
    const auto in_space = [&](Vec3 p) {  // of the turned stage's axes
      return Vec3{300, 4, 0} + p.x * (c * u + s * v) + p.y * (c * v - s * u) + p.z * w;
    };
    const ViewPose& view = scan.geometry.poses[i];
    EXPECT_NEAR(length(in_space(view.source + scan.centre)), 0, 1e-9);
    EXPECT_NEAR(length(in_space(view.centre + scan.centre) - Vec3{400, 0, 0}), 0, 1e-9);
  }
  value = scenario();
  value["geometry"]["detector"]["vector_w"] = along(1, 0, 0.5);
  EXPECT_FALSE(read(value).geometry.circular());
}

TEST_F(Ctsimu, MetadataNameFilesAndVolume) {
  read(scenario());
  const ScanDescription scan = read(metadata(), "metadata.json");
  ASSERT_EQ(scan.projections.files.size(), 1u);
  EXPECT_EQ(scan.projections.files[0], folder_.file("views.raw"));
  ASSERT_TRUE(scan.projections.raw);
  EXPECT_EQ(scan.projections.raw->dims, (Dims{8, 6, 0}));
  EXPECT_EQ(scan.projections.raw->type, SampleType::kUint16);
  EXPECT_TRUE(scan.projections.raw->big_endian);
  EXPECT_EQ(scan.projections.raw->skip_bytes, 16u);
  ASSERT_EQ(scan.flats.files.size(), 3u);
  EXPECT_EQ(scan.flats.files[2], folder_.file("flat_002.raw"));
  EXPECT_TRUE(scan.darks.empty());  // the projections are corrected by it
  EXPECT_TRUE(scan.intensities);
  EXPECT_EQ(scan.full, 60000);
  EXPECT_EQ(scan.geometry.volume.dims, (Dims{8, 9, 10}));
  EXPECT_EQ(scan.geometry.volume.spacing, (Vec3{0.5, 0.5, 0.75}));
}

TEST_F(Ctsimu, IsRefusedWithTheKeyThatIsWrong) {
  const auto expect = [&](const char* pointer, const json& value, const std::string& text) {
    json changed = scenario();
    changed[json::json_pointer(pointer)] = value;
    EXPECT_THAT(error_of(changed), HasSubstr(text)) << pointer;
  };
  expect("/file/file_type", "Something", "file.file_type: expected \"CTSimU Scenario\" or \"CTSimU Metadata\"");
  expect("/geometry/source/type", "parallel", "geometry.source.type: expected \"cone\", got \"parallel\"");
  expect("/geometry/stage/deviations", {1}, "geometry.stage.deviations: expected none");
  expect("/geometry/stage/center/x/unit", "inch", "geometry.stage.center.x.unit: expected one of mm");
  expect("/geometry/stage/center/x/value", "far",
         "geometry.stage.center.x.value: expected a finite number, got \"far\"");
  expect("/geometry/stage/vector_w", along(0.1, 0, 1), "geometry.stage.vector_u: expected a direction perpendicular");
  expect("/geometry/detector/vector_w", along(0, 0, 0), "geometry.detector.vector_w: expected a direction");
  expect("/detector/columns/value", 1.5, "detector.columns.value: expected a whole number from 1 to 65536, got 1.5");
  expect("/detector/pixel_pitch/u/value", 0, "detector.pixel_pitch.u: expected a length above 0");
  expect("/acquisition/direction", "left", "acquisition.direction: expected \"CCW\" or \"CW\"");
  expect("/acquisition/number_of_projections", 1, "acquisition.number_of_projections: expected a whole number from 2");
  expect("/acquisition/include_final_angle", 1, "acquisition.include_final_angle: expected true or false, got 1");
  json missing = scenario();
  missing["geometry"].erase("stage");
  EXPECT_THAT(error_of(missing), HasSubstr("geometry.stage: expected a value, got none"));
}

TEST_F(Ctsimu, MetadataAreRefusedWithTheKeyThatIsWrong) {
  read(scenario());
  const auto expect = [&](const char* pointer, const json& value, const std::string& text) {
    json changed = metadata();
    changed[json::json_pointer(pointer)] = value;
    EXPECT_THAT(error_of(changed, "metadata.json"), HasSubstr(text)) << pointer;
  };
  expect("/output/projections/datatype", "complex", "output.projections.datatype: expected uint8");
  expect("/output/projections/byteorder", "middle", "output.projections.byteorder: expected \"little\" or \"big\"");
  expect("/output/projections/headersize/image", 4, "output.projections.headersize.image: expected 0, got 4");
  expect("/output/projections/dimensions/x/value", 9, "output.projections.dimensions: expected 8 x 6");
  expect("/output/projections/flat_field/filename", "a_%s.raw", "flat_field.filename: expected one %d or %04d");
  expect("/acquisition_geometry/path_to_CTSimU_JSON", "none.json", "none.json");
}

TEST_F(Ctsimu, IsJson) {
  std::ofstream(folder_.file("a.json")) << "{ \"file\": ";
  EXPECT_THROWS(FileError, "a.json: byte 11: expected JSON", read_ctsimu(folder_.file("a.json")));
  std::ofstream(folder_.file("c.json")) << "[1e999]";
  EXPECT_THROWS(FileError, "expected numbers that a double holds", read_ctsimu(folder_.file("c.json")));
  std::ofstream(folder_.file("b.json")) << std::string(100'000, '[');
  EXPECT_THROWS(FileError, "expected at most 100 levels of nesting", read_ctsimu(folder_.file("b.json")));
}

}  // namespace
}  // namespace gicube::samples
