// What is known of a scan before its projections are read: where everything stood, and which files hold what.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "cone_beam/geometry.h"
#include "scene/formats/volume_file.h"

namespace gicube::samples {

// Views in one or more files, in the order of the scan's angles: .nrrd .mhd .mha .nii volumes whose slices are views, .pfm and
// .tif images, folders of images, or raw samples. Rows as the files store them.
struct StackFiles {
  std::vector<std::filesystem::path> files;
  std::optional<RawLayout> raw;  // of files without a header; dims: columns, rows, and 0 for the views

  bool empty() const { return files.empty(); }
};

struct ScanDescription {
  ScanDescription() { geometry.volume.spacing = {0, 0, 0}; }

  std::filesystem::path file;  // where it came from, for messages
  // Its angles are those of the files' views: in any order, over any number of turns. What the scan leaves open of the volume is 0.
  ConeGeometry geometry;
  Vec3 centre;                    // of the volume, in the scan's own coordinates; the geometry's origin
  bool columns_reversed = false;  // the files' first column is that of the greatest u
  bool rows_reversed = false;     // the files' first row is that of the greatest v, as where rows run downwards
  StackFiles projections;
  bool intensities = false;  // of the projections: else they are line integrals
  StackFiles flats, darks;   // averaged; only with intensities
  double full = 0;           // the intensity of a ray that met nothing, where there is no flat
};

}  // namespace gicube::samples
