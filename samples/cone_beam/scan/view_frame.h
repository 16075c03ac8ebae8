// A view's source and detector in space, wherever they stand, and what a ConeGeometry makes of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cone_beam/scan/description.h"

namespace gicube::samples {

// Pixel (column, row) of the file is at source + distance towards + (column - middle_column) along_u + (row - middle_row) along_v.
struct ViewFrame {
  Vec3 source;
  Vec3 towards;         // unit, square to the detector
  double distance = 0;  // from source to detector
  Vec3 along_u, along_v;
  double middle_column = 0, middle_row = 0;
};

// The names of a frame's parts in its file, for messages.
struct FrameNames {
  std::filesystem::path file;
  std::string normal, u, v;
};

// A detector that stands upright and faces the axis of rotation, z, squarely.
struct FacingView {
  double angle = 0;  // of the source, radians
  double source_to_axis = 0, source_to_detector = 0;
  Detector
      detector;  // its offsets those of the files' columns and rows after they have been turned round where reversed
  bool columns_reversed = false, rows_reversed = false;
  Vec3 centre;  // where the ray that meets the detector squarely meets the axis
};

// `source_to_axis`: along that ray. `columns` and `rows`: of the detector. Throws FileError: a tilted or turned detector, by name;
// directions count as the same within 1e-4 [C: a twentieth of a pixel at the edge of 1000].
FacingView facing_view(const ViewFrame& frame, double source_to_axis, int columns, int rows, const FrameNames& names);

// Of views that share all but their angle: fills geometry (without its volume), centre and reversals. `files`: of each view, for
// messages. Throws FileError: a view whose distances, detector or axis differ from the first one's by more than a twentieth of a pixel [C].
void describe(const std::vector<FacingView>& views, const std::vector<std::filesystem::path>& files,
              ScanDescription& description);

}  // namespace gicube::samples
