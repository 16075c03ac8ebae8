// The records' defaults: those of the C++ API.
#pragma once

#include "gicube/c_types.h"

namespace gicube::c_api {

gicube_open_options default_open_options();
gicube_volume default_volume();
gicube_shading default_shading();
gicube_material default_material();
gicube_illumination default_illumination();
gicube_view default_view();
gicube_ray_request default_ray_request();
gicube_pair_request default_pair_request();

}  // namespace gicube::c_api
