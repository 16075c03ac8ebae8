// The formats that a scan can be described in: protobuf text (proto/gicube/v1/cone_scan.proto), JSON of CTSimU, and
// plastimatch's projection matrices.
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

// Strict, as scene files are: an unknown field, a value of the wrong type, out of range or missing is an error. Throws
// InputError with all faults, one a line: "NAME:LINE:COLUMN: ..." for the text, "NAME: field.path: expected ..., got
// ..." for its meaning. Relative paths in `text` are taken from `folder`.
ScanDescription parse_scan(const std::string& text, const std::string& name, const std::filesystem::path& folder);
// Reads a file, and the DXchange file that it names. Throws InputError also if it can't be read, FileError of the
// latter.
ScanDescription read_scan_file(const std::filesystem::path& path);

// Types of raw samples by the names of cone_scan.proto.
inline const std::map<std::string, SampleType> kRawTypes{{"uint8", SampleType::kUint8},
                                                         {"uint16", SampleType::kUint16},
                                                         {"int16", SampleType::kInt16},
                                                         {"float32", SampleType::kFloat32}};
// Nothing for another name.
std::optional<SampleType> raw_type(const std::string& name);

// Takes angles, pixels, projections, flats and darks from the scan's file of DXchange's layout, as cone_scan.proto
// says. Throws FileError.
void take_dxchange(ScanDescription& scan);

// The text of a description. Files in `folder` are named relative to it.
std::string scan_text(const ScanDescription& description, const std::filesystem::path& folder);
// Throws FileError; a file that was there stays until the new one is whole.
void write_scan_file(const ScanDescription& description, const std::filesystem::path& path);

std::string in_brackets(Vec3 v);  // for messages

// Throws FileError that names the view: places that are not finite, steps in one direction, a source in the detector's
// plane.
void check_view(const ViewPose& view, const std::filesystem::path& file, const std::string& name);
// Fills angles, distances, detector (but its columns and rows), reversals and centre from the views as the file has
// them, whose axis of rotation is parallel to z through `axis`; poses only where some place in the field is seen a
// twentieth of a pixel or more off a circle's [C]. `height`: of the volume's middle; else the mean height of the
// sources.
void set_views(std::vector<ViewPose> views, Vec3 axis, ScanDescription& description,
               std::optional<double> height = std::nullopt);

// CTSimU (BAM): a scenario says where source, stage and detector stand and how the stage turns, metadata which raw
// files hold what and which volume is wanted, and where the scenario is. Format versions up to 1.2. Lengths become
// millimetres; the volume's coordinates are the stage's at the first angle. Either file; a scenario has no projections
// and no volume. Throws FileError naming the key: one that is missing or of another type, an unknown unit, deviations
// or drifts, a parallel beam, an angle that is no number.
ScanDescription read_ctsimu(const std::filesystem::path& file);

// A view in the text files that plastimatch writes and reads: the detector's centre in pixels (column, row), a 3 x 4
// matrix from (x, y, z, 1) to pixels from that centre, source to axis, source to detector, the detector's normal; then,
// for people, the matrix's two factors. The matrix says where things are; of the normal only the line counts, since the
// program writes it the other way round than its documentation says.
struct ProjectionMatrix {
  std::array<double, 2> centre{};   // column, row
  std::array<double, 12> matrix{};  // row by row
  double source_to_axis = 0, source_to_detector = 0;
  Vec3 normal;
};

// Throws FileError naming the number that is missing, or what stands behind the last.
ProjectionMatrix read_projection_matrix(const std::filesystem::path& file);
// Writes plastimatch's format, with rows that run downwards, and with more digits. Throws FileError.
void write_projection_matrix(const ConeGeometry& geometry, double angle, const std::filesystem::path& file);

// Where the matrix says that source and a detector of so many pixels stand. Throws FileError: a matrix of no camera, a
// normal beside its axis.
ViewPose pose_of(const ProjectionMatrix& view, int columns, int rows, const std::filesystem::path& file);

// A folder with a NAME.txt for each view. `projections` empty: the views are images NAME.pfm (or .tif .tiff .nrrd .mha
// .mhd) beside them; else the views of that stack belong to the text files in natural order. Throws FileError.
ScanDescription read_matrix_folder(const std::filesystem::path& folder, const StackFiles& projections);

// The pixels of a detector that a file of views alone does not say: of the projections or, where those do not say
// either, as given.
struct PixelsGiven {
  int columns = 0, rows = 0;  // 0: the projections'
  double pitch = 0;           // 0: the spacing in the projections' header
};
struct Pixels {
  int columns = 0, rows = 0;
  double pitch_u = 0, pitch_v = 0;  // 0: unknown
  double first_u = 0, first_v = 0;  // of the first pixel, by the header; else such that the middle is 0
};
// Throws FileError: no projections and nothing given, what reading a stack throws.
Pixels pixels_of(const StackFiles& projections, const PixelsGiven& given, const std::filesystem::path& file);
// A scan of the views of a geometry file, which says nothing of pixels and projections.
ScanDescription scan_of(std::vector<ViewPose> views, const Pixels& pixels, const std::filesystem::path& file,
                        const StackFiles& projections);

// The geometry files of RTK (ThreeDCircularProjectionGeometry, version 3): RTK's axis of rotation, y, becomes z, its z
// becomes x and its x y, so that a gantry's angle is a circle's. The matrices, which repeat the parameters, are not
// read. Throws FileError naming the element: another root, a number that is none or missing, a parallel beam, a
// cylindrical detector, no pitch of pixels.
ScanDescription read_rtk(const std::filesystem::path& file, const StackFiles& projections, const PixelsGiven& given);
// With matrices, as RTK wants them. Throws FileError: rows and columns that are not square to each other, a place that
// can't be written.
void write_rtk(const ConeGeometry& geometry, const std::filesystem::path& file);

// Vectors of the ASTRA toolbox's cone_vec: a line of twelve numbers for each view, source, detector's middle, the step
// to the next column and the step to the next row, by white space or commas; # begins a comment. Throws FileError
// naming the line.
ScanDescription read_astra(const std::filesystem::path& file, const StackFiles& projections, const PixelsGiven& given);
// The words of such a line, which it changes; and a number that may begin with +.
std::vector<std::string_view> words_of_vectors(std::string& line);
std::optional<double> signed_number(std::string_view word);
void write_astra(const ConeGeometry& geometry, const std::filesystem::path& file);

// Nikon's .xtekct: section [XTekCT]. Its projections are the .tif files in InputFolderName, or beside it those that
// begin with Name. Throws FileError naming the key.
ScanDescription read_nikon(const std::filesystem::path& file);

// The kind of a file by its first bytes; a text of no other kind counts as a scan file.
enum class ScanKind { kScanFile, kCtsimu, kRtk, kNikon, kAstra };
// Throws FileError that names what the file is, where it describes no scan.
ScanKind kind_of(const std::filesystem::path& file);

}  // namespace gicube::samples
