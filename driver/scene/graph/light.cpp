#include "gicube/scene/light.h"

#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

void check_light(const PointLight& light) { require_finite("point.position", light.position); }

void check_light(const DirectionalLight& light) {
  require_finite("towards", light.towards);
  if (!(length(light.towards) > 0)) throw InputError("towards", "a direction", "0 0 0");
}

void check_light(const RectangleLight& light) {
  require_finite("rectangle.corner", light.corner);
  require_finite("rectangle.edge_u", light.edge_u);
  require_finite("rectangle.edge_v", light.edge_v);
  const double area = length(cross(light.edge_u, light.edge_v));
  if (!(area > 1e-9 * length(light.edge_u) * length(light.edge_v))) {
    throw InputError("rectangle.edge_v", "an edge across edge_u, so that there is an area", "none");
  }
}

void check_light(const SphereLight& light) {
  require_finite("sphere.centre", light.centre);
  require_above_0("sphere.radius", light.radius);
}

void place(PointLight& light, const WorldGrid& grid) { light.position = grid.voxel_of(light.position); }

void place(DirectionalLight& light, const WorldGrid& grid) {
  light.irradiance *= grid.voxel * grid.voxel;  // per unit area, which is now a voxel's face
}

void place(RectangleLight& light, const WorldGrid& grid) {
  light.corner = grid.voxel_of(light.corner);
  light.edge_u = (1 / grid.voxel) * light.edge_u;
  light.edge_v = (1 / grid.voxel) * light.edge_v;
}

void place(SphereLight& light, const WorldGrid& grid) {
  light.centre = grid.voxel_of(light.centre);
  light.radius /= grid.voxel;
}

// The light's power or irradiance.
template <typename AnyLight>
auto& power_of(AnyLight& light) {
  if constexpr (requires { light.power; }) {
    return light.power;
  } else {
    return light.irradiance;
  }
}

}  // namespace

void check(const SceneLight& light) {
  std::visit(
      [](const auto& l) {
        check_light(l);
        require_above_0("power", power_of(l));
      },
      light.light);
  for (const double part : light.colour) {
    require(part >= 0 && part <= 1, "colour", "numbers from 0 to 1", part);
  }
}

Light in_voxels(Light light, const WorldGrid& grid) {
  std::visit([&grid](auto& l) { place(l, grid); }, light);
  return light;
}

Light scaled(Light light, double factor) {
  std::visit([factor](auto& l) { power_of(l) *= factor; }, light);
  return light;
}

void set_albedo(const std::string& name, const std::string& field, Lighting& lighting) {
  const auto albedo = named<std::optional<Albedo>>(
      field, name, {{"none", std::nullopt}, {"low", Albedo::kLow}, {"high", Albedo::kHigh}});
  lighting.on = albedo.has_value();
  lighting.settings.albedo = albedo.value_or(lighting.settings.albedo);
}

EnergyRules rules_named(const std::string& name, const std::string& field) {
  return named<EnergyRules>(field, name,
                            {{"conserving", EnergyRules::kConserving}, {"as-printed", EnergyRules::kAsPrinted}});
}

}  // namespace gicube::scene
