// What the charts scan, and how; and the columns of their tables.
#pragma once

#include <string>
#include <variant>

#include "cone_beam/charts/charts.h"

namespace gicube::samples {

// The head of high contrast, half as wide as `radius`; the skull takes away 0.05 a millimetre.
Phantom chart_head(double radius = 42);
// Seven flat discs of radius 36, 4 thick and 11 apart, which a cone smears into one another (after Defrise).
Phantom chart_discs();
constexpr double kOutermostDisc = 33;  // its middle plane

// A whole turn around a volume of 90 mm a side; source 400 from the axis, 800 from a detector of 200 mm a side.
ConeGeometry chart_scan(int voxels, int pixels, int views);

// A point that reconstructs, its columns kCaseColumns; x stands first.
constexpr const char* kCaseColumns =
    "x,rmse,bias,relative_l2,psnr,ssim,board_ms,bus_ms,rays,deposits,clipped,residual,iterations,diverged";
Point case_point(const std::string& chart, const std::string& series, double x, Case what);

}  // namespace gicube::samples
