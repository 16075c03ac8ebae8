#include "scene/graph/lighting_names.h"

#include "scene/program/input_error.h"

namespace gicube::samples {

void set_albedo(const std::string& name, const std::string& field, Lighting& lighting) {
  if (name != "none" && name != "low" && name != "high") {
    throw InputError(field, "none, low or high", in_quotes(name));
  }
  lighting.on = name != "none";
  if (lighting.on) lighting.settings.albedo = name == "high" ? Albedo::kHigh : Albedo::kLow;
}

EnergyRules rules_named(const std::string& name, const std::string& field) {
  if (name == "conserving") return EnergyRules::kConserving;
  if (name == "as-printed") return EnergyRules::kAsPrinted;
  throw InputError(field, "conserving or as-printed", in_quotes(name));
}

}  // namespace gicube::samples
