// gicube-form-factors solve: from a scene to its light, files and a picture of it.
#pragma once

#include "form_factors/program/options.h"
#include "form_factors/radiosity/radiosity.h"
#include "scene/program/progress.h"

namespace gicube::samples {

// Light that the scene's materials send out, as the solver counts it: of solids and scans a unit of surface, of fogs a unit of
// volume, which is brought from the scene's units to voxels. Powers stay per unit of the scene's area.
Emissions emissions_of(const Scene& scene, const SceneSetup& setup);

// Writes what the options ask for, and prints what it came to. Throws UsageError, InputError, FileError, what Board throws.
void solve(const SolveOptions& options, ProgressLine& progress);

}  // namespace gicube::samples
