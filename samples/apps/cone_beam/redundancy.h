// How often a circular scan measures each line, and the weights by which what it measures more than once counts once.
#pragma once

#include <vector>

#include "cone_beam/geometry.h"

namespace gicube::samples {

// For each angle: the arc that it stands for, times one half where every ray is measured twice (a whole turn).
std::vector<double> arc_weights(const ConeGeometry& geometry);
// The arc that all angles stand for.
double arc_of(const ConeGeometry& geometry);
// Whether the angles don't make a whole turn: then short_scan_weight() shares twice measured rays out.
bool is_short_scan(const ConeGeometry& geometry);
// Parker's weight (1982) in a scan over `arc`, at least pi and twice the largest fan angle, of the rays at `fan` in the
// view `angle` after the first. They are measured again at angle + pi + 2 fan, from -fan; the weights of both sum to
// one, and rise and fall smoothly. Column u of a detector has fan = -atan(u / source_to_detector).
double short_scan_weight(double angle, double fan, double arc);

// Means of the detector's first, last and lowest column, relative to the greatest mean of a column.
struct SidesSeen {
  double first = 0, last = 0, least = 0;
  static constexpr double kSeen = 0.05;  // chosen: above noise and flat fields' errors
};
SidesSeen sides_seen(const Projections& projections);

// Whether the object reaches beyond the near side of a whole turn's detector, which is off the ray through the axis by
// more than 1% of its width, as to widen the field [C: what a calibration corrects is less]: lines far from the axis
// are measured once, and those near it twice. Throws BadArgument: a detector beside the ray through the axis; a
// displaced one in a short scan, which misses lines.
bool is_displaced(const ConeGeometry& geometry, const Projections& projections);

// The geometry whose rows are filtered and backprojected: that of the scan, with a displaced detector's columns
// continued on its near side until both sides reach as far. Filtered values reach beyond the pixels that were measured.
ConeGeometry widened(const ConeGeometry& geometry, bool displaced);

// The rows of views with their weights: Parker's in a short scan, else 1; of a displaced detector those of Wang (2002),
// which here rise over the whole width. Wang's own rise over what the near side measures, and where that is a few
// columns the ramp filter turns the steep rise into rings. So what the near side misses is taken from the opposite
// views, which measure the same lines in the middle plane and nearly the same beside it (after Cho, Wu and Hilal 1996).
class WeightedRows {
 public:
  WeightedRows(const ConeGeometry& geometry, bool displaced);  // the geometry must outlive it
  // One of widened(): columns values.
  void row(const Projections& projections, std::size_t view, int row, double* out) const;

 private:
  double from_opposite(const Projections& projections, std::size_t view, int row, double u) const;

  const ConeGeometry& geometry_;
  bool short_scan_, displaced_;
  int columns_ = 0, first_ = 0;  // of widened(); the measured ones begin at
  double far_ = 1;               // 1: the far side has the greater u; else -1
  double near_ = 0,
         reach_ = 0;  // how far the pixels of the near side and of the far side are from the ray through the axis
};

}  // namespace gicube::samples
