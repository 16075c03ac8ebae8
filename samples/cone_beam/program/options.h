// The command line of gicube-cone-beam.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cone_beam/algebraic.h"
#include "cone_beam/charts/charts.h"
#include "cone_beam/fdk.h"
#include "cone_beam/phantom/comparison.h"
#include "cone_beam/scan/description.h"
#include "scene/program/board_options.h"
#include "scene/program/plan_options.h"

namespace gicube::samples {

// Something whose values are known: a built-in phantom, or a volume file.
struct ObjectOptions {
  std::string name;
  double radius = 90;  // of a phantom, in the scan's unit
  double value = 1;    // of the sphere, and times a head's values
};

// A scan file or, without one, a scan that these numbers describe.
struct ScanOptions {
  std::filesystem::path input;
  std::vector<std::filesystem::path> projections;  // in place of the input's
  std::optional<SampleType> type;                  // of them, where they are raw
  std::array<int, 2> detector_size{256, 256};
  double pitch = 1.56, source_to_axis = 500, source_to_detector = 1000;
  int views = 180;
  double arc = 360;  // degrees
  std::optional<Dims> size;
  std::optional<Vec3> spacing;
};

struct SliceOptions {
  std::string name;  // NAME_x.png, NAME_y.png, NAME_z.png; empty: none
  std::optional<std::array<double, 2>> grey;
  std::vector<std::pair<int, int>> planes;  // axis and index; empty: the three in the middle
};

struct ProjectOptions {
  ObjectOptions object;
  ScanOptions scan;
  bool by_board = false;  // a phantom's voxels instead of its closed form
  double step = 0.5;      // of the board's rays, voxels
  double photons = 0;     // a pixel, of Poisson noise; 0: none
  std::filesystem::path output, voxels;
  BoardOptions board;
};

struct ReconstructOptions {
  ScanOptions scan;
  std::string method = "fdk";  // or sart, os-sart, sirt
  FdkSettings filtered;        // its rays 0: to be chosen
  AlgebraicSettings algebraic;
  std::filesystem::path output;
  SliceOptions slices;
  PlanOptions plan;  // of fdk
  BoardOptions board;

  bool fdk() const { return method == "fdk"; }
};

// The names of settings, on the command line and in --stats.
inline const std::map<std::string, Window> kWindows{
    {"ram-lak", Window::kRamLak}, {"shepp-logan", Window::kSheppLogan}, {"hann", Window::kHann}};
inline const std::map<std::string, Accumulator> kAccumulators{{"sums", Accumulator::kSums},
                                                              {"irradiance", Accumulator::kIrradiance}};
inline const std::map<std::string, ViewOrder> kViewOrders{
    {"sequential", ViewOrder::kSequential}, {"random", ViewOrder::kRandom}, {"golden", ViewOrder::kGolden}};

struct CompareOptions {
  std::filesystem::path volume;
  ObjectOptions truth;
  FieldOfView field;
  std::filesystem::path difference, profiles, stats;
  SliceOptions slices;  // of the difference
};

struct ImportOptions {
  ScanOptions scan;
  std::filesystem::path output;  // empty: printed
};

using ConeBeamOptions = std::variant<ProjectOptions, ReconstructOptions, CompareOptions, ImportOptions, ChartOptions>;

// Nothing if help or the version was asked for and went to `out`. Throws UsageError with one line.
std::optional<ConeBeamOptions> parse_cone_beam_options(int argc, const char* const* argv, std::ostream& out);

// The scan that the options describe, its volume complete. Throws UsageError, FileError, InputError.
ScanDescription description_of(const ScanOptions& options);

}  // namespace gicube::samples
