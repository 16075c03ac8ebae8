#include "encode/host_ray.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <random>

#include "refusal.h"

namespace gicube {
namespace {

TEST(HostRay, BecomesAPacketThatIsMarkedAndUntouched) {
  const wire::Ray ray = to_wire({0xDEADBEEF, {1, 2.5, 1023}, {0, 0, -2}}, RaySetup{});
  EXPECT_EQ(ray.host_id(), 0xDEADBEEFu);
  EXPECT_EQ(ray.flags, wire::kHostRay);
  EXPECT_EQ(ray.position, (std::array<std::uint32_t, 3>{16384, 40960, 16760832}));
  EXPECT_EQ(ray.direction, (std::array<std::int16_t, 3>{0, 0, -16384}));
  EXPECT_EQ(ray.opacity, 0u);
  EXPECT_EQ(ray.colour, (std::array<std::uint16_t, 3>{}));
  EXPECT_EQ(ray.contribution, wire::kColourOne);
}

TEST(HostRay, IsRoundedNotTruncated) {
  const wire::Ray ray = to_wire({0, {0.6 / 16384, 0.4 / 16384, 0}, {1, -1, 0}}, RaySetup{});
  EXPECT_EQ(ray.position, (std::array<std::uint32_t, 3>{1, 0, 0}));
  EXPECT_EQ(ray.direction, (std::array<std::int16_t, 3>{11585, -11585, 0}));  // 11585.24
}

TEST(HostRay, ReturnsInUnits) {
  wire::Ray ray;
  ray.set_host_id(77);
  ray.position = {16384, 8192, 0};
  ray.direction = {-16384, 0, 0};
  ray.colour = {4095, 819, 0};
  ray.opacity = wire::kOpacityOne;
  const TracedRay traced = from_wire(ray);
  EXPECT_EQ(traced.id, 77u);
  EXPECT_EQ(traced.position, (Vec3{1, 0.5, 0}));
  EXPECT_EQ(traced.direction, (Vec3{-1, 0, 0}));
  EXPECT_EQ(traced.colour, (std::array<double, 3>{1, 0.2, 0}));
  EXPECT_EQ(traced.opacity, 1);
}

TEST(HostRay, ThereAndBackIsWithinTheRounding) {
  EXPECT_TRUE(rc::check([](std::uint32_t id, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> position(0, 1023), direction(-5, 5);
    const HostRay sent{id,
                       {position(random), position(random), position(random)},
                       {direction(random), direction(random), direction(random)}};
    const TracedRay back = from_wire(to_wire(sent, RaySetup{}));
    const Vec3 moved = back.position - sent.position, turned = back.direction - normalise(sent.direction);
    RC_ASSERT(back.id == id);
    for (const double error : {moved.x, moved.y, moved.z, turned.x, turned.y, turned.z}) {
      RC_ASSERT(std::abs(error) <= 0.5 / 16384 + 1e-12);
    }
  }));
}

TEST(HostRayCheck, NamesRayAndField) {
  const Dims dims{32, 16, 8};
  const auto refused = [&](Vec3 position, Vec3 direction) {
    return refusal([&] { check(HostRay{5, position, direction}, 7, RaySetup{.dims = dims}); });
  };
  EXPECT_EQ(refused({0, 0, 0}, {1, 0, 0}), "accepted");
  EXPECT_EQ(refused({31, 15, 7}, {0, 0, -1e-200}), "accepted");
  EXPECT_EQ(refused({32.5, 0, 0}, {1, 0, 0}), "rays[7].position.x: expected 0..31, got 32.5");
  EXPECT_EQ(refused({0, -0.001, 0}, {1, 0, 0}), "rays[7].position.y: expected 0..15, got -0.001");
  EXPECT_EQ(refused({0, 0, std::nan("")}, {1, 0, 0}), "rays[7].position.z: expected 0..7, got nan");
  EXPECT_EQ(refused({0, 0, 0}, {0, 0, 0}), "rays[7].direction: expected any length but 0, got 0");
  EXPECT_EQ(refused({0, 0, 0}, {1, std::nan(""), 0}), "rays[7].direction.y: expected a finite number, got nan");
}

}  // namespace
}  // namespace gicube
