// Redundancy of a circular scan: its weights make lines that are measured twice count once.
#pragma once

#include <vector>

#include "cone_beam/geometry.h"

namespace gicube::samples {

// The arc of each angle; half of it in a whole turn, which measures every ray twice.
std::vector<double> arc_weights(const ConeGeometry& geometry);
// The arc of all angles.
double arc_of(const ConeGeometry& geometry);
// Whether the angles make less than a whole turn; short_scan_weight() then weights rays that are measured twice.
bool is_short_scan(const ConeGeometry& geometry);
// Parker's weight (1982), in a scan over `arc`, of the rays at `fan` in the view `angle` after the first. `arc`: at
// least pi plus twice the largest fan angle. The same line is measured again at angle + pi + 2 fan, from -fan; the two
// weights sum to 1, and rise and fall smoothly. Column u of a detector has fan = -atan(u / source_to_detector).
double short_scan_weight(double angle, double fan, double arc);

// Position among the angles at which column -u measures the line of column `u` of a view again: at angle + pi -
// 2 atan(u / source_to_detector). Linear interpolation uses (1 - part) of view `before` and `part` of view `behind`,
// which is 0 beyond the last.
struct OppositeViews {
  std::size_t before, behind;
  double part;
};
OppositeViews opposite_views(const ConeGeometry& geometry, std::size_t view, double u);

// Means of the detector's first, last and lowest column, relative to the greatest mean of a column.
struct SidesSeen {
  double first = 0, last = 0, least = 0;
  static constexpr double kSeen = 0.05;  // chosen: above noise and flat fields' errors
};
SidesSeen sides_seen(const Projections& projections);

// Whether the detector is displaced to widen the field: its middle is more than 1% of its width [C: a calibration
// corrects less] beside the ray through the axis, and the object reaches beyond its near side. A whole turn then
// measures lines far from the axis once, and those near it twice. Throws BadArgument: a detector beside the ray through
// the axis; a displaced one in a short scan, which misses lines.
bool is_displaced(const ConeGeometry& geometry, const Projections& projections);

// The geometry of the filtered and backprojected rows: adds columns to the near side of a displaced detector until both
// sides are equally wide, because filtered values reach beyond the measured pixels.
ConeGeometry widened(const ConeGeometry& geometry, bool displaced);

// Weighted rows of views. The weights are Parker's in a short scan, else 1. A displaced detector has those of Wang
// (2002), which here rise over the whole width: Wang's own rise over the columns of the near side, and if these are
// few, the ramp filter turns the steep rise into rings. Values that the near side misses are taken from the opposite
// views. These measure the same lines in the middle plane, and nearly the same beside it (after Cho, Wu and Hilal
// 1996).
class WeightedRows {
 public:
  WeightedRows(const ConeGeometry& geometry, bool displaced);  // the geometry must outlive it
  // One of widened(): columns values.
  void row(const Projections& projections, std::size_t view, int row, double* out) const;

 private:
  double from_opposite(const Projections& projections, std::size_t view, int row, double u) const;

  const ConeGeometry& geometry_;
  bool short_scan_, displaced_;
  int columns_ = 0, first_ = 0;  // of widened(), and the first measured one
  double far_ = 1;               // 1: the far side has the greater u; else -1
  double near_ = 0, reach_ = 0;  // distances of the near and the far side's last pixels from the ray through the axis
};

}  // namespace gicube::samples
