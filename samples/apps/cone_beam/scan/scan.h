// A scan as the methods take it: line integrals, view after view by ascending angle.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cone_beam/scan/description.h"
#include "cone_beam/scan/formats.h"

namespace gicube::samples {

struct FlatFieldReport {
  std::size_t absorbed = 0;  // values without any light left, taken as half of the smallest that can be measured
  // Pixels without light: in the flat field; and in all views, in gaps of up to four pixels. They get the mean of those
  // beside them.
  std::size_t dead = 0, unlit = 0;
};
// From intensities to line integrals, in place: -ln((p - dark) / (flat - dark)), flats and darks averaged. A p - dark
// below 1/2 where the views are whole numbers, below 1e-6 of flat - dark [C] where they are not, is counted as absorbed
// and taken as that. Empty `flats`: `full` everywhere; empty `darks`: 0. Throws InputError that begins with `flats`,
// `darks` or `full`: another size than the views', no light at all.
FlatFieldReport correct_flat_field(Stack& views, const Stack& flats, const Stack& darks, double full);

struct DeadPixels {
  std::size_t named = 0;  // in the map
  // Found: in eight or more views, a fiftieth or less of the change from view to view of the surrounding pixels.
  std::size_t stuck = 0;
};
// Finds pixels that are stuck, takes those that `map` (one picture, not 0: dead; or empty) names, and interpolates
// between the live pixels at both ends of each one's row or column, whichever gap is shorter. Throws InputError that
// begins with `dead`: another size, no live pixel.
DeadPixels repair_pixels(Stack& views, const Stack& map);

struct Scan {
  ConeGeometry geometry;
  Vec3 centre;  // of the volume, in the scan's own coordinates
  Projections projections;
  std::size_t views_read = 0;  // in the files
  std::size_t repeated = 0;    // of them at an angle that another one has too: their mean is taken
  FlatFieldReport flat_field;
  DeadPixels dead;
  std::vector<std::string> warnings;  // of what the projections can't show
};

// A folder of projection matrices, or a file of any ScanKind. `projections`: in place of those that the scan names;
// `given`: of a file of views alone. Throws FileError, InputError.
ScanDescription read_description(const std::filesystem::path& path, const StackFiles& projections = {},
                                 const PixelsGiven& given = {});

// Gives the description's volume what it leaves open: voxels as large as a pixel seen at the axis, and as many as the
// detector sees.
void complete_volume(ScanDescription& description);

// Reads and corrects the projections. Throws FileError (files; another number of views than angles, of pixels than the
// detector's), InputError (flat and dark fields), BadArgument (the geometry). Warnings: an arc too short for its fan,
// an object that reaches beyond the detector, line integrals that look like intensities, absorbed rays, dead pixels.
Scan load_scan(const ScanDescription& description);

// The other way round: values as the files of `description` hold them. `projections` in the order of its angles.
std::vector<float> as_stored(const Projections& projections, const ScanDescription& description);

}  // namespace gicube::samples
