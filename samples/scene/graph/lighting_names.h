// The names of lighting modes in scene files and options.
#pragma once

#include <string>

#include "scene/graph/light.h"

namespace gicube::samples {

// "none", "low" or "high". Throws InputError that names `field`.
void set_albedo(const std::string& name, const std::string& field, Lighting& lighting);
// "conserving" or "as-printed". Throws InputError that names `field`.
EnergyRules rules_named(const std::string& name, const std::string& field);

}  // namespace gicube::samples
