// gicube-cone-beam charts: the tables that script/charts draws.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "cone_beam/charts/case.h"
#include "scene/program/board_options.h"
#include "scene/program/progress.h"

namespace gicube::samples {

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

// Where the method fails, and what it costs: cone_angle, axial_profile, truncation, views, moire, ray_spacing, accumulator, sart,
// relaxation, profile.
std::vector<Chart> cone_beam_charts();

struct ChartOptions {
  std::filesystem::path folder;
  std::vector<std::string> only;  // charts; empty: all
  std::string point;              // one point's name: its row is printed, and nothing written
  BoardOptions board;
};

// Throws InputError (a chart or a point that isn't there, a file that can't be written), and what the methods throw.
void charts(const ChartOptions& options, ProgressLine& progress);

}  // namespace gicube::samples
