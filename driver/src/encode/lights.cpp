#include "encode/lights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "encode/argument.h"
#include "encode/vectors.h"
#include "gicube/wire/ray.h"

namespace gicube {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSmallest = 1e-12;  // areas and lengths, in smallest voxel edges

double smallest_cell(const LitBox& box) {
  const auto [a, b, c] = box.spacing;
  return std::max({a * b, b * c, c * a});
}

// Distance of a physical point from the box's surface.
double distance_to_faces(Vec3 at, const LitBox& box) {
  const auto p = to_array(at), e = to_array(box.extent);
  double outside = 0, inside = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double beyond = std::max({-p[axis], p[axis] - e[axis], 0.0});
    outside += beyond * beyond;
    inside = std::min({inside, std::abs(p[axis]), std::abs(e[axis] - p[axis])});
  }
  return outside > 0 ? std::sqrt(outside) : inside;
}

double distance_to_middle(Vec3 at, const LitBox& box) {
  const double nearest = 0.25 * std::min({box.extent.x, box.extent.y, box.extent.z});
  return std::max(length(at - 0.5 * box.extent), nearest);
}

// Sample points of a light; a point light has one.
std::vector<Vec3> places(const Light& light, const LitBox& box) {
  if (const auto* point = std::get_if<PointLight>(&light)) return {times(point->position, box.spacing)};
  std::vector<Vec3> out;
  if (const auto* area = std::get_if<RectangleLight>(&light)) {
    constexpr int kSteps = 16;
    const Vec3 corner = times(area->corner, box.spacing);
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j <= kSteps; ++j) {
        out.push_back(corner + (1.0 * i / kSteps) * area->edge_u + (1.0 * j / kSteps) * area->edge_v);
      }
    }
  }
  if (const auto* sphere = std::get_if<SphereLight>(&light)) {
    const Vec3 centre = times(sphere->centre, box.spacing);
    for (const double side : {-1.0, 1.0}) {
      out.push_back(centre + Vec3{side * sphere->radius, 0, 0});
      out.push_back(centre + Vec3{0, side * sphere->radius, 0});
      out.push_back(centre + Vec3{0, 0, side * sphere->radius});
    }
  }
  return out;
}

double power_of(const Light& light) {
  return std::visit(
      [](const auto& it) {
        if constexpr (requires { it.irradiance; }) {
          return it.irradiance;
        } else {
          return it.power;
        }
      },
      light);
}

bool is_point(const Light& light) { return std::holds_alternative<PointLight>(light); }

void expect_positive(const std::string& field, double value) {
  expect_within(field, value, std::numeric_limits<double>::min(), std::numeric_limits<double>::max());
}

}  // namespace

void check(const Material& material) {
  expect_within("material.scattering", material.scattering, 0, 1);
  expect_within("material.gloss", material.gloss, 0, 15.99);
  expect(material.bsdf >= Bsdf::kNone && material.bsdf <= Bsdf::kTrap, "material.bsdf", "a Bsdf", material.bsdf);
  expect_within("material.routine", material.routine, 0, kHostRoutine);
  const std::size_t count = material.parameters.size();
  expect(count <= wire::kMaterialParameters, "material.parameters", "at most 32", count);
  for (const float value : material.parameters) expect_finite("material.parameters", value);
  for (const double factor : material.scattering_colour) expect_within("material.scattering_colour", factor, 0, 1);
}

void check(const Light& light, const std::string& list_place) {
  const std::string name = list_place + ".";
  expect_positive(name + (std::holds_alternative<DirectionalLight>(light) ? "irradiance" : "power"), power_of(light));
  if (const auto* point = std::get_if<PointLight>(&light)) expect_finite(name + "position", point->position);
  if (const auto* sun = std::get_if<DirectionalLight>(&light)) {
    expect_finite(name + "towards", sun->towards);
    expect(unit(sun->towards) != Vec3{}, name + "towards", "a direction", "the zero vector");
  }
  if (const auto* area = std::get_if<RectangleLight>(&light)) {
    expect_finite(name + "corner", area->corner);
    expect_finite(name + "edge_u", area->edge_u);
    expect_finite(name + "edge_v", area->edge_v);
    const bool is_flat = length(cross(area->edge_u, area->edge_v)) < kSmallest;
    expect(!is_flat, name + "edge_u x edge_v", "a rectangle with an area", "none");
  }
  if (const auto* sphere = std::get_if<SphereLight>(&light)) {
    expect_finite(name + "centre", sphere->centre);
    expect_positive(name + "radius", sphere->radius);
  }
}

void check(const Illumination& settings, std::size_t lights, int irradiance_words) {
  const std::vector<Colour>& colours = settings.light_colours;
  expect(colours.empty() || irradiance_words == 3, "light_colours",
         "none on a board with one irradiance word (asic.irradiance_words is 1)", colours.size());
  expect(colours.empty() || colours.size() == lights, "light_colours",
         "one for each of the " + std::to_string(lights) + " lights, or none", colours.size());
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const std::string name = "light_colours[" + std::to_string(i) + "]";
    for (const double factor : colours[i]) expect_within(name, factor, 0, std::numeric_limits<double>::max());
    expect(brightest_of(settings, i) > 0, name, "a colour with a factor above 0", "black");
  }
  expect_within("rays_per_face_voxel", settings.rays_per_face_voxel, 1, wire::kMaxRaysPerVoxel);
  expect_within("step", settings.step, 1.0 / 64, 16);
  expect_within("lifetime", settings.lifetime, 0, wire::kLifetimeMax);
}

std::array<double, 3> scattering_by_colour(const Material& material) {
  std::array<double, 3> out{};
  for (std::size_t c = 0; c < 3; ++c) out[c] = material.scattering * material.scattering_colour[c];
  return out;
}

wire::ScatteringColour scattering_colour_record(const Material& material) {
  const double most = std::ranges::max(material.scattering_colour);
  wire::ScatteringColour out;
  for (std::size_t c = 0; c < 3 && most > 0; ++c) {
    const double lost = 1 - material.scattering_colour[c] / most;
    out.lost[c] = static_cast<std::uint16_t>(std::lround(lost * wire::kScatteringOne));
  }
  return out;
}

double brightest_of(const Illumination& settings, std::size_t light) {
  return settings.light_colours.empty() ? 1 : std::ranges::max(settings.light_colours[light]);
}

std::array<std::uint32_t, 3> light_colour_words(const Illumination& settings, std::size_t light) {
  const Colour colour = settings.light_colours.empty() ? Colour{1, 1, 1} : settings.light_colours[light];
  const double most = brightest_of(settings, light);
  std::array<std::uint32_t, 3> out{};
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = static_cast<std::uint32_t>(std::lround(colour[c] / most * wire::kScatteringOne));
  }
  return out;
}

wire::Material material_record(const Material& material) {
  wire::Material out;
  out.bsdf = static_cast<wire::Bsdf>(material.bsdf);
  if (material.seen_through_scattering) out.flags |= wire::kScattersRenderingRays;
  if (material.surface) out.flags |= wire::kTrapAtSurface;
  const double most = std::ranges::max(scattering_by_colour(material));
  out.scattering = static_cast<std::uint16_t>(std::lround(most * wire::kScatteringOne));
  out.gloss = static_cast<std::uint16_t>(std::lround(material.gloss * (1 << wire::kGlossFractionBits)));
  out.routine = static_cast<std::uint8_t>(material.routine);
  out.parameter_count = static_cast<std::uint8_t>(material.parameters.size());
  std::copy(material.parameters.begin(), material.parameters.end(), out.parameters.begin());
  return out;
}

RayEnergy max_energy(const Light& light, const Illumination& settings, const LitBox& box) {
  const double cell = smallest_cell(box), power = power_of(light), k = settings.rays_per_face_voxel;
  double to_cell = 0;  // share of the power that reaches the nearest cell
  if (std::holds_alternative<DirectionalLight>(light)) {
    to_cell = cell;
  } else {
    for (const Vec3 place : places(light, box)) {
      const double r = distance_to_faces(place, box),
                   solid_angle = std::min(cell / std::max(r * r, kSmallest), 2 * kPi);
      const bool printed = is_point(light) && settings.rules == EnergyRules::kAsPrinted;
      const double share = solid_angle / (is_point(light) && !printed ? 4 * kPi : kPi);
      to_cell = std::max(to_cell, share);
    }
  }
  return {power * to_cell / k, power * to_cell};
}

double flux_in_the_middle(const Light& light, const Illumination& settings, const LitBox& box) {
  const double power = power_of(light);
  if (std::holds_alternative<DirectionalLight>(light)) return power;
  if (const auto* area = std::get_if<RectangleLight>(&light)) {
    const Vec3 centre = times(area->corner, box.spacing) + 0.5 * (area->edge_u + area->edge_v);
    const Vec3 to = 0.5 * box.extent - centre;
    const double r = distance_to_middle(centre, box), away = length(to);
    const double facing = away > 0 ? dot(normalise(cross(area->edge_u, area->edge_v)), to) / away : 1;
    return power * std::max(facing, 0.1) / (kPi * r * r);
  }
  const Vec3 centre = is_point(light) ? times(std::get<PointLight>(light).position, box.spacing)
                                      : times(std::get<SphereLight>(light).centre, box.spacing);
  const double r = distance_to_middle(centre, box);
  const bool printed = is_point(light) && settings.rules == EnergyRules::kAsPrinted;
  return power / ((printed ? 1 : 4) * kPi * r * r);
}

double energy_unit(std::span<const Light> lights, const Illumination& settings, const LitBox& box, bool wide) {
  const double full = wide ? 16'777'215.0 : settings.albedo == Albedo::kHigh ? 15 : 255;
  const double saturated = wide ? 4'294'967'295.0 : 2047;
  double ray = 0, voxel = 0;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const RayEnergy max = max_energy(lights[i], settings, box);
    ray = std::max(ray, max.ray * brightest_of(settings, i));
    voxel += max.voxel * brightest_of(settings, i);
  }
  return std::max(ray / full, 2 * voxel / saturated);
}

std::vector<wire::Lamp> lamp_records(const View& view, double exposure) {
  std::vector<wire::Lamp> lamps;
  for (const Lamp& lamp : view.lamps) {
    const wire::IlluminateCommand place = light_command(lamp.light, {}, 1);
    const double radius = place.u[0];
    const double area = place.kind == wire::LightKind::kSphere ? 4 * kPi * radius * radius
                                                               : length(cross(to_vec3(place.u), to_vec3(place.v)));
    wire::Lamp record{.kind = place.kind, .position = place.position, .u = place.u, .v = place.v};
    for (std::size_t c = 0; c < 3; ++c) {
      const double word = lamp.colour[c] * power_of(lamp.light) / area * exposure * 65536;
      record.colour[c] = static_cast<std::uint32_t>(std::clamp(std::round(word), 0.0, 4294967295.0));
    }
    lamps.push_back(record);
  }
  return lamps;
}

wire::IlluminateCommand light_command(const Light& light, const Illumination& settings, double unit) {
  wire::IlluminateCommand command;
  command.albedo = static_cast<wire::Albedo>(settings.albedo);
  command.rules = static_cast<wire::EnergyRules>(settings.rules);
  command.rays_per_voxel = static_cast<std::uint32_t>(settings.rays_per_face_voxel);
  command.count = command.rays_per_voxel;
  command.energy = power_of(light) / unit;
  if (const auto* point = std::get_if<PointLight>(&light)) {
    command.kind = wire::LightKind::kPoint;
    command.position = to_array(point->position);
  } else if (const auto* sun = std::get_if<DirectionalLight>(&light)) {
    command.kind = wire::LightKind::kDirectional;
    command.u = to_array(gicube::unit(sun->towards));
  } else if (const auto* area = std::get_if<RectangleLight>(&light)) {
    command.kind = wire::LightKind::kRectangle;
    command.position = to_array(area->corner);
    command.u = to_array(area->edge_u);
    command.v = to_array(area->edge_v);
  } else {
    const auto& sphere = std::get<SphereLight>(light);
    command.kind = wire::LightKind::kSphere;
    command.position = to_array(sphere.centre);
    command.u = {sphere.radius, 0, 0};
  }
  return command;
}

}  // namespace gicube
