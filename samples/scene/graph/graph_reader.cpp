#include "scene/graph/graph_reader.h"

#include <cmath>
#include <set>

#include "scene/graph/lighting_names.h"

namespace gicube::samples {
namespace {

constexpr std::uint32_t kMaxRays = 4096;     // as Illumination::rays_per_face_voxel
constexpr std::uint32_t kMaxFlights = 1023;  // as its lifetime
constexpr std::size_t kMaxEngines = 1000;    // chosen
constexpr int kMaxMaterials = 4;             // tags

}  // namespace

void GraphReader::read(const v1::Scene& source, Scene& scene) {
  if (source.has_world()) scene.world = world(source.world());
  materials(source, scene);
  if (source.has_illumination()) scene.lighting = illumination(source.illumination());
  lights(source, scene);
  engines(source, scene);
  if (source.has_background()) scene.background = read_colour(faults_, "background", source.background());
  faults_.check(source.lifetime() <= kMaxFlights, "lifetime", "0 to 1023", std::to_string(source.lifetime()));
  scene.view.lifetime = static_cast<int>(std::min(source.lifetime(), kMaxFlights));
  scene.view.high_albedo = source.high_albedo();
  faults_.check(!source.high_albedo() || scene.lighting.on, "high_albedo", "an illumination with it", "none");
  scene.view.seed = source.seed();
  scene.own_codebook = source.own_codebook();
  check_names(scene);
}

void GraphReader::materials(const v1::Scene& source, Scene& scene) {
  faults_.check(source.material_size() <= kMaxMaterials, "material", "at most 4, one a tag",
                std::to_string(source.material_size()));
  std::set<int> tags;
  std::set<std::string> names;
  for (int i = 0; i < source.material_size(); ++i) {
    const std::string& name = source.material(i).name();
    const std::string field = fmt::format("material[{}]", name.empty() ? std::to_string(i) : name);
    faults_.check(!source.has_world() || !name.empty(), field + ".name", "a name", "none");
    scene.materials.push_back(material(source.material(i), i, field, source.has_world()));
    faults_.check(tags.insert(scene.materials.back().tag).second, field + ".tag", "a tag of its own",
                  std::to_string(scene.materials.back().tag));
    faults_.check(name.empty() || names.insert(name).second, field + ".name", "a name of its own", in_quotes(name));
  }
}

SceneMaterial GraphReader::material(const v1::Material& source, int index, const std::string& field, bool in_world) {
  SceneMaterial result;
  result.name = source.name();
  result.tag = source.has_tag() ? static_cast<int>(std::min(source.tag(), 1000u)) : index;
  const int looks = int(source.has_solid()) + int(source.has_fog()) + int(source.has_transfer_function());
  faults_.check(looks <= 1, field, "one of solid, fog and transfer_function", "several");
  faults_.check(in_world || !(source.has_solid() || source.has_fog()), field,
                "a transfer_function, as for all volume files", "a solid or fog");
  if (source.has_solid()) {
    SolidLook solid;
    if (source.solid().has_colour()) {
      solid.colour = read_colour(faults_, field + ".solid.colour", source.solid().colour());
    }
    solid.opacity = source.solid().opacity();
    result.look = solid;
  }
  if (source.has_fog()) {
    FogLook fog;
    if (source.fog().has_colour()) fog.colour = read_colour(faults_, field + ".fog.colour", source.fog().colour());
    fog.extinction = source.fog().extinction();
    result.look = fog;
  }
  if (source.has_transfer_function()) {
    const auto function =
        read_transfer_function_of(faults_, field + ".transfer_function", source.transfer_function(), folder_);
    if (function) result.look = *function;
  }
  result.optics.scattering = source.scattering();
  if (source.has_scattering_colour()) {
    result.scattering_colour = read_colour(faults_, field + ".scattering_colour", source.scattering_colour());
  }
  result.emission = source.emission();
  if (source.has_emission_colour()) {
    result.emission_colour = read_colour(faults_, field + ".emission_colour", source.emission_colour());
  }
  if (source.has_bsdf()) faults_.gather_part(field, [&] { result.optics.bsdf = bsdf_named(source.bsdf()); });
  result.optics.gloss = source.gloss();
  result.optics.seen_through_scattering = source.seen_through_scattering();
  if (source.has_routine()) {
    faults_.gather_part(field, [&] { result.optics.routine = routine_named(source.routine()); });
  }
  result.optics.surface = source.surface();
  for (const double parameter : source.parameter()) result.optics.parameters.push_back(static_cast<float>(parameter));
  faults_.gather_part(field, [&] { check(result); });
  return result;
}

void GraphReader::lights(const v1::Scene& source, Scene& scene) {
  for (int i = 0; i < source.light_size(); ++i) {
    const v1::Light& light_source = source.light(i);
    const std::string field =
        fmt::format("light[{}]", light_source.has_name() ? light_source.name() : std::to_string(i));
    scene.lights.push_back(light(light_source, field));
    faults_.check(!light_source.has_colour() || scene.lighting.colour_passes, field + ".colour",
                  "illumination.colour_passes with it: irradiance alone has no colour", "none");
  }
}

SceneLight GraphReader::light(const v1::Light& source, const std::string& field) {
  SceneLight result;
  result.name = source.name();
  if (source.has_colour()) result.colour = read_colour(faults_, field + ".colour", source.colour());
  const int kinds =
      int(source.has_towards()) + int(source.has_point()) + int(source.has_rectangle()) + int(source.has_sphere());
  if (kinds != 1) {
    faults_.fault(field, "one of towards, point, rectangle and sphere", kinds == 0 ? "none" : "several");
    return result;
  }
  const auto vector = [](const v1::Vector& v) { return Vec3{v.x(), v.y(), v.z()}; };
  const double power = source.power();
  if (source.has_towards()) result.light = DirectionalLight{vector(source.towards()), power};
  if (source.has_point()) result.light = PointLight{vector(source.point().position()), power};
  if (source.has_rectangle()) {
    const v1::RectangleLight& rectangle = source.rectangle();
    result.light =
        RectangleLight{vector(rectangle.corner()), vector(rectangle.edge_u()), vector(rectangle.edge_v()), power};
  }
  if (source.has_sphere()) {
    result.light = SphereLight{vector(source.sphere().centre()), source.sphere().radius(), power};
  }
  faults_.gather_part(field, [&] { check(result); });
  return result;
}

Lighting GraphReader::illumination(const v1::Illumination& source) {
  Lighting result;
  faults_.gather("illumination", [&] { set_albedo(source.albedo(), "albedo", result); });
  faults_.gather("illumination", [&] { result.settings.rules = rules_named(source.rules(), "rules"); });
  const auto range = [this](const char* field, double value, double low, double high) {
    faults_.check(value >= low && value <= high, std::string("illumination.") + field,
                  shown(low) + " to " + shown(high), shown(value));
  };
  range("rays_per_face_voxel", source.rays_per_face_voxel(), 1, kMaxRays);
  range("step", source.step(), 1.0 / 64, 16);
  range("lifetime", source.lifetime(), 0, kMaxFlights);
  faults_.check(source.exposure() >= 0 && std::isfinite(source.exposure()), "illumination.exposure",
                "a number above 0, or 0 for the driver's choice", shown(source.exposure()));
  Illumination& settings = result.settings;
  settings.rays_per_face_voxel = static_cast<int>(std::min(source.rays_per_face_voxel(), kMaxRays));
  settings.step = source.step();
  settings.jitter = source.jitter();
  settings.lifetime = static_cast<int>(std::min(source.lifetime(), kMaxFlights));
  settings.seed = source.seed();
  result.exposure = source.exposure();
  result.colour_passes = source.colour_passes();
  return result;
}

void GraphReader::engines(const v1::Scene& source, Scene& scene) {
  faults_.check(static_cast<std::size_t>(source.engine_size()) <= kMaxEngines, "engine", "at most 1000",
                std::to_string(source.engine_size()));
  for (int i = 0; i < source.engine_size(); ++i) {
    const v1::Engine& from = source.engine(i);
    const std::string field = fmt::format("engine[{}]", i);
    Engine engine;
    engine.target = from.target();
    for (int k = 0; k < from.key_size(); ++k) {
      faults_.check(from.key(k).has_time() && from.key(k).has_value(), fmt::format("{}.key[{}]", field, k),
                    "time and value", "one of them, or none");
      engine.keys.push_back({from.key(k).time(), from.key(k).value()});
    }
    engine.start = from.start();
    engine.rate = from.rate();
    faults_.gather_part(field, [&] { check(engine); });
    if (!engine.target.empty()) {
      faults_.gather(field, [&] { find_parameter(scene, engine.target); });
    }
    scene.engines.push_back(std::move(engine));
  }
}

// Materials that nodes name must be there.
void GraphReader::check_names(const Scene& scene) {
  if (!scene.world) return;
  const auto visit = [&](const auto& self, const Node& node, const std::string& material) -> void {
    const std::string& own = node.material.empty() ? material : node.material;
    if (!std::holds_alternative<Group>(node.content)) {
      bool found = false;
      for (const SceneMaterial& candidate : scene.materials) found = found || candidate.name == own;
      faults_.check(found && !own.empty(), "node[" + node.name + "].material", "a material of the scene",
                    own.empty() ? "none" : in_quotes(own));
    }
    for (const Node& child : node.children) self(self, child, own);
  };
  visit(visit, scene.world->root, "");
}

}  // namespace gicube::samples
