// gicube-subsurface: what it is asked for, and its work.
#pragma once

#include <filesystem>
#include <optional>
#include <ostream>
#include <string>

#include "scene/program/progress.h"
#include "subsurface/profile.h"
#include "transport/program/light_options.h"

namespace gicube::samples {

// `passes`: rays of the picture for each pixel.
struct SubsurfaceOptions : LightOptions<ProfileSettings> {
  std::filesystem::path material;  // a scene: the slab
  std::filesystem::path profile;   // CSV; empty: none
  std::string node;                // the surface with the profile; empty: the first
  double scale = 1;                // of the slab's units in the scene's
  double edge = 1;                 // of a triangle at most, in voxels of the scene
  int lamp_rays = 16;              // of each triangle
};

// Nothing if help or the version was asked for and went to `out`. Throws UsageError with one line.
std::optional<SubsurfaceOptions> parse_subsurface_options(int argc, const char* const* argv, std::ostream& out);

// Throws UsageError, InputError, FileError, and what Board throws.
void run(const SubsurfaceOptions& options, ProgressLine& progress);

}  // namespace gicube::samples
