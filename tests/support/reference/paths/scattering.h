// The ways to scatter of gicube/material.h in double precision: a random direction, and the density that it has.
#pragma once

#include "counter_random.h"
#include "path_scene.h"

namespace gicube::reference::paths {

// All directions are unit vectors in physical space; `normal` faces the ray, or is what it came from where there is no
// gradient.

// True if the direction is one of a few, which no connection meets: mirrors and glass.
bool is_sharp(const Material& material);

Vec3 scatter(const Material& material, Vec3 direction, Vec3 normal, bool enters, CounterRandom& random);

// Per solid angle, of a material that is not sharp; its integral over the sphere is 1.
double density(const Material& material, Vec3 direction, Vec3 normal, Vec3 out);

// Throws std::invalid_argument for routines that the board does not have built in.
void check(const Material& material);

// The reflectance of unpolarised light, by Fresnel's equations.
double fresnel_reflectance(double cosine, double from, double to);

}  // namespace gicube::reference::paths
