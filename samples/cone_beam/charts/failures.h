// The charts, a function each. Lengths are millimetres, values of phantoms 1/mm.
#pragma once

#include "cone_beam/charts/charts.h"

namespace gicube::samples {

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
