// Every plain field of the C++ settings crosses to its C record and back. A structured binding counts all fields of a struct: a new
// one breaks the build here, until somebody decides how it crosses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <tuple>
#include <type_traits>
#include <vector>

#include "c_api/call.h"

// The records as callers have them that were compiled for 0.2.0.
#undef GICUBE_C_TYPES_H
namespace released_0_2_0 {
#include "released/0.2.0/gicube/c_types.h"
}

namespace gicube::c_api {
namespace {

auto fields(OpenOptions& options) {
  // Those between: pointers of the record's, see to_options(), and what a C host has no use for, since nothing can be thrown through C.
  auto& [a, b, waiting_rays, c, d, e, f, g, capture, token, ca, go_on, while_waiting, log] = options;
  return std::tie(a, b, waiting_rays, c, d, e, f, g, go_on);
}
auto fields(VolumeView& volume) {
  auto& [samples, type, dims, spacing, range, gradients, tags, colours, find] = volume;  // the others: see to_volume()
  return std::tie(type, dims[0], dims[1], dims[2], spacing, find);
}
auto fields(Shading& shading) {
  auto& [phong, light] = shading;
  auto& [a, b, c, d] = phong;
  return std::tie(a, b, c, d, light);
}
auto fields(Material& material) {
  auto& [a, b, c, d, e, f, parameters, colour] = material;  // parameters: see to_material()
  return std::tie(a, b, c, d, e, f, colour[0], colour[1], colour[2]);
}
auto fields(Illumination& settings) {
  auto& [a, b, c, d, e, f, g, h, light_colours] = settings;  // the last: see gicube_illuminate()
  return std::tie(a, b, c, d, e, f, g, h);
}
auto fields(View& view) {
  auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, planes, lamps] =
      view;  // the last: see to_view()
  return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u);
}
auto fields(RayRequest& request) {
  auto& [a, b, c, d, e, f, g, h, sampling] = request;  // sampling: see to_request()
  return std::tie(a, b, c, d, e, f, g, h);
}
auto fields(PairRequest& request) {
  auto& [a, b, c, d, e, f, g] = request;
  return std::tie(a, b, c, d, e, f, g);
}

// Another value than the default, which a record can hold.
template <typename T>
void change(T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    value = !value;
  } else if constexpr (std::is_enum_v<T>) {
    value = static_cast<T>(static_cast<int>(value) == 0);
  } else if constexpr (std::is_same_v<T, Vec3>) {
    value = {value.x + 1, value.y + 2, value.z + 3};
  } else {
    value = value + T(1);
  }
}

template <typename T>
class CSettings : public testing::Test {};

template <typename Settings, typename Record>
struct Crossing {
  static auto there_and_back(Settings settings) {
    Record record{};
    copy_fields(Copy<true>{""}, record, settings);
    Settings back;
    copy_fields(Copy<false>{"record"}, record, back);
    return back;
  }
  static Settings defaults() { return {}; }
};

using All = testing::Types<Crossing<OpenOptions, gicube_open_options>, Crossing<VolumeView, gicube_volume>,
                           Crossing<Shading, gicube_shading>, Crossing<Material, gicube_material>,
                           Crossing<Illumination, gicube_illumination>, Crossing<View, gicube_view>,
                           Crossing<RayRequest, gicube_ray_request>, Crossing<PairRequest, gicube_pair_request>>;
TYPED_TEST_SUITE(CSettings, All);

TYPED_TEST(CSettings, CrossWithAllTheirFields) {
  auto given = TypeParam::defaults();
  const auto before = fields(given);
  std::apply([](auto&... field) { (change(field), ...); }, before);
  auto back = TypeParam::there_and_back(given);
  const auto after = fields(back);
  const auto equal = std::apply(
      [&](auto&... one) { return std::apply([&](auto&... other) { return std::vector{(one == other)...}; }, after); },
      before);
  EXPECT_THAT(equal, testing::Each(true));  // by the order in fields()
}

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
  ASSERT_EQ(gicube_volume_init(&record, kEarlier), GICUBE_OK) << gicube_last_error();
  EXPECT_EQ(record.size, kEarlier);
  EXPECT_EQ(record.spacing[2], 1);
  EXPECT_EQ(record.find_gradients, untouched.find_gradients);
  EXPECT_EQ(record.reserved, untouched.reserved);
  record.dims[1] = 7;
  gicube_volume read;
  const auto volume = read_fields<VolumeView>("volume", &record, read);
  EXPECT_EQ(volume.dims[1], 7);
  EXPECT_TRUE(volume.find_gradients);
  EXPECT_EQ(gicube_volume_init(&record, kEarlier - 1), GICUBE_BAD_ARGUMENT);
  EXPECT_STREQ(gicube_last_error_field(), "volume.size");
}

TEST(CRecord, OfAnEarlierVersionIsFilledNoFurther) {
  constexpr std::size_t kEarlier = offsetof(gicube_lighting_report, escaped_by_face);
  gicube_lighting_report record;
  record.escaped_by_face[0] = 7;
  ASSERT_EQ(gicube_lighting_report_init(&record, kEarlier), GICUBE_OK) << gicube_last_error();
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
