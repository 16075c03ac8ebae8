// One pass of a ray: what it counts, how far it goes, and what is left of the ray at its end.
#include "datapath/composite.h"
#include "fog.h"
#include "reference/words.h"
#include "test.h"

namespace gicube::emu {
namespace {

// One pass each: what it counts, and how far it goes.
TEST(Passes, OfASegmentEndWithItsStepsWhetherItGathersOrLeaps) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kOpacity;
  frame.step = wire::kStepOne / 8;
  fog.set(1000, 0, wire::Bsdf::kNone);
  wire::Ray packet;
  packet.position = {1u << 13, 2u << 14, 2u << 14};
  packet.direction = {16384, 0, 0};
  packet.set_colour_word(2u << 16);  // two voxels: 16 steps
  const BlockGrid grid(*frame.volume);
  RayState ray = unpack(packet, frame);
  RayCounters counters;
  for (int taken = 0; taken < 16; ++taken) {
    ASSERT_EQ(end(ray, frame), Termination::kActive);
    ASSERT_EQ(ray.steps_left(), 16 - taken);
    const Cell at = cell(ray.position, grid.low(ray.position));
    const BlockView view = frame.volume->view(0);
    gather(ray, {at, view, 0, 9}, frame, counters);
  }
  EXPECT_EQ(end(ray, frame), Termination::kLeft);
  EXPECT_EQ(counters.samples, 16u);
  EXPECT_EQ(counters.visible_samples, 16u);
  EXPECT_NEAR(ray.opacity / double{wire::kOpacityOne}, reference::corrected(1000 / 65535.0, 2), 1e-5);

  ray = unpack(packet, frame);
  EXPECT_EQ(skip_block(ray, {0, 0, 0}, 8 << 14, frame, counters), 16) << "the segment ends before its block";
  EXPECT_EQ(ray.steps_left(), 0);
  EXPECT_EQ(counters.leaps, 1u);
  EXPECT_EQ(counters.samples, 16u);
  EXPECT_TRUE(ray.under_way);
  packet.set_colour_word(30u << 16);
  ray = unpack(packet, frame);
  EXPECT_EQ(skip_block(ray, {0, 0, 0}, 2 << 14, frame, counters), 12) << "the first sample lies at 9/16";
  EXPECT_EQ(ray.steps_left(), 240 - 12);
}

TEST(Passes, OfABackprojectingRayLeaveItsAmountAtEachStepOfItsSegment) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kBackproject;
  frame.step = wire::kStepOne / 8;
  wire::Ray packet;
  packet.position = {1u << 13, 2u << 14, 2u << 14};
  packet.direction = {16384, 0, 0};
  packet.opacity = 5 << wire::kAmountFractionBits;
  packet.set_colour_word(2u << 16);
  RayState ray = unpack(packet, frame);
  const BlockGrid grid(*frame.volume);
  RayCounters counters;
  for (int taken = 0; taken < 16; ++taken) {
    ASSERT_EQ(end(ray, frame), Termination::kActive);
    const Cell at = cell(ray.position, grid.low(ray.position));
    const BlockView view = frame.volume->view(0);
    const Interaction left = sample(ray, {at, view, 0, 9}, frame, counters);
    EXPECT_TRUE(left.deposits);
    EXPECT_EQ(left.units[0], 5u);
  }
  EXPECT_EQ(end(ray, frame), Termination::kLeft);
  EXPECT_EQ(counters.samples, 16u);
  EXPECT_EQ(counters.visible_samples, 16u);
  EXPECT_EQ(counters.deposits, 16u);
  EXPECT_EQ(counters.energy.emitted, 80u);
}

TEST(Passes, OfARenderingRayGatherItsColourAndOpacity) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kIntegrate;
  fog.set(20'000, 0, wire::Bsdf::kNone);
  fog.lit.scene.segmentation[0].colour = {4000, 2000, 7};
  const BlockGrid grid(*frame.volume);
  for (const bool colourless : {false, true}) {
    frame.type = colourless ? wire::RayType::kFirstHit : wire::RayType::kIntegrate;
    RayState ray = fog.ray(0, 1), expected = ray;
    const Cell at = cell(ray.position, grid.low(ray.position));
    const BlockView view = frame.volume->view(0);
    RayCounters counters;
    gather(ray, {at, view, 0, 9}, frame, counters);
    over(expected, colourless ? Colour12{} : Colour12{4000, 2000, 7}, alpha_of(fog));
    EXPECT_EQ(ray.opacity, expected.opacity);
    EXPECT_EQ(ray.colour, expected.colour);
    EXPECT_EQ(ray.position[0], 7 << 13);
  }
}

TEST(Passes, OfASegmentTakeStepsOfTheNearestLength) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kOpacity;
  frame.step = 8193;
  wire::Ray packet;
  packet.position = {1u << 13, 2u << 14, 2u << 14};
  packet.direction = {16384, 0, 0};
  for (const auto& [rest, step] : {std::pair{0u, 8192u}, {7u, 8192u}, {8u, 8193u}, {15u, 8193u}}) {
    packet.set_colour_word(16 * 8192 + rest);
    const RayState ray = unpack(packet, frame);
    ASSERT_EQ(ray.steps_left(), 16) << rest;
    EXPECT_EQ(ray.exponent, step) << rest;
  }
}

// The tag of a sample is that of the nearest voxel: here 1 from x = 3 on.
TEST(Passes, OfASampleClassifyItByTheTagOfTheNearestVoxel) {
  Fog fog;
  fog.lit.scene.fill([](int x, int, int) {
    wire::Voxel voxel;
    voxel.tag = static_cast<std::uint8_t>(x >= 3);
    return voxel;
  });
  fog.lit.scene.segmentation[1 << 12].opacity = 30'000;
  Frame& frame = fog.lit.scene.frame;
  const BlockGrid grid(*frame.volume);
  for (const auto& [fraction, visible] : {std::pair{0, 0u}, {8191, 0u}, {8192, 1u}, {16'000, 1u}}) {
    RayState ray = fog.ray(wire::kLightingRay, 1);
    ray.position[0] = (2 << 14) + fraction;
    ray.set_energy(std::uint64_t{200} << kEnergyFractionBits);
    const Cell at = cell(ray.position, grid.low(ray.position));
    RayCounters counters;
    sample(ray, {at, frame.volume->view(0), 0, 9}, frame, counters);
    EXPECT_EQ(counters.visible_samples, visible) << fraction;
  }
}

TEST(Passes, OfALightingRayCountItsSampleAndTakeItOffTheSurface) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  fog.set(1000, 0, wire::Bsdf::kNone);
  RayState ray = fog.ray(wire::kLightingRay | wire::kTrapped, 1);
  ray.set_energy(std::uint64_t{200} << kEnergyFractionBits);
  const BlockGrid grid(*frame.volume);
  const Cell at = cell(ray.position, grid.low(ray.position));
  const BlockView view = frame.volume->view(0);
  RayCounters counters;
  skip_block(ray, {0, 0, 0}, 8 << 14, frame, counters);
  EXPECT_FALSE(ray.is(wire::kTrapped));
  ray = fog.ray(wire::kLightingRay, 1);
  ray.set_energy(std::uint64_t{200} << kEnergyFractionBits);
  sample(ray, {at, view, 0, 9}, frame, counters);
  EXPECT_EQ(counters.samples, 1u);
  EXPECT_EQ(counters.visible_samples, 1u);
  fog.set(0, 0, wire::Bsdf::kNone);
  sample(ray, {at, view, 0, 9}, frame, counters);
  EXPECT_EQ(counters.samples, 2u);
  EXPECT_EQ(counters.visible_samples, 1u);
}

TEST(Packets, GiveARayItsWords) {
  const Fog fog;
  wire::Ray packet;
  packet.position = {1, 2, 3};
  packet.direction = {0, 0, -16384};
  packet.u = 9;
  packet.v = 77;
  packet.lifetime = 44;
  packet.generation = 15;
  packet.flags = wire::kLightingRay;
  const RayState ray = unpack(packet, fog.lit.scene.frame);
  EXPECT_EQ(ray.position, (Point{1, 2, 3}));
  EXPECT_EQ(ray.direction, packet.direction);
  EXPECT_EQ(ray.u, 9);
  EXPECT_EQ(ray.v, 77);
  EXPECT_EQ(ray.lifetime, 44);
  EXPECT_EQ(ray.generation, 15);
  EXPECT_EQ(ray.flags, wire::kLightingRay);
}

// A hit is the sample before the ray's place; a segment's end half a step before it; what lies outside is put on the
// face.
TEST(Packets, HoldWhatARayGatheredAndWhereItEnded) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  RayState ray = fog.ray(0, 9);
  ray.v = 77;
  ray.opacity = 5'000'000;
  ray.colour = {1, 2, 3};
  ray.lifetime = 44;
  ray.generation = 5;
  const auto packed = [&](wire::RayType type, std::uint32_t threshold) {
    frame.type = type;
    frame.opacity_threshold = threshold;
    return pack(ray, frame);
  };
  const wire::Ray plain = packed(wire::RayType::kIntegrate, 5'000'000);
  EXPECT_EQ(plain.position, (std::array<std::uint32_t, 3>{5u << 13, 2u << 14, 2u << 14}));
  EXPECT_EQ(plain.u, 9);
  EXPECT_EQ(plain.v, 77);
  EXPECT_EQ(plain.opacity, 5'000'000u);
  EXPECT_EQ(plain.colour, ray.colour);
  EXPECT_EQ(plain.contribution, (wire::kOpacityOne - 5'000'000) >> 12);
  EXPECT_EQ(plain.lifetime, 44);
  EXPECT_EQ(plain.generation, 5);
  EXPECT_EQ(plain.direction, ray.direction);
  EXPECT_EQ(packed(wire::RayType::kFirstHit, 5'000'000).position[0], 3u << 13);
  EXPECT_EQ(packed(wire::RayType::kFirstHit, 5'000'001).position[0], 5u << 13);
  EXPECT_EQ(packed(wire::RayType::kSegment, 5'000'001).position[0], 2u << 14);
  ray.position[0] = 9 << 14;
  EXPECT_EQ(packed(wire::RayType::kIntegrate, 5'000'001).position[0], 4u << 14);
  ray.position[0] = -3;
  EXPECT_EQ(packed(wire::RayType::kIntegrate, 5'000'001).position[0], 0u);
}

TEST(Shares, EndsAreCountedByTheirCauseAndTheEnergyThatLeaves) {
  Fog fog;
  RayState ray = fog.ray(wire::kLightingRay, 1);
  ray.set_energy(std::uint64_t{100} << kEnergyFractionBits);
  RayCounters counters;
  count_end(ray, Termination::kLeft, fog.lit.scene.frame, counters);
  EXPECT_EQ(counters.rays, 1u);
  EXPECT_EQ(counters.lighting_rays, 1u);
  EXPECT_EQ(counters.energy.escaped, 100u);
  EXPECT_EQ(counters.terminated, 0u);
  count_end(ray, Termination::kAbsorbed, fog.lit.scene.frame, counters);
  EXPECT_EQ(counters.energy.escaped, 100u);
  ray.flags = 0;
  count_end(ray, Termination::kOpaque, fog.lit.scene.frame, counters);
  EXPECT_EQ(counters.rays, 3u);
  EXPECT_EQ(counters.lighting_rays, 2u);
  EXPECT_EQ(counters.terminated, 1u);
}

TEST(Shares, ARayAtTheEndOfItsLifetimeGivesItsEnergyUp) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  fog.set(65535, 65535, wire::Bsdf::kIsotropic);
  fog.lit.scene.set_depths();
  RayState ray = fog.ray(wire::kLightingRay, 1);
  ray.lifetime = 0;
  ray.set_energy(std::uint64_t{100} << kEnergyFractionBits);
  EXPECT_EQ(fog.take(ray).outcome, Outcome::kEnded);
  EXPECT_EQ(fog.counters.energy.scattered_away, 100u);
  EXPECT_EQ(fog.counters.energy.given_up, 100u);
  EXPECT_EQ(fog.counters.scatterings, 0u);
  ray = fog.ray(wire::kLightingRay, 1);
  ray.lifetime = 1;
  ray.set_energy(std::uint64_t{100} << kEnergyFractionBits);
  EXPECT_EQ(fog.take(ray).outcome, Outcome::kGoesOn);
  EXPECT_EQ(ray.lifetime, 0);
  EXPECT_EQ(ray.generation, 1);
  EXPECT_EQ(ray.energy(), std::uint64_t{100} << kEnergyFractionBits);
}

TEST(Shares, GenerationsSaturateAtFifteen) {
  Fog fog;
  RayState ray = fog.ray(wire::kLightingRay, 1);
  for (int i = 0; i < 20; ++i) {
    redirect(ray, {0, 16384, 0}, fog.lit.scene.frame);
    EXPECT_EQ(ray.generation, std::min(i + 1, 15));
  }
  EXPECT_EQ(ray.lifetime, wire::kLifetimeMax - 20);
  EXPECT_EQ(ray.step, (Point{0, 16384, 0}));
  EXPECT_EQ(ray.interacted, 0u);
}

}  // namespace
}  // namespace gicube::emu
