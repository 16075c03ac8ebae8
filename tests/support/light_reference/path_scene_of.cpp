#include "light_reference/path_scene_of.h"

#include <algorithm>

#include "gicube/scene/error.h"
#include "reference/field.h"

namespace gicube::samples {
namespace {

// The least value whose opacity is at least half of the greatest one. Between points the opacity is linear.
double surface_of(const TransferFunction& look) {
  double most = 0;
  for (const OpacityPoint& point : look.opacities) most = std::max(most, point.opacity);
  if (!(most > 0)) throw scene::InputError("opacity", "above 0 somewhere for a surface", "0");
  OpacityPoint before = look.opacities.front();
  for (const OpacityPoint& point : look.opacities) {
    if (point.opacity >= most / 2) {
      const double rise = point.opacity - before.opacity;
      return rise > 0 ? before.value + (point.value - before.value) * (most / 2 - before.opacity) / rise : point.value;
    }
    before = point;
  }
  return before.value;
}

}  // namespace

reference::paths::PathScene to_paths(const scene::SceneSetup& setup) {
  reference::paths::PathScene out;
  out.normal_reach = 0.5;  // as Medium::normal()
  out.scene.volume = setup.volume_view();
  out.scene.view = setup.view;
  const ValueRange range = reference::value_range(out.scene.volume);
  for (std::size_t tag = 0; tag < setup.optics.size(); ++tag) {
    const Material& material = setup.optics[tag];
    out.scene.functions[tag] = in_values_of(range, setup.materials[tag]);
    const bool glass = material.bsdf == Bsdf::kTrap && material.surface;
    const bool solid = glass || material.bsdf == Bsdf::kDiffuse || material.bsdf == Bsdf::kSpecular;
    if (solid && !out.scene.functions[tag].opacities.empty()) out.surfaces[tag] = surface_of(out.scene.functions[tag]);
    out.materials[tag] = material;
    if (tag < setup.scattering_colours.size()) out.scattering_colours[tag] = setup.scattering_colours[tag];
  }
  out.lights = setup.lights;
  out.light_colours.assign(setup.light_colours.begin(), setup.light_colours.end());
  return out;
}

}  // namespace gicube::samples
