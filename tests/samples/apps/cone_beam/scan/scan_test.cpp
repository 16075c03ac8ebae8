#include "cone_beam/scan/scan.h"

#include "cone_beam/scan/description.h"
#include "gicube/error.h"
#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

class LoadedScan : public testing::Test {
 protected:
  // Views of 2 x 2 pixels, of which view i holds 10 i, 10 i + 1, ...
  ScanDescription scan(const std::vector<double>& degrees) const {
    ScanDescription out;
    out.geometry.source_to_axis = 100;
    out.geometry.source_to_detector = 200;
    out.geometry.detector = {2, 2, 1, 1};
    out.geometry.volume = {{4, 4, 4}, {1, 1, 1}};
    Stack stack{2, 2, {}, false};
    for (std::size_t i = 0; i < degrees.size(); ++i) {
      out.geometry.angles.push_back(degrees[i] * kDegree);
      for (int pixel = 0; pixel < 4; ++pixel)
        stack.values.push_back(static_cast<float>(10 * static_cast<int>(i) + pixel));
    }
    out.projections.files = write_stack(stack, folder_.file("a.mha"));
    return out;
  }
  static std::string error_of(const ScanDescription& description) {
    return message_of<std::runtime_error>([&] { load_scan(description); });
  }

  const reference::TemporaryDirectory folder_;
};

TEST_F(LoadedScan, IsInOrderOfItsAnglesWithRepeatedOnesAveraged) {
  const Scan loaded = load_scan(scan({0, 240, 120, 360}));
  EXPECT_EQ(loaded.views_read, 4u);
  EXPECT_EQ(loaded.repeated, 1u);
  ASSERT_THAT(loaded.geometry.angles, SizeIs(3));
  EXPECT_NEAR(loaded.geometry.angles[1], 120 * kDegree, 1e-12);
  EXPECT_THAT(loaded.projections.values, ElementsAre(15, 16, 17, 18, 20, 21, 22, 23, 10, 11, 12, 13));
}

TEST_F(LoadedScan, HasItsReversedColumnsAndRowsTurnedRound) {
  ScanDescription description = scan({0, 180});
  description.columns_reversed = true;
  EXPECT_THAT(load_scan(description).projections.values, ElementsAre(1, 0, 3, 2, 11, 10, 13, 12));
  description.rows_reversed = true;
  EXPECT_THAT(load_scan(description).projections.values, ElementsAre(3, 2, 1, 0, 13, 12, 11, 10));
  description.columns_reversed = false;
  const Scan loaded = load_scan(description);
  EXPECT_THAT(loaded.projections.values, ElementsAre(2, 3, 0, 1, 12, 13, 10, 11));
  EXPECT_THAT(as_stored(loaded.projections, description), ElementsAre(0, 1, 2, 3, 10, 11, 12, 13));
}

TEST_F(LoadedScan, WarnsOfAnArcThatMissesRays) {
  EXPECT_THAT(load_scan(scan({0, 90, 180, 270})).warnings, testing::Not(testing::Contains(HasSubstr("angles"))));
  EXPECT_THAT(load_scan(scan({0, 30, 60, 90})).warnings,
              testing::Contains(HasSubstr("the views cover 120.0 degrees, but only 180.6 measure")));
}

TEST_F(LoadedScan, TellsAnObjectBeyondOneSideFromOneBeyondBoth) {
  const auto warnings = [&](const std::vector<float>& row, double offset) {
    ScanDescription description = scan({0, 90, 180, 270});
    description.geometry.detector = {4, 2, 1, 1, offset};
    Stack stack{4, 2, {}, false};
    for (int i = 0; i < 8; ++i) stack.values.insert(stack.values.end(), row.begin(), row.end());
    description.projections.files = write_stack(stack, folder_.file("b.mha"));
    return load_scan(description).warnings;
  };
  EXPECT_THAT(warnings({2, 5, 5, 1}, 0),
              ElementsAre(HasSubstr("beyond both sides of the detector (its edge shows 40%")));
  EXPECT_THAT(warnings({2, 5, 5, 0}, 0),
              ElementsAre(HasSubstr("beyond the side of the least u of the detector alone (its edge shows 40%")));
  EXPECT_THAT(warnings({0, 5, 5, 2}, 0.5),
              ElementsAre(HasSubstr("greatest u of the detector alone (its edge shows 40% of the greatest mean of a "
                                    "column), as a displaced detector's with a negative offset_u does, but offset_u "
                                    "is 0.5")));
  EXPECT_THAT(warnings({2, 5, 5, 0}, 0.5), SizeIs(0));  // a displaced detector's near side
  EXPECT_THAT(warnings({0, 5, 5, 0}, 0.5), SizeIs(0));
}

TEST_F(LoadedScan, KeepsEachViewOfAnOrbitThatIsNoCircle) {
  ScanDescription description = scan({0, 0, 720});
  for (const double z : {0.0, 1.0, 2.0}) {
    description.geometry.poses.push_back({{100, 0, z}, {-100, 0, z}, {0, 1, 0}, {0, 0, 1}});
  }
  const Scan loaded = load_scan(description);
  EXPECT_EQ(loaded.geometry.poses.size(), 3u);
  EXPECT_EQ(loaded.repeated, 0u);
  EXPECT_THAT(loaded.projections.values, ElementsAre(0, 1, 2, 3, 10, 11, 12, 13, 20, 21, 22, 23));
}

TEST_F(LoadedScan, IsRefusedWhereFilesAndGeometryDiffer) {
  ScanDescription description = scan({0, 120, 240});
  description.geometry.angles.push_back(5);
  EXPECT_THAT(error_of(description), HasSubstr("a.mha: views: expected 4, one an angle, got 3"));
  description = scan({0, 120, 240});
  description.geometry.detector.columns = 3;
  EXPECT_THAT(error_of(description), HasSubstr("a.mha: size: expected 3 x 2 pixels, as the detector has, got 2 x 2"));
  description = scan({0, 360});
  EXPECT_THAT(error_of(description), HasSubstr("angles: expected at least 2, got 1"));
  description.projections = {};
  EXPECT_THAT(error_of(description), HasSubstr("expected projections"));
}

TEST_F(LoadedScan, HasAVolumeThatTheDetectorSees) {
  ScanDescription description = scan({0, 180});
  description.geometry.detector = {20, 10, 1, 2};
  description.geometry.volume = {{0, 0, 0}, {0, 0, 0}};
  complete_volume(description);
  EXPECT_EQ(description.geometry.volume.dims, (Dims{20, 20, 10}));
  EXPECT_EQ(description.geometry.volume.spacing, (Vec3{0.5, 0.5, 1}));
  description.geometry.volume = {{0, 0, 0}, {1, 1, 1}};
  complete_volume(description);
  EXPECT_EQ(description.geometry.volume.dims, (Dims{10, 10, 10}));
}

}  // namespace
}  // namespace gicube::samples
