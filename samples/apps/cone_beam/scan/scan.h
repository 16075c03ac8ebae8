// A scan as the methods take it: line integrals, view after view by ascending angle.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cone_beam/scan/description.h"

namespace gicube::samples {

// Angles as a ConeGeometry wants them.
struct SortedViews {
  std::vector<double> angles;                    // ascending within one turn
  std::vector<std::vector<std::size_t>> places;  // of each angle, in the list that came: several where it was repeated

  std::size_t repeated() const;  // places beyond the first of their angle
};
// Angles a whole number of turns apart are one [C: to 1e-6]. Where the angles leave a gap that is more than twice their second widest
// [C], as in a short scan, they begin behind it; else with the first of the list. `angles`: finite.
SortedViews sorted_views(const std::vector<double>& angles);

struct FlatFieldReport {
  std::size_t absorbed = 0;  // values without any light left, taken as half of the smallest that can be measured
  // Pixels without light: in the flat field; and in all views, in gaps of up to four pixels. They get the mean of those beside them.
  std::size_t dead = 0, unlit = 0;
};
// From intensities to line integrals, in place: -ln((p - dark) / (flat - dark)), flats and darks averaged. A p - dark below 1/2 where
// the views are whole numbers, below 1e-6 of flat - dark [C] where they are not, is counted as absorbed and taken as that. Empty
// `flats`: `full` everywhere; empty `darks`: 0. Throws InputError that begins with `flats`, `darks` or `full`: another size than the
// views', no light at all.
FlatFieldReport correct_flat_field(Stack& views, const Stack& flats, const Stack& darks, double full);

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
// beyond the detector, line integrals that look like intensities, absorbed rays, dead pixels.
Scan load_scan(const ScanDescription& description);

// The other way round: values as the files of `description` hold them. `projections` in the order of its angles.
std::vector<float> as_stored(const Projections& projections, const ScanDescription& description);

}  // namespace gicube::samples
