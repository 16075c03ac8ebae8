// Formats of a scan's description: protobuf text (proto/gicube/v1/cone_scan.proto), which may name a DXchange file, and
// the files of CTSimU, plastimatch, RTK, ASTRA and Nikon.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cone_beam/scan/description.h"

namespace gicube::samples {

// Rejects unknown fields, values of the wrong type or out of range, and missing values, as for scene files. Throws
// InputError with all errors, one per line: "NAME:LINE:COLUMN: ..." for the text, "NAME: field.path: expected ..., got
// ..." for the values. Paths in `text` are relative to `folder`.
ScanDescription parse_scan(const std::string& text, const std::string& name, const std::filesystem::path& folder);
// Reads a file and the DXchange file that it names. Throws InputError also if it can't be read, FileError for the
// DXchange file.
ScanDescription read_scan_file(const std::filesystem::path& path);

// Types of raw samples by their names in cone_scan.proto.
inline const std::map<std::string, SampleType> kRawTypes{{"uint8", SampleType::kUint8},
                                                         {"uint16", SampleType::kUint16},
                                                         {"int16", SampleType::kInt16},
                                                         {"float32", SampleType::kFloat32}};
// Empty for another name.
std::optional<SampleType> raw_type(const std::string& name);

// Sets angles, pixels, projections, flats and darks from the scan's DXchange file, as cone_scan.proto describes. Throws
// FileError.
void take_dxchange(ScanDescription& scan);

// Text of a description. Names of files in `folder` are relative to it.
std::string scan_text(const ScanDescription& description, const std::filesystem::path& folder);
// Throws FileError. An existing file stays until the new one is complete.
void write_scan_file(const ScanDescription& description, const std::filesystem::path& path);

std::string in_brackets(Vec3 v);  // for messages

// Throws FileError with the view's name: places that are not finite, steps in one direction, a source in the detector's
// plane.
void check_view(const ViewPose& view, const std::filesystem::path& file, const std::string& name);
// Sets angles, distances, detector (except its columns and rows), reversals and centre from the file's views. Their
// axis of rotation is parallel to z through `axis`. Sets poses only if some place in the field appears at least 1/20
// pixel [C] from its position on the nearest circle. `height`: of the volume's middle; default: the sources' mean
// height.
void set_views(std::vector<ViewPose> views, Vec3 axis, ScanDescription& description,
               std::optional<double> height = std::nullopt);

// Reads a CTSimU (BAM) scenario or metadata file, up to version 1.2. A scenario has the positions of source, stage and
// detector and the stage's rotation; metadata has the raw files, the volume and the scenario's name. Without metadata
// there are no projections and no volume. Lengths become millimetres; the volume's coordinates are the stage's at the
// first angle. Throws FileError with the key: a key that is missing or of another type, an unknown unit, deviations or
// drifts, a parallel beam, an angle that is not a number.
ScanDescription read_ctsimu(const std::filesystem::path& file);

// A view in plastimatch's text files: the detector's centre in pixels (column, row), a 3 x 4 matrix from (x, y, z, 1)
// to pixels from that centre, source to axis, source to detector, and the detector's normal; then, for readers, the
// matrix's two factors. The matrix gives the positions. The sign of the normal is ignored, because plastimatch writes
// the opposite of its documentation.
struct ProjectionMatrix {
  std::array<double, 2> centre{};   // column, row
  std::array<double, 12> matrix{};  // row by row
  double source_to_axis = 0, source_to_detector = 0;
  Vec3 normal;
};

// Throws FileError with the name of the missing number, or with the text after the last one.
ProjectionMatrix read_projection_matrix(const std::filesystem::path& file);
// Writes plastimatch's format, with rows that run downwards, and with more digits. Throws FileError.
void write_projection_matrix(const ConeGeometry& geometry, double angle, const std::filesystem::path& file);

// Pose that the matrix gives to a detector of this size. Throws FileError: a matrix of no camera, a normal beside its
// axis.
ViewPose pose_of(const ProjectionMatrix& view, int columns, int rows, const std::filesystem::path& file);

// Reads a folder with a NAME.txt per view. Without `projections`, the views are the images NAME.pfm (or .tif .tiff
// .nrrd .mha .mhd) beside them; else the views of that stack, which belong to the text files in natural order. Throws
// FileError.
ScanDescription read_matrix_folder(const std::filesystem::path& folder, const StackFiles& projections);

// Pixels of the detector for a file that has only views: those of the projections or, if these do not give them, the
// user's.
struct PixelsGiven {
  int columns = 0, rows = 0;  // 0: the projections'
  double pitch = 0;           // 0: the spacing in the projections' header
};
struct Pixels {
  int columns = 0, rows = 0;
  double pitch_u = 0, pitch_v = 0;  // 0: unknown
  double first_u = 0, first_v = 0;  // position of the first pixel by the header; by default the middle is 0
};
// Throws FileError: no projections and no given pixels, what reading a stack throws.
Pixels pixels_of(const StackFiles& projections, const PixelsGiven& given, const std::filesystem::path& file);
// Makes a scan from the views of a geometry file, which has no pixels or projections.
ScanDescription scan_of(std::vector<ViewPose> views, const Pixels& pixels, const std::filesystem::path& file,
                        const StackFiles& projections);

// Reads a geometry file of RTK (ThreeDCircularProjectionGeometry, version 3). RTK's axis of rotation, y, becomes z, its
// z becomes x and its x becomes y, so that the gantry's angle is the circle's. The matrices are ignored, because they
// repeat the parameters. Throws FileError with the element: another root, a number that is malformed or missing, a
// parallel beam, a cylindrical detector, no pitch of pixels.
ScanDescription read_rtk(const std::filesystem::path& file, const StackFiles& projections, const PixelsGiven& given);
// Writes also the matrices that RTK requires. Throws FileError: rows that are not perpendicular to columns, a place
// that can't be written.
void write_rtk(const ConeGeometry& geometry, const std::filesystem::path& file);

// Reads vectors of the ASTRA toolbox's cone_vec. Each view has a line of twelve numbers: source, the detector's middle,
// the step to the next column and the step to the next row. White space or commas separate them; # begins a comment.
// Throws FileError with the line.
ScanDescription read_astra(const std::filesystem::path& file, const StackFiles& projections, const PixelsGiven& given);
// The words of such a line, which it changes; and a number that may begin with +.
std::vector<std::string_view> words_of_vectors(std::string& line);
std::optional<double> signed_number(std::string_view word);
void write_astra(const ConeGeometry& geometry, const std::filesystem::path& file);

// Reads section [XTekCT] of Nikon's .xtekct. The projections are the .tif files in InputFolderName, or else those
// beside it that begin with Name. Throws FileError with the key.
ScanDescription read_nikon(const std::filesystem::path& file);

// Kind of a file by its first bytes; any other text is a scan file.
enum class ScanKind { kScanFile, kCtsimu, kRtk, kNikon, kAstra };
// Throws FileError with the type of a file that describes no scan.
ScanKind kind_of(const std::filesystem::path& file);

}  // namespace gicube::samples
