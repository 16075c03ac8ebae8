// Common parts of the path tracer's tests.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "path_tracer.h"
#include "reference/test_scene.h"

namespace gicube::reference::paths {

// A test's figures are drawn from one seed, so it passes always or never; 3 standard errors are exceeded by chance once
// in 370.
inline void expect_near(const Estimate& found, double truth, const char* what, double allowed = 0) {
  EXPECT_NEAR(found.mean, truth, 3 * found.error + allowed + 1e-12) << what << ", standard error " << found.error;
}

// A scene around the volume of `test`, which must outlive it.
inline PathScene path_scene(const TestScene& test, const Material& material) {
  PathScene out;
  out.scene = test.scene;
  out.materials[0] = material;
  return out;
}

inline void add_light(PathScene& scene, const Light& light, const Rgb& colour = {1, 1, 1}) {
  scene.lights.push_back(light);
  scene.light_colours.push_back(colour);
}

inline Material isotropic(double albedo) { return {.scattering = albedo, .bsdf = Bsdf::kIsotropic}; }
inline Material forward(double albedo, float g) {
  return {.scattering = albedo, .bsdf = Bsdf::kTrap, .routine = kHenyeyGreensteinRoutine, .parameters = {g}};
}

constexpr Vec3 kAhead{0, 0, 1};

}  // namespace gicube::reference::paths
