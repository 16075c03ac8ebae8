#include "encode/host_ray.h"
#include "encode/camera.h"

#include <rapidcheck.h>

#include "refusal.h"
#include "test.h"

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

TEST(HostRay, FromASourceOutsideIsClippedToTheVolume) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr Dims kDims{10, 8, 6};
  const auto through =
      clip_to_volume({.id = 7, .position = {-10, 4, 3}, .direction = {2, 0, 0}, .length = kInfinity}, kDims);
  ASSERT_TRUE(through);
  EXPECT_EQ(through->id, 7u);
  EXPECT_EQ(through->position, (Vec3{0, 4, 3}));
  EXPECT_EQ(through->length, 9);
  const auto ends_inside = clip_to_volume(ray_between(0, {-3, 2, 1}, {5, 2, 1}), kDims);
  ASSERT_TRUE(ends_inside);
  EXPECT_EQ(ends_inside->position, (Vec3{0, 2, 1}));
  EXPECT_EQ(ends_inside->length, 5);
  const HostRay within = ray_between(0, {1, 2, 3}, {4, 6, 3});
  ASSERT_TRUE(clip_to_volume(within, kDims));
  EXPECT_EQ(clip_to_volume(within, kDims)->position, within.position);
  EXPECT_NEAR(clip_to_volume(within, kDims)->length, 5, 1e-12);

  EXPECT_FALSE(clip_to_volume(ray_between(0, {-3, 2, 1}, {-1, 2, 1}), kDims)) << "it ends before the volume";
  EXPECT_FALSE(clip_to_volume({.position = {-3, 9, 1}, .direction = {1, 0, 0}, .length = kInfinity}, kDims));
  EXPECT_FALSE(clip_to_volume({.position = {12, 2, 1}, .direction = {1, 0, 0}, .length = kInfinity}, kDims));
  EXPECT_FALSE(clip_to_volume({.position = {-1, 1, 0}, .direction = {1, -1, 0}, .length = kInfinity}, kDims))
      << "an edge";
}

// What is left of rays through the volume begins and ends inside of it, on the same line.
TEST(HostRay, ThatIsClippedPassesItsCheck) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> anywhere(-40, 40);
  const RaySetup setup{.request = {.type = RayType::kIntegral}, .dims = {12, 9, 7}};
  int left = 0;
  for (int n = 0; n < 5000; ++n) {
    const HostRay whole = ray_between(0, {anywhere(random), anywhere(random), anywhere(random)},
                                      {anywhere(random), anywhere(random), anywhere(random)});
    const auto part = clip_to_volume(whole, setup.dims);
    if (!part) continue;
    ++left;
    EXPECT_EQ(refusal([&] { check(*part, 0, setup); }), "accepted");
    const Vec3 along = normalise(whole.direction), end = part->position + part->length * along;
    EXPECT_LT(length(cross(part->position - whole.position, along)), 1e-9);
    for (const auto& [value, size] : {std::pair{end.x, 12}, {end.y, 9}, {end.z, 7}}) {
      EXPECT_GE(value, -1e-9);
      EXPECT_LE(value, size - 1 + 1e-9);
    }
  }
  EXPECT_GT(left, 100);
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

HostRay ray_along(Vec3 direction, double length, double energy = 0) {
  HostRay ray;
  ray.direction = direction;
  ray.length = length;
  ray.energy = energy;
  return ray;
}

RaySetup setup_of(RayType type) {
  RaySetup setup;
  setup.request.type = type;
  setup.dims = {32, 32, 32};
  setup.energy_unit = 0.5;
  return setup;
}

TEST(HostRay, ASegmentsLengthIsTheNearestWord) {
  const RaySetup setup = setup_of(RayType::kSegment);
  EXPECT_EQ(to_wire(ray_along({1, 0, 0}, 3.6 / 65536), setup).colour_word(), 4u);
  EXPECT_EQ(to_wire(ray_along({1, 0, 0}, 1000.25), setup).colour_word(), 65552384u);
  EXPECT_EQ(to_wire(ray_along({1, 0, 0}, 3), setup_of(RayType::kFirstHit)).colour_word(), 0u);
  EXPECT_EQ(to_wire(ray_along({1, 0, 0}, 3, 1), setup_of(RayType::kOpacity)).colour_word(), 3u << 16);
}

TEST(HostRay, ADepositsEnergyIsInUnitsWithTwelveFractionBits) {
  RaySetup setup = setup_of(RayType::kDeposit);
  setup.request.lifetime = 77;
  const wire::Ray low = to_wire(ray_along({1, 0, 0}, 0, 0.85), setup);  // 1.7 units: 6963.2
  EXPECT_EQ(low.colour_word(), 6963u);
  EXPECT_EQ(to_wire(ray_along({1, 0, 0}, 0, 0.5 * 6963.6 / 4096), setup).colour_word(), 6964u);
  EXPECT_EQ(low.flags, wire::kHostRay | wire::kLightingRay);
  EXPECT_EQ(low.lifetime, 77);
  setup.request.albedo = Albedo::kHigh;
  EXPECT_EQ(to_wire(ray_along({1, 0, 0}, 0, 1), setup).flags, wire::kHostRay | wire::kLightingRay | wire::kHighAlbedo);
}

// Length 3 in steps of at most 0.5: six steps of 0.5 voxels, each 1 long where voxels are twice as long.
TEST(HostRay, ABackprojectedAmountIsThatOfAStepsPhysicalLength) {
  RaySetup setup = setup_of(RayType::kBackproject);
  setup.sampling.step = 0.5;
  setup.spacing = {2, 1, 1};
  const HostRay ray = ray_along({1, 0, 0}, 3, 100.3);
  EXPECT_EQ(to_wire(ray, setup).opacity, 201u);  // 200.6
  HostRay negative = ray;
  negative.energy = -100.3;
  EXPECT_EQ(to_wire(negative, setup).opacity, (1u << 24) - 201);
  EXPECT_EQ(max_moved(to_wire(negative, setup), setup), 201u * 6);
  setup.request.words = SumWords::kIrradiance;
  EXPECT_EQ(to_wire(ray, setup).opacity, 821658u);  // 200.6 * 4096 = 821657.6
  EXPECT_EQ(max_moved(to_wire(ray, setup), setup), 0u);
  EXPECT_EQ(to_wire(ray_along({1, 0, 0}, 0, 5), setup).opacity, 0u);
}

TEST(HostRay, AnIntegralsUnitIsADensityStepTimesAStepsPhysicalLength) {
  RaySetup setup = setup_of(RayType::kIntegral);
  setup.sampling.step = 0.5;
  setup.spacing = {1, 1, 3};
  setup.range = {-1, 4};
  const HostRay ray = ray_along({0, 0, 2}, 3.2);  // seven steps
  EXPECT_NEAR(integral_unit(ray, setup), 5 / (8.0 * 4095) * (3.2 / 7) * 3, 1e-12);
  wire::Ray packet;
  packet.set_colour_word(1000);
  EXPECT_EQ(integral_from_wire(packet, 0.25).integral, 250);
  EXPECT_EQ(integral_from_wire(packet, 0.25).colour, (std::array<double, 3>{}));
}

TEST(HostRay, AThresholdIsTheNearestWordAndNeverNothing) {
  EXPECT_EQ(opacity_word(1), wire::kOpacityOne);
  EXPECT_EQ(opacity_word(0.5), 8388608u);   // 8388607.5
  EXPECT_EQ(opacity_word(0.25), 4194304u);  // 4194303.75
  EXPECT_EQ(opacity_word(1e-12), 1u);
  View view;
  view.step = 0.3;
  EXPECT_EQ(step_word(view), 19661u);  // 19660.8
}

TEST(HostRay, AHeaderHasWhatItsTypeNeeds) {
  RayRequest request{.type = RayType::kFirstHit, .opacity = 0.5, .albedo = Albedo::kHigh, .words = SumWords::kSums};
  wire::TraceHeader header = trace_header(request, 17);
  EXPECT_EQ(header.count, 17u);
  EXPECT_EQ(header.type, wire::RayType::kFirstHit);
  EXPECT_EQ(header.opacity, 8388608u);
  EXPECT_EQ(header.albedo, wire::Albedo::kLow);
  EXPECT_EQ(header.words, wire::SumWords::kIrradiance);
  request.type = RayType::kIntegrate;
  EXPECT_EQ(trace_header(request, 1).opacity, 0u);
  request.type = RayType::kBackproject;
  EXPECT_EQ(trace_header(request, 1).words, wire::SumWords::kWhole);
  request.type = RayType::kDeposit;
  header = trace_header(request, 1);
  EXPECT_EQ(header.albedo, wire::Albedo::kHigh);
  EXPECT_EQ(header.rules, wire::EnergyRules::kConserving);
  EXPECT_EQ(header.words, wire::SumWords::kIrradiance);
}

TEST(HostRay, OfEqualPointsHasNoLengthAndRunsAlongZ) {
  const HostRay none = ray_between(4, {1, 2, 3}, {1, 2, 3}), way = ray_between(5, {1, 2, 3}, {1, 5, 7});
  EXPECT_EQ(none.length, 0);
  EXPECT_EQ(none.direction, (Vec3{0, 0, 1}));
  EXPECT_EQ(way.id, 5u);
  EXPECT_EQ(way.length, 5);
  EXPECT_EQ(way.direction, (Vec3{0, 3, 4}));
  EXPECT_EQ(way.position, (Vec3{1, 2, 3}));
}

template <typename Edit>
std::string refused_request(RayType type, Edit&& edit) {
  RayRequest request;
  request.type = type;
  edit(request);
  return refusal([&] { check(request); });
}

TEST(RayRequestCheck, AcceptsTheLimitsOfEachFieldAndNamesWhatIsBeyond) {
  const auto same = [](RayRequest&) {};
  for (int type = 0; type <= 6; ++type)
    EXPECT_EQ(refused_request(static_cast<RayType>(type), same), "accepted") << type;
  EXPECT_EQ(refused_request(static_cast<RayType>(7), same), "request.type: expected a RayType, got 7");
  EXPECT_EQ(refused_request(static_cast<RayType>(-1), same), "request.type: expected a RayType, got -1");
  for (const RayType type : {RayType::kFirstHit, RayType::kSegment, RayType::kOpacity}) {
    EXPECT_EQ(refused_request(type, [](RayRequest& r) { r.opacity = 1e-9; }), "accepted");
    EXPECT_EQ(refused_request(type, [](RayRequest& r) { r.opacity = 0; }),
              "request.opacity: expected more than 0, at most 1, got 0");
    EXPECT_EQ(refused_request(type, [](RayRequest& r) { r.opacity = 1.01; }),
              "request.opacity: expected more than 0, at most 1, got 1.01");
  }
  EXPECT_EQ(refused_request(RayType::kIntegrate, [](RayRequest& r) { r.opacity = 0; }), "accepted") << "not used";
  EXPECT_EQ(refused_request(RayType::kIntegrate, [](RayRequest& r) { r.step = 16; }), "accepted");
  EXPECT_EQ(refused_request(RayType::kIntegrate, [](RayRequest& r) { r.step = 1.0 / 64; }), "accepted");
  EXPECT_EQ(refused_request(RayType::kIntegrate, [](RayRequest& r) { r.step = 0.0156; }),
            "request.step: expected 0.015625..16, got 0.0156");
  EXPECT_EQ(refused_request(RayType::kIntegrate, [](RayRequest& r) { r.step = 17; }),
            "request.step: expected 0.015625..16, got 17");
  EXPECT_EQ(refused_request(RayType::kIntegrate, [](RayRequest& r) { r.words = static_cast<SumWords>(2); }),
            "request.words: expected a SumWords, got 2");
  EXPECT_EQ(refused_request(RayType::kBackproject, [](RayRequest& r) { r.words = SumWords::kIrradiance; }), "accepted");
  EXPECT_EQ(refused_request(RayType::kDeposit, [](RayRequest& r) { r.lifetime = 1023; }), "accepted");
  EXPECT_EQ(refused_request(RayType::kDeposit, [](RayRequest& r) { r.lifetime = 1024; }),
            "request.lifetime: expected 0..1023, got 1024");
  EXPECT_EQ(refused_request(RayType::kDeposit, [](RayRequest& r) { r.lifetime = -1; }),
            "request.lifetime: expected 0..1023, got -1");
  EXPECT_EQ(refused_request(RayType::kIntegrate, [](RayRequest& r) { r.lifetime = -1; }), "accepted") << "not used";
}

TEST(HostRayCheck, KeepsLengthAndEnergyWithinTheirWords) {
  const auto refused = [](RaySetup setup, double length, double energy) {
    return refusal([&] { check(ray_along({1, 0, 0}, length, energy), 2, setup); });
  };
  const RaySetup segment = setup_of(RayType::kSegment);
  EXPECT_EQ(refused(segment, 0, 0), "accepted");
  EXPECT_EQ(refused(segment, 4096, 0), "accepted");
  EXPECT_EQ(refused(segment, 4096.1, 0), "rays[2].length: expected 0..4096, got 4096.1");
  EXPECT_EQ(refused(segment, -1, 0), "rays[2].length: expected 0..4096, got -1");
  EXPECT_EQ(refused(segment, std::nan(""), 0), "rays[2].length: expected 0..4096, got nan");
  EXPECT_EQ(refused(segment, HUGE_VAL, 0), "rays[2].length: expected 0..4096, got inf");
  RaySetup deposit = setup_of(RayType::kDeposit);  // of units of 0.5
  EXPECT_EQ(refused(deposit, 0, 0.5 / 4096), "accepted");
  EXPECT_EQ(refused(deposit, 0, 0.49 / 4096).substr(0, 15), "rays[2].energy:");
  EXPECT_EQ(refused(deposit, 0, 127.5), "accepted");
  EXPECT_EQ(refused(deposit, 0, 127.6).substr(0, 15), "rays[2].energy:");
  deposit.request.albedo = Albedo::kHigh;
  EXPECT_EQ(refused(deposit, 0, 7.5), "accepted");
  EXPECT_EQ(refused(deposit, 0, 7.6).substr(0, 15), "rays[2].energy:");
  deposit.wide = true;
  EXPECT_EQ(refused(deposit, 0, 0.5 * 16777215), "accepted");
  EXPECT_EQ(refused(deposit, 0, 0.5 * 16777216).substr(0, 15), "rays[2].energy:");
  RaySetup sums = setup_of(RayType::kBackproject);
  sums.sampling.step = 1;
  EXPECT_EQ(refused(sums, 3, 0.5 * 8388607), "accepted");
  EXPECT_EQ(refused(sums, 3, -0.5 * 8388607), "accepted");
  EXPECT_EQ(refused(sums, 3, 0.5 * 8388608), "rays[2].energy: expected -4194303.5..4194303.5, got 4194304");
  EXPECT_EQ(refused(sums, 3, -0.5 * 8388608), "rays[2].energy: expected -4194303.5..4194303.5, got -4194304");
  EXPECT_EQ(refused(sums, 3, std::nan("")), "rays[2].energy: expected a finite number, got nan");
  sums.request.words = SumWords::kIrradiance;
  EXPECT_EQ(refused(sums, 3, 0), "accepted");
  EXPECT_EQ(refused(sums, 3, 1023), "accepted");
  EXPECT_EQ(refused(sums, 3, 1025).substr(0, 15), "rays[2].energy:");
  EXPECT_EQ(refused(sums, 3, -1).substr(0, 15), "rays[2].energy:");
}

TEST(SamplingCheck, NamesTheField) {
  const auto refused = [](const Sampling& sampling) { return refusal([&] { check(sampling); }); };
  EXPECT_EQ(refused({}), "accepted");
  EXPECT_EQ(refused({.looking = {}}), "request.sampling.looking: expected any length but 0, got 0");
  EXPECT_EQ(refused({.opacity_threshold = 1.5}), "request.sampling.opacity_threshold: expected 0..1, got 1.5");
  EXPECT_EQ(refused({.lifetime = 1024}), "request.sampling.lifetime: expected 0..1023, got 1024");
  EXPECT_EQ(refused({.cut_planes = {{}}}), "request.sampling.cut_planes[0].normal: expected any length but 0, got 0");
  EXPECT_EQ(refused({.cut_planes = std::vector<CutPlane>(7, {{1, 0, 0}, 0})}),
            "request.sampling.cut_planes: expected at most 6, got 7");
}

TEST(Sampling, OfAViewIsThatOfItsRays) {
  View view;
  view.eye = {3, 4, -100}, view.look_at = {16, 16, 16};
  view.step = 0.25, view.jitter = true, view.leap = false, view.seed = 9, view.lifetime = 3;
  view.cut_planes = {{{0, 0, 1}, 5}};
  view.opacity_threshold = 0.5, view.exposure = 2, view.shade = false;
  view.irradiance = view.incident = view.scatter = view.high_albedo = true;
  const View made = view_of({.step = 0.25, .leap = false, .sampling = sampling_of(view)});
  EXPECT_EQ(made.jitter, view.jitter);
  EXPECT_EQ(made.seed, view.seed);
  EXPECT_EQ(made.lifetime, view.lifetime);
  EXPECT_EQ(made.opacity_threshold, view.opacity_threshold);
  EXPECT_EQ(made.exposure, view.exposure);
  EXPECT_EQ(made.step, view.step);
  EXPECT_EQ(made.leap, view.leap);
  EXPECT_FALSE(made.shade);
  EXPECT_TRUE(made.irradiance && made.incident && made.scatter && made.high_albedo);
  ASSERT_EQ(made.cut_planes.size(), 1u);
  EXPECT_EQ(made.cut_planes[0].offset, 5);
  EXPECT_EQ(towards_eye(made, {1, 2, 3}), towards_eye(view, {1, 2, 3}));
  EXPECT_NO_THROW(check(made));
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

TEST(ClipToVolume, KeepsARayThatRunsWithinAFace) {
  const Dims dims{32, 16, 8};
  for (const double x : {0.0, 31.0}) {
    const auto kept = clip_to_volume(HostRay{0, {x, 4, -5}, {0, 0, 1}, 40}, dims);
    ASSERT_TRUE(kept.has_value()) << x;
    EXPECT_EQ(kept->position.x, x);
    EXPECT_EQ(kept->position.z, 0);
  }
  EXPECT_FALSE(clip_to_volume(HostRay{0, {-0.001, 4, -5}, {0, 0, 1}, 40}, dims).has_value());
  EXPECT_FALSE(clip_to_volume(HostRay{0, {31.001, 4, -5}, {0, 0, 1}, 40}, dims).has_value());
}

}  // namespace
}  // namespace gicube
