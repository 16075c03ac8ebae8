#include "gicube/wire/trap.h"

#include <rapidcheck/gtest.h>

#include "hex.h"
#include "records.h"
#include "test.h"

namespace gicube::wire {
namespace {

TEST(TrappedRay, HasTheBytesThatItsTableSays) {
  TrappedRay trapped;
  trapped.ray.contribution = 0;
  trapped.ray.lifetime = 0;
  trapped.ray.flags = kTrapped;  // bit 253
  trapped.gradient = {0x1234, -2, 0};
  trapped.density = 0x7001;
  trapped.opacity = 0xFFFF;
  trapped.tag = 3;
  trapped.random = {1, 0x80000000, 0x01020304, 0};
  std::string zeros = "00";
  for (int i = 1; i < 31; ++i) zeros += " 00";
  EXPECT_EQ(hex_of<kTrappedRayBytes>(trapped), zeros +
                                                   " 20 34 12 FE FF 00 00 01 70 FF FF 03 00 00 00 00 00"
                                                   " 01 00 00 00 00 00 00 80 04 03 02 01 00 00 00 00");
}

RC_GTEST_PROP(TrappedRay, ComesBackAsItWas, ()) {
  TrappedRay trapped;
  trapped.ray = any_ray();
  for (auto& g : trapped.gradient) g = any_bits<std::int16_t>(16);
  trapped.density = any_bits<std::uint16_t>(16);
  trapped.opacity = any_bits<std::uint16_t>(16);
  trapped.tag = any_bits<std::uint8_t>(8);
  for (auto& number : trapped.random) number = any_bits<std::uint32_t>(32);
  std::array<std::uint8_t, kTrappedRayBytes> bytes{};
  encode(trapped, bytes);
  RC_ASSERT(decode<TrappedRay>(bytes) == trapped);
}

RC_GTEST_PROP(DroppedShare, TravelsInTheAnswersPacket, ()) {
  Ray ray = any_ray();
  const auto share = any_bits<std::uint32_t>(24);
  set_dropped_share(ray, share);
  std::array<std::uint8_t, kRayBytes> bytes{};
  encode(ray, bytes);
  RC_ASSERT(dropped_share(decode<Ray>(bytes)) == share);
}

TEST(DroppedShare, IsAllOrNothingAtItsEnds) {
  EXPECT_EQ(dropped_share(1.0), 0u);
  EXPECT_EQ(dropped_share(0.0), kOpacityOne);
  EXPECT_EQ(dropped_share(0.5), 1u << 23);
}

TEST(TrapDirections, AreOfUnitLengthInTheirSpace) {
  const Spacing spacing{kSpacingOne, kSpacingOne * 2, kSpacingOne * 3};
  const Triple physical = unit({1, 2, 3});
  const auto words = direction_words(physical, spacing);
  const double one = 1 << kDirectionFractionBits, third = std::sqrt(1.0 / 3);
  for (const std::int16_t word : words) EXPECT_NEAR(word / one, third, 1 / one) << "one voxel along each axis";
  const Triple back = physical_direction(words, spacing);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(back[axis], physical[axis], 1e-4);
  for (const double length : {kShortestDirection, kLongestDirection}) {  // in the worst spacing too
    const auto far = direction_words({0, length, 0}, {kSpacingMax, kSpacingMax, kSpacingMax});
    EXPECT_EQ(far[1], 1 << kDirectionFractionBits);
  }
}

TEST(SurfaceNormal, IsAgainstTheGradientOrThereIsNone) {
  EXPECT_EQ(surface_normal({0, 0, 0}), Triple{});
  EXPECT_EQ(surface_normal({0, 0, -500}), (Triple{0, 0, 1}));
}

}  // namespace
}  // namespace gicube::wire
