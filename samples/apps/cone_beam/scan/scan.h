// A scan for the methods: line integrals, by views in ascending order of angles.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cone_beam/scan/description.h"
#include "cone_beam/scan/formats.h"

namespace gicube::samples {

struct FlatFieldReport {
  std::size_t absorbed = 0;  // values without light, replaced by half of the smallest measurable one
  // Pixels without light in the flat field, and in all views, in gaps of up to four pixels. The pixels beside them
  // replace them.
  std::size_t dead = 0, unlit = 0;
};
// Converts intensities p to line integrals in place: -ln((p - dark) / (flat - dark)), with the means of flats and
// darks. The least p - dark is 1/2 for integer views, and 1e-6 (flat - dark) [C] for others; it replaces lesser values,
// which count as absorbed. Empty `flats`: `full` everywhere; empty `darks`: 0. Throws InputError that begins with
// `flats`, `darks` or `full`: another size than the views', no light at all.
FlatFieldReport correct_flat_field(Stack& views, const Stack& flats, const Stack& darks, double full);

struct DeadPixels {
  std::size_t named = 0;  // in the map
  // Found in at least eight views: their change from view to view is at most 1/50 of the surrounding pixels'.
  std::size_t stuck = 0;
};
// Finds stuck pixels, adds the dead ones of `map` (one picture, not 0: dead; or empty), and interpolates each between
// the nearest live pixels in its row or column, whichever gap is shorter. Throws InputError that begins with `dead`:
// another size, no live pixel.
DeadPixels repair_pixels(Stack& views, const Stack& map);

struct Scan {
  ConeGeometry geometry;
  Vec3 centre;  // of the volume, in the scan's own coordinates
  Projections projections;
  std::size_t views_read = 0;  // in the files
  std::size_t repeated = 0;    // of them at the angle of another one: views of one angle are averaged
  FlatFieldReport flat_field;
  DeadPixels dead;
  std::vector<std::string> warnings;  // about features that the projections cannot show
};

// Reads a folder of projection matrices, or a file of any ScanKind. `projections` replace those of the scan; `given`
// completes a file that has only views. Throws FileError, InputError.
ScanDescription read_description(const std::filesystem::path& path, const StackFiles& projections = {},
                                 const PixelsGiven& given = {});

// Completes the description's volume. Defaults: voxels as large as a pixel scaled to the axis, and as many as the
// detector sees.
void complete_volume(ScanDescription& description);

// Reads and corrects the projections. Throws FileError (files; a number of views other than the angles', a size other
// than the detector's), InputError (flat and dark fields), BadArgument (the geometry). Warnings: an arc too short for
// its fan, an object that reaches beyond the detector, line integrals that look like intensities, absorbed rays, dead
// pixels.
Scan load_scan(const ScanDescription& description);

// The inverse of reading: values in the order of the files of `description`. `projections`: in the order of its angles.
std::vector<float> as_stored(const Projections& projections, const ScanDescription& description);

}  // namespace gicube::samples
