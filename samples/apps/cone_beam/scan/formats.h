// The formats that a scan can be described in: protobuf text (proto/gicube/v1/cone_scan.proto), JSON of CTSimU, and plastimatch's
// projection matrices.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cone_beam/scan/description.h"

namespace gicube::samples {

// Strict, as scene files are: an unknown field, a value of the wrong type, out of range or missing is an error. Throws InputError with
// all faults, one a line: "NAME:LINE:COLUMN: ..." for the text, "NAME: field.path: expected ..., got ..." for its meaning.
// Relative paths in `text` are taken from `folder`.
ScanDescription parse_scan(const std::string& text, const std::string& name, const std::filesystem::path& folder);
// The same for a file. Throws InputError also if it can't be read.
ScanDescription read_scan_file(const std::filesystem::path& path);

// Types of raw samples by the names of cone_scan.proto.
inline const std::map<std::string, SampleType> kRawTypes{{"uint8", SampleType::kUint8},
                                                         {"uint16", SampleType::kUint16},
                                                         {"int16", SampleType::kInt16},
                                                         {"float32", SampleType::kFloat32}};
// Nothing for another name.
std::optional<SampleType> raw_type(const std::string& name);

// The text of a description. Files in `folder` are named relative to it.
std::string scan_text(const ScanDescription& description, const std::filesystem::path& folder);
// Throws FileError; a file that was there stays until the new one is whole.
void write_scan_file(const ScanDescription& description, const std::filesystem::path& path);

// Pixel (column, row) of the file is at source + distance towards + (column - middle_column) along_u + (row - middle_row) along_v.
struct ViewFrame {
  Vec3 source;
  Vec3 towards;         // unit, square to the detector
  double distance = 0;  // from source to detector
  Vec3 along_u, along_v;
  double middle_column = 0, middle_row = 0;
};

std::string in_brackets(Vec3 v);  // for messages

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

// CTSimU (BAM): a scenario says where source, stage and detector stand and how the stage turns, metadata which raw files hold what and
// which volume is wanted, and where the scenario is. Format versions up to 1.2. Lengths become millimetres; the volume's coordinates
// are the stage's at the first angle.
// Either file; a scenario has no projections and no volume. Throws FileError naming the key: one that is missing or of another type,
// an unknown unit, deviations or drifts, a parallel beam, a stage or detector that is tilted, a stage beside the ray that meets the
// detector squarely, an angle that is no number.
ScanDescription read_ctsimu(const std::filesystem::path& file);

// A view in the text files that plastimatch writes and reads: the detector's centre in pixels (column, row), a 3 x 4 matrix from
// (x, y, z, 1) to pixels from that centre, source to axis, source to detector, the detector's normal; then, for people, the matrix's
// two factors. The matrix says where things are; of the normal only the line counts, since the program writes it the other way round
// than its documentation says.
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

}  // namespace gicube::samples
