// What the charts scan, and how; the columns of their tables; and the charts, a function each. Lengths are millimetres, values of
// phantoms 1/mm.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cone_beam/charts/charts.h"

namespace gicube::samples {

// The head of high contrast, half as wide as `radius`; the skull takes away 0.05 a millimetre.
Phantom chart_head(double radius = 42);
// Seven flat discs of radius 36, 4 thick and 11 apart, which a cone smears into one another (after Defrise).
Phantom chart_discs();
constexpr double kOutermostDisc = 33;  // its middle plane

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
Chart accumulator_chart();    // bits of the words, and views between reading them back
Chart sart_chart();           // iterations, with and without noise, beside FDK
Chart profile_chart();        // sphere and head, at the sizes that the method is judged by
Chart relaxation_chart();     // up to where SART diverges

}  // namespace gicube::samples
