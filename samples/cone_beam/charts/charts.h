// gicube-cone-beam charts: the tables that script/charts draws, and what they are made of. Lengths are millimetres, values of
// phantoms 1/mm.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "cone_beam/algebraic.h"
#include "cone_beam/fdk.h"
#include "cone_beam/phantom/phantom.h"
#include "scene/program/board_options.h"
#include "scene/program/progress.h"

namespace gicube::samples {

// Filtered backprojection in its plainest form, one ray a pixel sent once, so that charts show one effect at a time.
inline const FdkSettings kPlainFdk{.rays = 1, .sharpen = 0.1, .normalise = false};

// One reconstruction of a chart: what is scanned, how, by which method on which board.
struct Case {
  Phantom phantom;
  ConeGeometry geometry;
  std::variant<FdkSettings, AlgebraicSettings> method;
  FieldOfView field;
  double photons = 0;                      // a pixel; 0: no noise
  std::vector<std::string> settings = {};  // of the board
};

struct Outcome {
  Reconstruction made;
  Comparison error;
  // Simulated: the time of the functional level, which is that of DSP and bus, and for each view what its rays take longer than
  // that at the cycle level: the mean of two views, or of an iterative method of a second pass through two.
  double board_ms = 0;
  double bus_ms = 0;  // in which the bus is busy, both directions
};

class Runner {
 public:
  explicit Runner(BoardOptions board) : board_(std::move(board)) {}

  Outcome run(const Case& what);
  Reconstruction reconstruct(const Case& what);  // alone, without what it costs
  // An emulated board as a point needs it, with room for its volume.
  Board open(const std::string& fidelity, const std::vector<std::string>& settings) const;

 private:
  double rays_over_bus_ms(const Case& what);

  BoardOptions board_;
  std::map<std::string, double> known_;  // of rays_over_bus_ms(), which many points share
};

// One run, which any user can make again by its name.
struct Point {
  std::string name;  // CHART/SERIES/X
  // A line of Chart::header's columns; of a profile several.
  std::function<std::string(Runner&)> rows;
};

// A block of rows that a chart draws as one line.
struct Series {
  std::string name;
  std::vector<Point> points;
};

struct Chart {
  std::string name;    // of its file, cone_beam_NAME.csv
  std::string header;  // the columns between those of the point and the command
  std::vector<Series> series;
};

// Where the method fails, and what it costs.
std::vector<Chart> cone_beam_charts();

struct ChartOptions {
  std::filesystem::path folder;
  std::vector<std::string> only;  // charts; empty: all
  std::string point;              // one point's name: its row is printed, and nothing written
  BoardOptions board;
};

// Throws InputError (a chart or a point that isn't there, a file that can't be written), and what the methods throw.
void charts(const ChartOptions& options, ProgressLine& progress);

// The head of high contrast, half as wide as `radius`; the skull takes away 0.05 a millimetre.
Phantom chart_head(double radius = 42);
// Seven flat discs of radius 36, 4 thick and 11 apart, which a cone smears into one another (after Defrise).
Phantom chart_discs();
// A whole turn around a volume of 90 mm a side; source 400 from the axis, 800 from a detector of 200 mm a side.
ConeGeometry chart_scan(int voxels, int pixels, int views);

// A series of reconstructions, one for each x, which stands first of kCaseColumns. Points are called PREFIX/X, PREFIX being
// CHART/SERIES.
constexpr const char* kCaseColumns =
    "x,rmse,bias,relative_l2,psnr,ssim,board_ms,bus_ms,rays,deposits,clipped,residual,iterations,diverged";
Series case_series(const std::string& title, const std::string& prefix, const std::vector<double>& xs,
                   const std::function<Case(double x)>& case_at);

Chart cone_angle_chart();     // discs seen under 5 to 40 degrees
Chart axial_profile_chart();  // their values along the axis of rotation
Chart truncation_chart();     // a detector narrower than the head's shadow
Chart views_chart();          // 20 to 720
Chart ray_spacing_chart();    // pixels larger and smaller than voxels
Chart moire_chart();          // the ripple that rays leave where all should be even
Chart profile_chart();        // sphere and head, at the sizes that the method is judged by

}  // namespace gicube::samples
