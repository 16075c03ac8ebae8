// Materials, lights and the unit of energy, worked by hand.
#include "encode/lights.h"

#include "refusal.h"
#include "test.h"

namespace gicube {
namespace {

using std::numbers::pi;
const double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

template <typename Edit>
std::string refused_material(Edit&& edit) {
  Material material;
  edit(material);
  return refusal([&] { check(material); });
}
std::string refused(const Light& light) {
  return refusal([&] { check(light, "lights[3]"); });
}
template <typename Edit>
std::string refused_settings(Edit&& edit) {
  Illumination settings;
  edit(settings);
  return refusal([&] { check(settings, 0, 1); });
}

TEST(MaterialCheck, AcceptsTheLimitsOfEachFieldAndNamesWhatIsBeyond) {
  EXPECT_EQ(refused_material([](Material&) {}), "accepted");
  EXPECT_EQ(refused_material([](Material& m) {
              m.scattering = 1;
              m.gloss = 15.99;
              m.bsdf = Bsdf::kTrap;
              m.routine = 255;
              m.parameters.assign(32, 1.0F);
            }),
            "accepted");
  EXPECT_EQ(refused_material([](Material& m) { m.scattering = 1.001; }),
            "material.scattering: expected 0..1, got 1.001");
  EXPECT_EQ(refused_material([](Material& m) { m.scattering = -0.001; }),
            "material.scattering: expected 0..1, got -0.001");
  EXPECT_EQ(refused_material([](Material& m) { m.gloss = 16; }), "material.gloss: expected 0..15.99, got 16");
  EXPECT_EQ(refused_material([](Material& m) { m.gloss = -0.1; }), "material.gloss: expected 0..15.99, got -0.1");
  EXPECT_EQ(refused_material([](Material& m) { m.bsdf = static_cast<Bsdf>(7); }),
            "material.bsdf: expected a Bsdf, got 7");
  EXPECT_EQ(refused_material([](Material& m) { m.bsdf = static_cast<Bsdf>(-1); }),
            "material.bsdf: expected a Bsdf, got -1");
  EXPECT_EQ(refused_material([](Material& m) { m.routine = 256; }), "material.routine: expected 0..255, got 256");
  EXPECT_EQ(refused_material([](Material& m) { m.routine = -1; }), "material.routine: expected 0..255, got -1");
  EXPECT_EQ(refused_material([](Material& m) { m.parameters.assign(33, 0.0F); }),
            "material.parameters: expected at most 32, got 33");
  EXPECT_EQ(refused_material([](Material& m) {
              m.parameters = {1, std::numeric_limits<float>::infinity()};
            }),
            "material.parameters: expected a finite number, got inf");
}

TEST(LightCheck, NamesTheLightAndTheField) {
  EXPECT_EQ(refused(PointLight{{-5, 100, 3}, 1e-300}), "accepted");
  EXPECT_EQ(refused(PointLight{{0, 0, 0}, 0}).substr(0, 16), "lights[3].power:");
  EXPECT_EQ(refused(PointLight{{0, 0, 0}, -1}).substr(0, 16), "lights[3].power:");
  EXPECT_EQ(refused(PointLight{{0, kNan, 0}, 1}), "lights[3].position.y: expected a finite number, got nan");
  EXPECT_EQ(refused(DirectionalLight{{0, 0, -2}, 1}), "accepted");
  EXPECT_EQ(refused(DirectionalLight{{0, 0, 1}, kInf}).substr(0, 21), "lights[3].irradiance:");
  EXPECT_EQ(refused(DirectionalLight{{0, 0, kInf}, 1}), "lights[3].towards.z: expected a finite number, got inf");
  EXPECT_EQ(refused(DirectionalLight{{0, 0, 0}, 1}), "lights[3].towards: expected a direction, got the zero vector");
  EXPECT_EQ(refused(RectangleLight{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1}), "accepted");
  EXPECT_EQ(refused(RectangleLight{{kNan, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1}),
            "lights[3].corner.x: expected a finite number, got nan");
  EXPECT_EQ(refused(RectangleLight{{0, 0, 0}, {1, kNan, 0}, {0, 1, 0}, 1}),
            "lights[3].edge_u.y: expected a finite number, got nan");
  EXPECT_EQ(refused(RectangleLight{{0, 0, 0}, {1, 0, 0}, {0, 1, kNan}, 1}),
            "lights[3].edge_v.z: expected a finite number, got nan");
  EXPECT_EQ(refused(RectangleLight{{0, 0, 0}, {1, 2, 0}, {2, 4, 0}, 1}),
            "lights[3].edge_u x edge_v: expected a rectangle with an area, got none");
  EXPECT_EQ(refused(RectangleLight{{0, 0, 0}, {1e-5, 0, 0}, {0, 1e-6, 0}, 1}), "accepted");
  EXPECT_EQ(refused(SphereLight{{0, 0, 0}, 2, 1}), "accepted");
  EXPECT_EQ(refused(SphereLight{{0, 0, kNan}, 2, 1}), "lights[3].centre.z: expected a finite number, got nan");
  EXPECT_EQ(refused(SphereLight{{0, 0, 0}, 0, 1}).substr(0, 17), "lights[3].radius:");
}

TEST(IlluminationCheck, AcceptsTheLimitsOfEachFieldAndNamesWhatIsBeyond) {
  EXPECT_EQ(refused_settings([](Illumination& s) {
              s.rays_per_face_voxel = 4096;
              s.step = 16;
              s.lifetime = 1023;
            }),
            "accepted");
  EXPECT_EQ(refused_settings([](Illumination& s) {
              s.rays_per_face_voxel = 1;
              s.step = 1.0 / 64;
              s.lifetime = 0;
            }),
            "accepted");
  EXPECT_EQ(refused_settings([](Illumination& s) { s.rays_per_face_voxel = 0; }),
            "rays_per_face_voxel: expected 1..4096, got 0");
  EXPECT_EQ(refused_settings([](Illumination& s) { s.rays_per_face_voxel = 4097; }),
            "rays_per_face_voxel: expected 1..4096, got 4097");
  EXPECT_EQ(refused_settings([](Illumination& s) { s.step = 0.015; }), "step: expected 0.015625..16, got 0.015");
  EXPECT_EQ(refused_settings([](Illumination& s) { s.step = 16.1; }), "step: expected 0.015625..16, got 16.1");
  EXPECT_EQ(refused_settings([](Illumination& s) { s.lifetime = -1; }), "lifetime: expected 0..1023, got -1");
  EXPECT_EQ(refused_settings([](Illumination& s) { s.lifetime = 1024; }), "lifetime: expected 0..1023, got 1024");
}

TEST(MaterialRecord, HasTheNearestWordsAndTheFlags) {
  const wire::Material plain = material_record({.scattering = 0.5, .bsdf = Bsdf::kDullReflection, .gloss = 0.3});
  EXPECT_EQ(plain.bsdf, wire::Bsdf::kDullReflection);
  EXPECT_EQ(plain.scattering, 32768);  // 32767.5
  EXPECT_EQ(plain.gloss, 1229);        // 1228.8
  EXPECT_EQ(plain.flags, 0);
  EXPECT_EQ(plain.parameter_count, 0);
  const wire::Material trap = material_record({.scattering = 0.9,
                                               .bsdf = Bsdf::kTrap,
                                               .seen_through_scattering = true,
                                               .routine = 9,
                                               .surface = true,
                                               .parameters = {1.5F, -2.0F}});
  EXPECT_EQ(trap.scattering, 58982);  // 58981.5
  EXPECT_EQ(trap.flags, wire::kScattersRenderingRays | wire::kTrapAtSurface);
  EXPECT_EQ(trap.routine, 9);
  EXPECT_EQ(trap.parameter_count, 2);
  EXPECT_EQ(trap.parameters[0], 1.5F);
  EXPECT_EQ(trap.parameters[1], -2.0F);
  EXPECT_EQ(trap.parameters[2], 0.0F);
  EXPECT_EQ(material_record({.seen_through_scattering = true}).flags, wire::kScattersRenderingRays);
}

const LitBox kBox{{10, 10, 10}, {1, 1, 1}};

RayEnergy most(const Light& light, int k = 1, const LitBox& box = kBox, EnergyRules rules = EnergyRules::kConserving) {
  Illumination settings;
  settings.rays_per_face_voxel = k;
  settings.rules = rules;
  return max_energy(light, settings, box);
}

TEST(MaxEnergy, OfASunIsWhatFallsOnAVoxelsLargestFace) {
  EXPECT_DOUBLE_EQ(most(DirectionalLight{{0, 0, 1}, 6}).voxel, 6);
  EXPECT_DOUBLE_EQ(most(DirectionalLight{{0, 0, 1}, 6}, 4).ray, 1.5);
  EXPECT_DOUBLE_EQ(most(DirectionalLight{{0, 0, 1}, 6}, 4, {{10, 20, 30}, {1, 2, 3}}).voxel, 6 * 6);
}

TEST(MaxEnergy, OfAPointIsTheNearestCellsSolidAngle) {
  EXPECT_DOUBLE_EQ(most(PointLight{{5, 5, 5}, 100}).voxel, 100 / 25.0 / (4 * pi));
  EXPECT_DOUBLE_EQ(most(PointLight{{5, 5, 5}, 100}, 8).ray, 100 / 25.0 / (4 * pi) / 8);
  EXPECT_DOUBLE_EQ(most(PointLight{{5, 5, 5}, 100}, 1, kBox, EnergyRules::kAsPrinted).voxel, 100 / 25.0 / pi);
  EXPECT_DOUBLE_EQ(most(PointLight{{5, 8, 5}, 100}).voxel, 100 / 4.0 / (4 * pi));
  EXPECT_DOUBLE_EQ(most(PointLight{{2, 5, 5}, 100}).voxel, 100 / 4.0 / (4 * pi));
  EXPECT_DOUBLE_EQ(most(PointLight{{5, 5, 0}, 100}).voxel, 50) << "half of all goes into the face";
  EXPECT_DOUBLE_EQ(most(PointLight{{-3, 5, 14}, 100}).voxel, 100 / 25.0 / (4 * pi)) << "3 and 4 outside of an edge";
  // Places are voxels, distances physical: 5 voxels of 2.
  EXPECT_DOUBLE_EQ(most(PointLight{{5, 5, 5}, 100}, 1, {{20, 20, 20}, {2, 2, 2}}).voxel, 100 * 4 / 100.0 / (4 * pi));
}

TEST(MaxEnergy, OfAreasIsThatOfTheirNearestPlaceByLambertsLaw) {
  EXPECT_DOUBLE_EQ(most(RectangleLight{{4, 4, -7}, {2, 0, 0}, {0, 2, 5}, 100}).voxel, 100 / 4.0 / pi)
      << "its upper edge is 2 below";
  EXPECT_DOUBLE_EQ(most(RectangleLight{{4, 4, -7}, {2, 0, 5}, {0, 2, 0}, 100}).voxel, 100 / 4.0 / pi);
  EXPECT_DOUBLE_EQ(most(RectangleLight{{4, 4, -2}, {2, 0, -5}, {0, 2, 0}, 100}).voxel, 100 / 4.0 / pi);
  EXPECT_DOUBLE_EQ(most(SphereLight{{5, 5, -7}, 3, 100}).voxel, 100 / 16.0 / pi);
  EXPECT_DOUBLE_EQ(most(SphereLight{{5, 19, 5}, 3, 100}).voxel, 100 / 36.0 / pi);
  EXPECT_DOUBLE_EQ(most(SphereLight{{-8, 5, 5}, 3, 100}).voxel, 100 / 25.0 / pi);
  EXPECT_DOUBLE_EQ(most(SphereLight{{4, 5, 5}, 2, 100}, 2).ray, 100 / 4.0 / pi / 2) << "2 from the face x = 0, inside";
}

double middle(const Light& light, EnergyRules rules = EnergyRules::kConserving, const LitBox& box = kBox) {
  Illumination settings;
  settings.rules = rules;
  return flux_in_the_middle(light, settings, box);
}

TEST(FluxInTheMiddle, IsTheInverseSquareFromTheLightsCentre) {
  EXPECT_DOUBLE_EQ(middle(DirectionalLight{{1, 0, 0}, 7}), 7);
  EXPECT_DOUBLE_EQ(middle(PointLight{{5, 5, -15}, 100}), 100 / (4 * pi * 400));
  EXPECT_DOUBLE_EQ(middle(PointLight{{5, 5, -15}, 100}, EnergyRules::kAsPrinted), 100 / (pi * 400));
  EXPECT_DOUBLE_EQ(middle(PointLight{{5, 5, 4}, 100}), 100 / (4 * pi * 6.25)) << "no nearer than a quarter of the box";
  EXPECT_DOUBLE_EQ(middle(PointLight{{5, 5, 5}, 100}, EnergyRules::kConserving, {{20, 30, 40}, {2, 3, 4}}),
                   100 / (4 * pi * 25));
  EXPECT_DOUBLE_EQ(middle(SphereLight{{25, 5, 5}, 3, 100}), 100 / (4 * pi * 400));
  EXPECT_DOUBLE_EQ(middle(SphereLight{{25, 5, 5}, 3, 100}, EnergyRules::kAsPrinted), 100 / (4 * pi * 400));
}

TEST(FluxInTheMiddle, OfARectangleIsByItsCosineButNeverNothing) {
  EXPECT_DOUBLE_EQ(middle(RectangleLight{{4, 4, -10}, {2, 0, 0}, {0, 2, 0}, 100}), 100 / (pi * 225));
  EXPECT_DOUBLE_EQ(middle(RectangleLight{{4, 4, -10}, {0, 2, 0}, {2, 0, 0}, 100}), 100 * 0.1 / (pi * 225))
      << "it looks away";
  // Tilted by 45 degrees about its centre.
  EXPECT_NEAR(middle(RectangleLight{{4, 4, -11}, {2, 0, 0}, {0, 2, 2}, 100}), 100 * std::sqrt(0.5) / (pi * 225), 1e-12);
  EXPECT_DOUBLE_EQ(middle(RectangleLight{{4, 4, 5}, {2, 0, 0}, {0, 2, 0}, 100}), 100 / (pi * 6.25))
      << "in the middle itself";
}

double unit_of(const std::vector<Light>& lights, int k, Albedo albedo, bool wide) {
  Illumination settings;
  settings.rays_per_face_voxel = k;
  settings.albedo = albedo;
  return energy_unit(lights, settings, kBox, wide);
}

TEST(EnergyUnit, FillsTheBrightestRaysWordOrHalfOfAVoxels) {
  const Light sun = DirectionalLight{{0, 0, 1}, 1000}, small = DirectionalLight{{0, 1, 0}, 10};
  EXPECT_DOUBLE_EQ(unit_of({sun}, 1, Albedo::kLow, false), 1000 / 255.0);
  EXPECT_DOUBLE_EQ(unit_of({sun}, 1, Albedo::kHigh, false), 1000 / 15.0);
  EXPECT_DOUBLE_EQ(unit_of({small, sun, small}, 1, Albedo::kLow, false), 1000 / 255.0);
  EXPECT_DOUBLE_EQ(unit_of({sun, sun}, 100, Albedo::kLow, false), 2 * 2000 / 2047.0) << "two suns in a voxel";
  EXPECT_DOUBLE_EQ(unit_of({sun}, 1, Albedo::kHigh, true), 1000 / 16'777'215.0);
  EXPECT_DOUBLE_EQ(unit_of({sun}, 4096, Albedo::kLow, true), 2 * 1000 / 4'294'967'295.0);
}

TEST(LightCommand, CarriesEachKindOfLight) {
  Illumination settings;
  settings.rays_per_face_voxel = 9;
  settings.albedo = Albedo::kHigh;
  settings.rules = EnergyRules::kAsPrinted;
  using Words = std::array<double, 3>;
  const auto point = light_command(PointLight{{1, 2, 3}, 8}, settings, 0.5);
  EXPECT_EQ(point.kind, wire::LightKind::kPoint);
  EXPECT_EQ(point.albedo, wire::Albedo::kHigh);
  EXPECT_EQ(point.rules, wire::EnergyRules::kAsPrinted);
  EXPECT_EQ(point.rays_per_voxel, 9u);
  EXPECT_EQ(point.first, 0u);
  EXPECT_EQ(point.count, 9u);
  EXPECT_EQ(point.energy, 16);
  EXPECT_EQ(point.position, (Words{1, 2, 3}));
  const auto sun = light_command(DirectionalLight{{0, 3, 4}, 2}, {}, 1);
  EXPECT_EQ(sun.kind, wire::LightKind::kDirectional);
  EXPECT_EQ(sun.albedo, wire::Albedo::kLow);
  EXPECT_EQ(sun.rules, wire::EnergyRules::kConserving);
  EXPECT_EQ(sun.energy, 2);
  EXPECT_NEAR(sun.u[1], 0.6, 1e-15);
  EXPECT_NEAR(sun.u[2], 0.8, 1e-15);
  const auto area = light_command(RectangleLight{{1, 2, 3}, {4, 5, 6}, {7, 8, 10}, 2}, {}, 1);
  EXPECT_EQ(area.kind, wire::LightKind::kRectangle);
  EXPECT_EQ(area.position, (Words{1, 2, 3}));
  EXPECT_EQ(area.u, (Words{4, 5, 6}));
  EXPECT_EQ(area.v, (Words{7, 8, 10}));
  const auto sphere = light_command(SphereLight{{1, 2, 3}, 4, 2}, {}, 1);
  EXPECT_EQ(sphere.kind, wire::LightKind::kSphere);
  EXPECT_EQ(sphere.position, (Words{1, 2, 3}));
  EXPECT_EQ(sphere.u, (Words{4, 0, 0}));
}

}  // namespace
}  // namespace gicube
