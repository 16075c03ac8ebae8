#include "gicube/scene/material.h"

#include "gicube/scene/error.h"
#include "gicube/scene/voxeliser.h"
#include "test.h"

namespace gicube::scene {
namespace {

std::string fault_of(const SceneMaterial& material) {
  return message_of<InputError>([&] { check(material); });
}

SceneMaterial with(const Material& optics) { return {"m", 0, {}, optics, {1, 1, 1}}; }

TEST(SceneMaterial, OfFogTransmitsAsItsExtinctionSaysAtAnyVoxelSize) {
  for (const double voxel : {0.1, 0.02}) {
    const TransferFunction look = transfer_function_of(FogLook{{1, 1, 1}, 3}, voxel).function;
    const double opacity = look.opacity_at(kFogDensity * kMaxDensity);
    EXPECT_NEAR(std::pow(1 - opacity, 1 / voxel), std::exp(-3), 1e-3);
    EXPECT_EQ(look.opacity_at(0), 0);
  }
}

TEST(SceneMaterial, OfASolidIsOpaqueFromShortlyInsideItsSurface) {
  const TransferFunction look = transfer_function_of(SolidLook{{1, 0.5, 0}, 1}, 0.1).function;
  EXPECT_EQ(look.opacity_at(kFogDensity * kMaxDensity), 0);
  EXPECT_NEAR(look.opacity_at(0.5 * kMaxDensity), 0.5, 1e-9);
  EXPECT_EQ(look.opacity_at(kMaxDensity), 1);
  EXPECT_EQ(look.colour_at(kMaxDensity), (Colour{1, 0.5, 0}));
}

TEST(SceneMaterial, IsCheckedByField) {
  EXPECT_EQ(fault_of(with({0.5, Bsdf::kDiffuse})), "none");
  EXPECT_THAT(fault_of(with({1.5, Bsdf::kDiffuse})), StartsWith("scattering: expected 0 to 1, got 1.5"));
  EXPECT_THAT(fault_of(with({std::nan(""), Bsdf::kDiffuse})), StartsWith("scattering"));
  EXPECT_THAT(fault_of(with({0.5, Bsdf::kNone})), StartsWith("bsdf"));
  EXPECT_THAT(fault_of(with({0.5, Bsdf::kDullReflection, 16})), StartsWith("gloss: expected 0 to 15.99"));
  EXPECT_THAT(fault_of(with({0.5, Bsdf::kSpecular, 1})), StartsWith("gloss"));
  EXPECT_THAT(fault_of(with({0.5, Bsdf::kSpecular, 0, false, 1})), StartsWith("routine"));
  EXPECT_THAT(fault_of(with({0.5, Bsdf::kSpecular, 0, false, 0, false, {1}})), StartsWith("parameter"));
  EXPECT_THAT(fault_of(with({0.5, Bsdf::kTrap, 0, false, 0, false, std::vector<float>(33)})), StartsWith("parameter"));
  EXPECT_THAT(fault_of(with({0.5, Bsdf::kTrap, 0, false, 0, false, {std::numeric_limits<float>::infinity()}})),
              StartsWith("parameter"));
  EXPECT_THAT(fault_of({"m", 4, {}, {}, {1, 1, 1}}), StartsWith("tag"));
  EXPECT_THAT(fault_of({"m", 0, {}, {}, {1, 2, 1}}), StartsWith("scattering_colour"));
  EXPECT_THAT(fault_of({"m", 0, {}, {}, {1, 1, 1}, -1}), StartsWith("emission: expected a number, 0 or more, got -1"));
  EXPECT_THAT(fault_of({"m", 0, {}, {}, {1, 1, 1}, 3, {1, 1, -0.5}}), StartsWith("emission_colour"));
  EXPECT_THAT(fault_of({"m", 0, FogLook{{1, 1, 1}, 0}, {}, {1, 1, 1}}), StartsWith("fog.extinction"));
  EXPECT_THAT(fault_of({"m", 0, SolidLook{{1, 1, 1}, 2}, {}, {1, 1, 1}}), StartsWith("solid.opacity"));
}

TEST(SceneMaterial, FindsBsdfsAndRoutinesByName) {
  EXPECT_EQ(bsdf_named("dull_scattering"), Bsdf::kDullScattering);
  EXPECT_THROW(bsdf_named("mirror"), InputError);
  EXPECT_EQ(routine_named("fresnel"), kFresnelRoutine);
  EXPECT_EQ(routine_named("host"), 255);
  EXPECT_EQ(routine_named("9"), 9);
  for (const char* name : {"", "256", "-1", "9x", "glass"}) EXPECT_THROW(routine_named(name), InputError) << name;
}

}  // namespace
}  // namespace gicube::scene
