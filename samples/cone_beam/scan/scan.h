// A scan as the methods take it: line integrals, view after view by ascending angle.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cone_beam/geometry.h"
#include "cone_beam/scan/description.h"
#include "cone_beam/scan/flat_field.h"

namespace gicube::samples {

struct Scan {
  ConeGeometry geometry;
  Vec3 centre;  // of the volume, in the scan's own coordinates
  Projections projections;
  std::size_t views_read = 0;  // in the files
  std::size_t repeated = 0;    // of them at an angle that another one has too: their mean is taken
  FlatFieldReport flat_field;
  std::vector<std::string> warnings;  // of what the projections can't show
};

// A .json of CTSimU, a folder of projection matrices, or a scan file. `projections`: in place of those that the scan names.
// Throws FileError, InputError.
ScanDescription read_description(const std::filesystem::path& path, const StackFiles& projections = {});

// Gives the description's volume what it leaves open: voxels as large as a pixel seen at the axis, and as many as the detector sees.
void complete_volume(ScanDescription& description);

// Reads and corrects the projections. Throws FileError (files; another number of views than angles, of pixels than the detector's),
// InputError (flat and dark fields), BadArgument (the geometry). Warnings: an arc too short for its fan, an object that reaches
// beyond the detector, absorbed rays, dead pixels.
Scan load_scan(const ScanDescription& description);

// The other way round: values as the files of `description` hold them. `projections` in the order of its angles.
std::vector<float> as_stored(const Projections& projections, const ScanDescription& description);

}  // namespace gicube::samples
