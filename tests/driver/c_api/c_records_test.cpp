// Records of C that a caller of an earlier release hands over. Which fields cross is written by script/records.
#include "c_api/call.h"
#include "c_board.h"

// The records as callers have them that were compiled for 0.2.0.
#undef GICUBE_C_TYPES_H
namespace released_0_2_0 {
#include "released/0.2.0/gicube/c_types.h"
}  // namespace released_0_2_0

namespace gicube::c_api {
namespace {

// All that a caller hands over with a size.
TEST(CRecord, OfAPastReleaseIsTaken) {
#define EXPECT_TAKEN(record) EXPECT_LE(kFirstSize<gicube_##record>, sizeof(released_0_2_0::gicube_##record)) << #record
  EXPECT_TAKEN(open_options);
  EXPECT_TAKEN(board_info);
  EXPECT_TAKEN(volume);
  EXPECT_TAKEN(shading);
  EXPECT_TAKEN(material);
  EXPECT_TAKEN(illumination);
  EXPECT_TAKEN(lighting_report);
  EXPECT_TAKEN(view);
  EXPECT_TAKEN(ray_request);
  EXPECT_TAKEN(pair_request);
  EXPECT_TAKEN(batch_report);
}

// As a program that was compiled before find_gradients hands it over: what follows is its own memory.
TEST(CRecord, OfAnEarlierVersionHasTheDefaultsOfLaterFields) {
  constexpr std::size_t kEarlier = offsetof(gicube_volume, find_gradients);
  gicube_volume record;
  std::memset(static_cast<void*>(&record), 0x5A, sizeof record);
  const gicube_volume untouched = record;
  ASSERT_OK(gicube_volume_init(&record, kEarlier));
  EXPECT_EQ(record.size, kEarlier);
  EXPECT_EQ(record.spacing[2], 1);
  EXPECT_EQ(record.find_gradients, untouched.find_gradients);
  EXPECT_EQ(record.reserved, untouched.reserved);
  record.dims[1] = 7;
  gicube_volume read;
  const auto volume = read_fields<VolumeView>("volume", &record, read);
  EXPECT_EQ(volume.dims[1], 7);
  EXPECT_TRUE(volume.find_gradients);
  EXPECT_REFUSED(gicube_volume_init(&record, kEarlier - 1), "volume.size");
}

TEST(CRecord, OfAnEarlierVersionIsFilledNoFurther) {
  constexpr std::size_t kEarlier = offsetof(gicube_lighting_report, escaped_by_face);
  gicube_lighting_report record;
  record.escaped_by_face[0] = 7;
  ASSERT_OK(gicube_lighting_report_init(&record, kEarlier));
  EXPECT_EQ(record.size, kEarlier);
  LightingReport report;
  report.rays = 5;
  report.unit = 0.5;
  report.escaped_by_face = {1, 2};
  write_record("report", &record, to_c(report));
  EXPECT_EQ(record.rays, 5u);
  EXPECT_EQ(record.unit, 0.5);
  EXPECT_EQ(record.escaped_by_face[0], 7);
  record.size = sizeof record;
  write_record("report", &record, to_c(report));
  EXPECT_EQ(record.escaped_by_face[0], 1);
  EXPECT_EQ(record.escaped_by_face[1], 2);
}

}  // namespace
}  // namespace gicube::c_api
