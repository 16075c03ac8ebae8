// Rays that are scattered at a surface, or wait there for a scattering routine or the host.
#include "datapath/host_traps.h"
#include "datapath/random_stream.h"
#include "datapath/scattering.h"
#include "fog.h"
#include "reference/words.h"
#include "test.h"

namespace gicube::emu {
namespace {

// A ray that was scattered at a surface passes it, until it has been outside.
TEST(Shares, ATrappedRayPassesItsMaterialUntilItHasLeftIt) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  const auto taken = [&fog](std::uint16_t opacity, wire::Bsdf bsdf) {
    fog.set(opacity, 65535, bsdf);
    fog.lit.scene.set_depths();
    RayState ray = fog.ray(wire::kLightingRay | wire::kHighAlbedo | wire::kTrapped, 4);
    ray.under_way = true;
    ray.set_energy(std::uint64_t{15} << kEnergyFractionBits);
    fog.take(ray);
    return ray;
  };
  const RayState inside = taken(65535, wire::Bsdf::kTrap);
  EXPECT_TRUE(inside.is(wire::kTrapped));
  EXPECT_EQ(inside.position[0], 7 << 13);
  EXPECT_EQ(inside.interacted, 0u);
  const RayState outside = taken(0, wire::Bsdf::kTrap);
  EXPECT_FALSE(outside.is(wire::kTrapped));
  EXPECT_EQ(outside.position[0], 7 << 13);
  const RayState elsewhere = taken(65535, wire::Bsdf::kIsotropic);
  EXPECT_FALSE(elsewhere.is(wire::kTrapped));
  EXPECT_EQ(elsewhere.generation, 1) << "another material scatters it";
}

TEST(Shares, ARayThatMeetsATrapWaitsThereWithItsMaterialsTag) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  fog.set(65535, 65535, wire::Bsdf::kTrap);
  fog.lit.scene.set_depths();
  RayState ray = fog.ray(wire::kLightingRay | wire::kHighAlbedo, 4);
  ray.set_energy(std::uint64_t{15} << kEnergyFractionBits);
  EXPECT_EQ(fog.take(ray).outcome, Outcome::kTrapped);
  EXPECT_TRUE(ray.is(wire::kTrapped));
  EXPECT_EQ(ray.flags >> kTrapTagShift, 0);
  EXPECT_EQ(fog.counters.traps, 1u);
  EXPECT_EQ(fog.counters.scatterings, 1u);
  EXPECT_EQ(ray.lifetime, wire::kLifetimeMax) << "it is counted down when the routine has answered";
}

// What the host's routine is told of a ray, and what it does to the ray by its answer.
TEST(Traps, TellTheHostTheRaySampleAndFourRandomNumbers) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  HostTraps caught;
  frame.host_traps = &caught;
  frame.seed = 11;
  frame.materials[0].routine = wire::kHostRoutine;
  fog.lit.scene.segmentation[1234].opacity = 4321;
  // Codes of the scene's codebook; all voxels have one.
  fog.lit.scene.fill([](int, int, int) { return wire::Voxel{1234, 700, 0, 0}; });
  RayState ray = fog.ray(wire::kLightingRay | wire::kTrapped, 21);
  ray.v = 22;
  ray.lifetime = 23;
  ray.set_energy(std::uint64_t{100} << kEnergyFractionBits);
  RayCounters counters;
  EXPECT_FALSE(trap_of(ray, frame));
  caught.settle();
  ASSERT_EQ(caught.waiting(), 1u);
  const wire::TrappedRay told = caught.take(1).front();
  EXPECT_EQ(told.ray.u, 21);
  EXPECT_EQ(told.ray.v, 22);
  EXPECT_EQ(told.ray.position[0], 5u << 13);
  EXPECT_EQ(told.density, 1234 << 3);
  EXPECT_EQ(told.opacity, 4321);
  EXPECT_EQ(told.tag, 0);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(told.gradient[axis], fog.lit.scene.gradients[700][axis] * 32);
  std::uint64_t drawn = draw_at(RandomStream::kRoutine, ray.position, 21, 22, 23, 11);
  for (const std::uint32_t number : told.random) {
    EXPECT_EQ(number, drawn >> 32);
    drawn = reference::mixed(drawn + 1);
  }
}

TEST(Traps, TellARoutineWhichMaterialAndWhichRay) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.materials[3].routine = 17;
  RayState ray = fog.ray(wire::kLightingRay | wire::kTrapped | 3 << kTrapTagShift, 21);
  ray.generation = 4;
  const std::optional<Trap> trap = trap_of(ray, frame);
  ASSERT_TRUE(trap);
  EXPECT_EQ(trap->routine, 17u);
  EXPECT_EQ(trap->event.tag, 3u);
  EXPECT_EQ(trap->event.generation, 4u);
  EXPECT_TRUE(trap->event.lighting);
  RayCounters counters;
  EXPECT_EQ(answer_trap(ray, {trap->event.direction, 1, 5}, frame, counters).outcome, Outcome::kGoesOn);
  EXPECT_EQ(counters.trap_cycles, 5u);
}

TEST(Traps, AnAnswerDropsItsShareOfEnergyAndBeginsAFlight) {
  Fog fog;
  const Frame& frame = fog.lit.scene.frame;
  wire::Ray packet;
  packet.u = 3;
  packet.position = {5u << 13, 2u << 14, 2u << 14};
  packet.direction = {0, 0, -16384};
  packet.flags = wire::kLightingRay;
  packet.lifetime = 10;
  packet.set_colour_word(std::uint64_t{100} << kEnergyFractionBits);
  wire::set_dropped_share(packet, wire::dropped_share(0.75));
  RayCounters counters;
  wire::Ray on = packet;
  EXPECT_FALSE(take_answer(on, frame, counters));
  EXPECT_EQ(counters.energy.emitted, 100u);
  EXPECT_EQ(counters.energy.scattered_away, 25u);
  EXPECT_NEAR(static_cast<double>(on.colour_word()) / 4096, 75, 1e-3);
  for (const double share : {0.1, 0.3, 0.37, 0.625, 0.9}) {
    wire::Ray part = packet;
    wire::set_dropped_share(part, wire::dropped_share(share));
    RayCounters of_part;
    EXPECT_FALSE(take_answer(part, frame, of_part));
    const double left = 409'600 * (1 - wire::dropped_share(share) / double{wire::kOpacityOne});
    EXPECT_NEAR(static_cast<double>(part.colour_word()), left, 0.5 + 1e-6) << share;
  }
  EXPECT_EQ(on.lifetime, 9);
  EXPECT_EQ(on.generation, 1);
  EXPECT_EQ(on.direction, packet.direction);
  wire::Ray gone = packet;
  wire::set_dropped_share(gone, wire::kOpacityOne);
  EXPECT_TRUE(take_answer(gone, frame, counters));
  EXPECT_EQ(counters.energy.scattered_away, 125u);
  EXPECT_EQ(counters.rays, 1u) << "the first one goes on";
  wire::Ray seen = packet;
  seen.flags = 0;
  seen.opacity = 0;
  seen.set_colour_word(0);
  EXPECT_FALSE(take_answer(seen, frame, counters));
  EXPECT_NEAR(seen.opacity, 0.25 * wire::kOpacityOne, 1) << "a rendering ray gathers black";
}

}  // namespace
}  // namespace gicube::emu
