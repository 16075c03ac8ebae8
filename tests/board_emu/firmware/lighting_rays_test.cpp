// Lighting rays carry what a light sends into the volume, start on its faces and run inward.
#include "firmware/lighting_rays.h"

#include "firmware/low_discrepancy.h"
#include "gicube/wire/registers.h"
#include "test.h"

namespace gicube::emu {
namespace {

using std::numbers::pi;
using wire::EnergyRules;
using wire::IlluminateCommand;
using wire::LightKind;

constexpr std::array<std::uint32_t, 3> kEven{wire::kSpacingOne, wire::kSpacingOne, wire::kSpacingOne};
constexpr Point kBox{12 * wire::kVoxel, 8 * wire::kVoxel, 10 * wire::kVoxel};  // 13 x 9 x 11 voxels

IlluminateCommand light(LightKind kind, double energy, Vector position, std::uint32_t k = 4) {
  IlluminateCommand command;
  command.kind = kind;
  command.energy = energy;
  command.position = position;
  command.rays_per_voxel = command.count = k;
  return command;
}

IlluminateCommand rectangle(Vector corner, Vector u, Vector v, std::uint32_t k) {
  IlluminateCommand command = light(LightKind::kRectangle, 1, corner, k);
  command.u = u;
  command.v = v;
  return command;
}

// What the rays carry, as real numbers; fails if one is not finite.
double sum(const IlluminateCommand& command, const Point& extent = kBox,
           const std::array<std::uint32_t, 3>& spacing = kEven) {
  EXPECT_EQ(LightingRays::fault(command, extent), std::nullopt);
  const LightingRays rays(command, extent, spacing, 24, 1);
  double total = 0;
  for (std::uint64_t i = 0; i < rays.count(); ++i) {
    const double energy = rays.energy(i);
    if (!std::isfinite(energy) || energy < 0) ADD_FAILURE() << "ray " << i << " has energy " << energy;
    total += energy;
  }
  return total;
}

// Solid angle of a box of edges `box` from a point on the axis of its -x face, `away` from it.
double face_angle(double away, double height, double width) {
  return 4 * std::asin(height / 2 / std::hypot(height / 2, away) * width / 2 / std::hypot(width / 2, away));
}

TEST(PointLight, InsideGivesAllItsEnergyToRays) {
  for (const Vector& at : {Vector{6, 4, 5}, {1, 1, 1}, {0.5, 0.5, 0.5}, {11.9, 7.99, 3}, {1e-6, 4.5, 5.5}})
    EXPECT_NEAR(sum(light(LightKind::kPoint, 3, at)), 3, 1e-6) << at[0];
}

TEST(PointLight, OnTheBoundaryGivesWhatGoesIntoTheVolume) {
  EXPECT_NEAR(sum(light(LightKind::kPoint, 8, {0, 4.5, 5})), 4, 1e-9);    // in a cell of a face
  EXPECT_NEAR(sum(light(LightKind::kPoint, 8, {12, 4, 5})), 4, 1e-9);     // on a face voxel
  EXPECT_NEAR(sum(light(LightKind::kPoint, 8, {0, 8, 5.25})), 2, 1e-9);   // in an edge
  EXPECT_NEAR(sum(light(LightKind::kPoint, 8, {12, 8, 10})), 1, 1e-9);    // in a corner
  EXPECT_NEAR(sum(light(LightKind::kPoint, 8, {-1e-7, 4, 5})), 4, 1e-6);  // just outside
}

// Closer to a face than 1e-9 it lies in it, and the face gets nothing.
TEST(PointLight, LiesInAFaceThatItIsABillionthFrom) {
  EXPECT_NEAR(sum(light(LightKind::kPoint, 8, {1.05e-9, 4.5, 5.5})), 8, 1e-6);
  EXPECT_NEAR(sum(light(LightKind::kPoint, 8, {0.95e-9, 4.5, 5.5})), 4, 1e-6);
}

TEST(PointLight, OutsideGivesTheSolidAngleOfTheVolume) {
  EXPECT_NEAR(sum(light(LightKind::kPoint, 1, {-5, 4, 5})), face_angle(5, 8, 10) / (4 * pi), 1e-9);
  EXPECT_NEAR(sum(light(LightKind::kPoint, 1, {6, 4, 13})), face_angle(3, 12, 8) / (4 * pi), 1e-9);
}

TEST(PointLight, SeesTheFacesOfALongVoxel) {
  const std::array<std::uint32_t, 3> spacing{wire::kSpacingOne, wire::kSpacingOne * 5 / 2, wire::kSpacingOne};
  EXPECT_NEAR(sum(light(LightKind::kPoint, 1, {-5, 4, 5}), kBox, spacing), face_angle(5, 20, 10) / (4 * pi), 1e-9);
  EXPECT_NEAR(sum(light(LightKind::kPoint, 1, {3, 3, 3}), kBox, spacing), 1, 1e-9);
}

TEST(PointLight, CarriesFourTimesTooMuchAsPrinted) {
  IlluminateCommand inside = light(LightKind::kPoint, 1, {6, 4, 5}, 64);
  inside.rules = EnergyRules::kAsPrinted;
  EXPECT_NEAR(sum(inside), 4, 0.02);
  IlluminateCommand outside = light(LightKind::kPoint, 1, {-5, 4, 5}, 64);
  outside.rules = EnergyRules::kAsPrinted;
  EXPECT_NEAR(sum(outside), face_angle(5, 8, 10) / pi, 0.005);
}

// Equation 1, E cos / (k pi r^2), a voxel over a face: r = 1 / cos.
TEST(PointLight, AsPrintedHasEquationOneMoreThanHalfAVoxelAway) {
  IlluminateCommand command = light(LightKind::kPoint, 1000, {6, 4, 1}, 16);
  command.rules = EnergyRules::kAsPrinted;
  const LightingRays rays(command, kBox, kEven, 24, 1);
  int down = 0;
  for (std::uint64_t i = 0; i < rays.count(); ++i) {
    const auto ray = rays.make(i);
    const double cosine = ray ? -ray->direction[2] / 16384.0 : 0;
    if (cosine < 0.8) continue;  // these go through the lower face
    ++down;
    EXPECT_NEAR(rays.energy(i), 1000 * cosine * cosine * cosine / (16 * pi), 0.02);
  }
  EXPECT_GT(down, 20);
}

TEST(PointLight, StaysBoundedAsPrintedOnAndNearAFace) {
  for (const double depth : {-1e-3, -1e-9, 0.0, 1e-12, 1e-6, 0.01}) {
    IlluminateCommand command = light(LightKind::kPoint, 1, {depth, 4.25, 5.75}, 16);
    command.rules = EnergyRules::kAsPrinted;
    EXPECT_LT(sum(command), 4.5) << depth;
  }
}

TEST(DirectionalLight, GivesIrradianceTimesProjectedArea) {
  for (const Vector& towards : {Vector{0, 0, 3}, {-2, 0, 0}, {1, -2, 2}, {1e-3, 1, 0}}) {
    IlluminateCommand command = light(LightKind::kDirectional, 2, {});
    command.u = towards;
    const double size = length(towards);
    const double area = (std::abs(towards[0]) * 80 + std::abs(towards[1]) * 120 + std::abs(towards[2]) * 96) / size;
    EXPECT_NEAR(sum(command), 2 * area, 1e-9 * area);
    const std::array<std::uint32_t, 3> spacing{wire::kSpacingOne * 2, wire::kSpacingOne, wire::kSpacingOne};
    const double wider = (std::abs(towards[0]) * 80 + std::abs(towards[1]) * 240 + std::abs(towards[2]) * 192) / size;
    EXPECT_NEAR(sum(command, kBox, spacing), 2 * wider, 1e-9 * wider);
  }
}

TEST(RectangleLight, GivesTheFormFactorOfParallelSquares) {
  const Point cube{16 * wire::kVoxel, 16 * wire::kVoxel, 16 * wire::kVoxel};
  // One edge away, shining along +z onto the -z face; the faces at its sides lie edge-on and beyond the horizon.
  EXPECT_NEAR(sum(rectangle({0, 0, -16}, {16, 0, 0}, {0, 16, 0}, 64), cube), .199825, 2e-4);
  EXPECT_EQ(sum(rectangle({0, 0, -16}, {0, 16, 0}, {16, 0, 0}, 4), cube), 0) << "shines the other way";
}

TEST(RectangleLight, LosesNothingInsideOrOnAFace) {
  for (const double z : {0.0, 1e-6, 0.3, 5.0, 9.5})
    EXPECT_NEAR(sum(rectangle({3, 2, z}, {5, 0, 0}, {0, 4, 0}, 64)), 1, 0.01) << z;  // z = 10 would shine out
  EXPECT_NEAR(sum(rectangle({3, 2, -1e-6}, {5, 0, 0}, {0, 4, 0}, 1024)), 1, 0.01);
  EXPECT_NEAR(sum(rectangle({3, 2, 9}, {5, 1, 0.5}, {0, 4, -2}, 64)), 1, 0.01) << "tilted";
}

TEST(SphereLight, GivesAllItsEnergyInsideAndItsShareOutside) {
  IlluminateCommand inside = light(LightKind::kSphere, 1, {6, 4, 5}, 64);
  inside.u[0] = 2;
  EXPECT_NEAR(sum(inside), 1, 0.01);
  // A Lambert sphere looks alike from all sides: far away it is a point light.
  IlluminateCommand outside = light(LightKind::kSphere, 1, {-60, 4, 5}, 64);
  outside.u[0] = 2;
  const double point = sum(light(LightKind::kPoint, 1, {-60, 4, 5}));
  EXPECT_NEAR(sum(outside) / point, 1, 0.02);
}

TEST(SphereLight, WithItsEquatorInAFaceSendsInFiveEighths) {
  // All of the inner half; of the outer half's points, whose normals stand at an angle t over the plane, the share
  // (1 - sin t) / 2 that dips below their horizon: a quarter of that half if the face had no end.
  IlluminateCommand half = light(LightKind::kSphere, 1, {6, 4, 0}, 1024);
  half.u[0] = 0.1;
  EXPECT_NEAR(sum(half), 0.625, 0.01);
}

TEST(LightingRays, StartInTheVolumeAndRunInward) {
  const std::array<std::uint32_t, 3> spacing{wire::kSpacingOne, wire::kSpacingOne * 3, wire::kSpacingOne / 2};
  for (const Vector& at : {Vector{-7, -3, 20}, {6, 4, 5}, {0, 0, 0}, {1e8, -1e8, 1e8}, {3, 8.01, 3}}) {
    const IlluminateCommand command = light(LightKind::kPoint, 1e6 * (1 + dot(at, at)), at, 8);
    const LightingRays rays(command, kBox, spacing, 24, 1);
    std::uint64_t made = 0;
    for (std::uint64_t i = 0; i < rays.count(); ++i) {
      const auto ray = rays.make(i);
      if (!ray) continue;
      ++made;
      ASSERT_EQ(ray->host_id(), i);
      ASSERT_EQ(ray->flags, wire::kLightingRay);
      double norm = 0, past = 0;
      bool on_face = false;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto position = static_cast<std::int32_t>(ray->position[axis]);
        ASSERT_LE(position, kBox[axis]);
        on_face |= position == 0 ? ray->direction[axis] >= 0 : position == kBox[axis] && ray->direction[axis] <= 0;
        norm += std::pow(ray->direction[axis] / 16384.0, 2);
        // The line runs through the light: the cross product of direction and (position - light) is small.
        const double reach = position / 16384.0 - at[axis];
        past = std::max(past, std::abs(reach));
      }
      ASSERT_NEAR(norm, 1, 2e-4);
      const bool inside = past < 1e-4;
      ASSERT_TRUE(on_face || inside) << i;
    }
    EXPECT_GT(made, 100u);
  }
}

TEST(LightingRays, LieOnLinesFromTheLight) {
  const Vector at{-7, 3, 15};
  const std::array<std::uint32_t, 3> spacing{wire::kSpacingOne, wire::kSpacingOne * 3, wire::kSpacingOne / 2};
  const LightingRays rays(light(LightKind::kPoint, 1e6, at, 2), kBox, spacing, 24, 9);
  for (std::uint64_t i = 0; i < rays.count(); ++i) {
    const auto ray = rays.make(i);
    if (!ray) continue;
    Vector from{}, along{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      from[axis] = ray->position[axis] / 16384.0 - at[axis];
      along[axis] = ray->direction[axis] / 16384.0;
    }
    ASSERT_LT(length(cross(from, along)) / length(from), 1e-4);
    ASSERT_GT(dot(from, along), 0);
  }
}

TEST(LightingRays, RoundEnergyWithoutBias) {
  // 592 cells x 64 rays of about 1/4 unit each: every word is 0, 1 or 2.
  const IlluminateCommand command = light(LightKind::kPoint, 10'000, {6, 4, 5}, 64);
  const LightingRays rays(command, kBox, kEven, 8, 3);
  double words = 0, variance = 0;
  for (std::uint64_t i = 0; i < rays.count(); ++i) {
    const double energy = rays.energy(i), fraction = energy - std::floor(energy);
    variance += fraction * (1 - fraction);
    const auto ray = rays.make(i);
    if (!ray) continue;
    ASSERT_EQ(ray->colour[0], 0);
    const int word = ray->colour[1] | ray->colour[2] << 12;
    ASSERT_LT(std::abs(word - energy), 1);
    words += word;
  }
  EXPECT_LT(std::abs(words - 10'000), 4 * std::sqrt(variance));
  EXPECT_GT(variance, 1000);
}

// The numbers that round are hashes of the seed and the light's geometry, of a stream of their own (1), and of the
// ray's number: images stay the same from release to release.
TEST(LightingRays, RoundEnergyByTheHashOfTheirNumber) {
  const IlluminateCommand command = light(LightKind::kPoint, 10'000, {6, 4, 5}, 4);
  const LightingRays rays(command, kBox, kEven, 8, 3);
  std::uint64_t seed = 3;
  for (const double x : {6., 4., 5., 0., 0., 0., 0., 0., 0.}) seed = hash(seed, std::bit_cast<std::uint64_t>(x));
  for (std::uint64_t i = 0; i < rays.count(); ++i) {
    const double rounded = std::floor(rays.energy(i) + to_unit(hash(hash(seed, 1), i)));
    const auto ray = rays.make(i);
    ASSERT_EQ(ray ? ray->colour[1] : 0, rounded) << i;
  }
}

TEST(LightingRays, CutEnergyOffAtFullScale) {
  for (const unsigned bits : {4u, 8u, 24u}) {
    const LightingRays rays(light(LightKind::kPoint, 1e15, {6, 4, 5}, 1), kBox, kEven, bits, 3);
    const auto ray = rays.make(7);
    ASSERT_TRUE(ray);
    EXPECT_EQ(ray->colour[1] | ray->colour[2] << 12, (1 << bits) - 1);
  }
}

TEST(LightingRays, FlagHighAlbedo) {
  IlluminateCommand command = light(LightKind::kPoint, 1e6, {6, 4, 5}, 1);
  command.albedo = wire::Albedo::kHigh;
  EXPECT_EQ(LightingRays(command, kBox, kEven, 4, 3).make(0)->flags, wire::kLightingRay | wire::kHighAlbedo);
}

TEST(LightingRays, AreTheSameInPartsAndInAnyOrder) {
  IlluminateCommand whole = rectangle({3, 2, 9}, {5, 1, 0.5}, {0, 4, -2}, 8);
  whole.energy = 20'000;
  const LightingRays rays(whole, kBox, kEven, 8, 3);
  std::vector<std::optional<wire::Ray>> expected(rays.count());
  for (std::uint64_t i = rays.count(); i-- > 0;) expected[i] = rays.make(i);

  for (const auto& [first, count] : {std::pair{0u, 3u}, {3u, 1u}, {4u, 4u}}) {
    IlluminateCommand part = whole;
    part.first = first;
    part.count = count;
    const LightingRays some(part, kBox, kEven, 8, 3);
    for (std::uint64_t i = 0; i < some.count(); ++i)
      ASSERT_EQ(some.make(i), expected[i / count * 8 + first + i % count]) << first << " " << i;
  }
  std::thread other([&] {
    for (std::uint64_t i = 0; i < rays.count(); ++i) ASSERT_EQ(rays.make(i), expected[i]);
  });
  for (std::uint64_t i = 0; i < rays.count(); ++i) ASSERT_EQ(rays.make(i), expected[i]);
  other.join();
}

TEST(LightingRays, DifferBetweenSeedsAndBetweenLights) {
  const LightingRays a(light(LightKind::kPoint, 1e5, {6, 4, 5}), kBox, kEven, 8, 3);
  const LightingRays seed(light(LightKind::kPoint, 1e5, {6, 4, 5}), kBox, kEven, 8, 4);
  const LightingRays moved(light(LightKind::kPoint, 1e5, {6, 4, 6}), kBox, kEven, 8, 3);
  int same_seed = 0, same_light = 0;
  for (std::uint64_t i = 0; i < a.count(); ++i) {
    same_seed += a.make(i)->direction == seed.make(i)->direction;
    same_light += a.make(i)->colour == moved.make(i)->colour && a.make(i)->direction == moved.make(i)->direction;
  }
  EXPECT_LT(same_seed, 3);
  EXPECT_LT(same_light, 3);
}

// The fault of a good rectangle light that `spoil` has changed; "" if none.
std::string fault_of(const auto& spoil) {
  IlluminateCommand command = rectangle({3, 2, 9}, {5, 1, 0}, {0, 4, 0}, 8);
  spoil(command);
  return LightingRays::fault(command, kBox).value_or("");
}

TEST(LightingFaults, NameTheField) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  using C = IlluminateCommand;
  EXPECT_EQ(fault_of([](C&) {}), "");
  EXPECT_EQ(fault_of([](C& c) { c.kind = static_cast<LightKind>(4); }), "kind: expected 0..3, got 4");
  EXPECT_EQ(fault_of([](C& c) { c.albedo = static_cast<wire::Albedo>(2); }), "albedo: expected 0 or 1, got 2");
  EXPECT_EQ(fault_of([](C& c) { c.rules = static_cast<EnergyRules>(9); }), "rules: expected 0 or 1, got 9");
  EXPECT_EQ(fault_of([](C& c) { c.rays_per_voxel = 0; }), "rays_per_voxel: expected 1..4096, got 0");
  EXPECT_EQ(fault_of([](C& c) { c.rays_per_voxel = 4097; }), "rays_per_voxel: expected 1..4096, got 4097");
  EXPECT_EQ(fault_of([](C& c) { c.count = 0; }), "count: expected at least 1, got 0");
  EXPECT_EQ(fault_of([](C& c) { c.first = 0xFFFF'FFFF; }),
            "first + count: expected at most rays_per_voxel, 8, got 4294967303");
  EXPECT_EQ(fault_of([](C& c) { c.energy = -1; }), "energy: expected a finite number of at least 0, got -1.000000");
  EXPECT_NE(fault_of([](C& c) { c.energy = kNan; }), "");
  EXPECT_EQ(fault_of([](C& c) { c.position[1] = kNan; }), "position: expected finite numbers of -1e9 to 1e9");
  EXPECT_EQ(fault_of([](C& c) { c.position[1] = -1e9; }), "");
  EXPECT_EQ(fault_of([](C& c) { c.position[1] = -1.0000001e9; }), "position: expected finite numbers of -1e9 to 1e9");
  EXPECT_EQ(fault_of([](C& c) { c.u[2] = kNan; }),
            "u: expected an edge of the rectangle, finite numbers of -1e9 to 1e9");
  EXPECT_EQ(fault_of([](C& c) { c.v = {}; }), "u, v: expected edges of a rectangle, of at least 1e-6");
  EXPECT_EQ(fault_of([](C& c) { c.v = {10, 2, 0}; }), "u, v: expected edges of a rectangle, got parallel vectors");
  EXPECT_EQ(fault_of([](C& c) { c.kind = LightKind::kSphere, c.u[0] = -2; }),
            "u.x: expected a sphere's radius of 1e-6 to 1e9, got -2.000000");
  EXPECT_EQ(fault_of([](C& c) { c.kind = LightKind::kDirectional, c.u = {}; }),
            "u: expected a vector to the light, got 0");
  const IlluminateCommand many = light(LightKind::kPoint, 1, {}, 4096);
  EXPECT_EQ(LightingRays::fault(many, {511 * wire::kVoxel, 511 * wire::kVoxel, 511 * wire::kVoxel}),
            "rays_per_voxel: expected at most 2^32 - 1 rays on all face cells, got 6417309696");
}

}  // namespace
}  // namespace gicube::emu
