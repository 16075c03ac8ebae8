// A scan as a projection matrix a view, in the text files that plastimatch writes and reads: the detector's centre in pixels
// (column, row), a 3 x 4 matrix from (x, y, z, 1) to pixels from that centre, source to axis, source to detector, the detector's
// normal; then, for people, the matrix's two factors. The matrix says where things are; of the normal only the line counts, since the
// program writes it the other way round than its documentation says.
#pragma once

#include <array>
#include <filesystem>

#include "cone_beam/scan/description.h"
#include "cone_beam/scan/view_frame.h"

namespace gicube::samples {

struct ProjectionMatrix {
  std::array<double, 2> centre{};   // column, row
  std::array<double, 12> matrix{};  // row by row
  double source_to_axis = 0, source_to_detector = 0;
  Vec3 normal;
};

// Throws FileError naming the number that is missing, or what stands behind the last.
ProjectionMatrix read_projection_matrix(const std::filesystem::path& file);
// As plastimatch writes it, with rows that run downwards, and with more digits. Throws FileError.
void write_projection_matrix(const ConeGeometry& geometry, double angle, const std::filesystem::path& file);

// Where the matrix says that source and detector stand. Throws FileError: a matrix of no camera, a normal beside its axis.
ViewFrame frame_of(const ProjectionMatrix& view, const std::filesystem::path& file);

// A folder with a NAME.txt for each view. `projections` empty: the views are images NAME.pfm (or .tif .tiff .nrrd .mha .mhd) beside
// them; else the views of that stack belong to the text files in natural order. Throws FileError, also for what facing_view() and
// describe() refuse.
ScanDescription read_matrix_folder(const std::filesystem::path& folder, const StackFiles& projections);
// Whether the folder holds such text files.
bool is_matrix_folder(const std::filesystem::path& folder);

}  // namespace gicube::samples
