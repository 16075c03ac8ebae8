#include "scene/graph/graph_reader.h"
#include "scene/common/checks.h"

#include <cmath>
#include <set>

namespace gicube::scene {
namespace {

constexpr int kMaxRays = 4096;             // as Illumination::rays_per_face_voxel
constexpr int kMaxFlights = 1023;          // as its lifetime
constexpr std::size_t kMaxEngines = 1000;  // chosen
constexpr int kMaxMaterials = 4;           // tags

SceneMaterial read_material(const v1::Material& source, int index, const std::string& field, bool in_world,
                            const NamedFiles& files, Faults& faults) {
  SceneMaterial result;
  result.name = source.name();
  result.tag = source.has_tag() ? static_cast<int>(std::min(source.tag(), 1000u)) : index;
  const int looks = int(source.has_solid()) + int(source.has_fog()) + int(source.has_transfer_function());
  faults.check(looks <= 1, field, "one of solid, fog and transfer_function", "several");
  faults.check(in_world || !(source.has_solid() || source.has_fog()), field,
               "a transfer_function, as for all volume files", "a solid or fog");
  if (source.has_solid()) {
    const v1::Solid& solid = source.solid();
    result.look = SolidLook{read_colour(faults, field + ".solid.colour", solid.colour()), solid.opacity()};
  }
  if (source.has_fog()) {
    const v1::Fog& fog = source.fog();
    result.look = FogLook{read_colour(faults, field + ".fog.colour", fog.colour()), fog.extinction()};
  }
  if (source.has_transfer_function()) {
    const std::string place = field + ".transfer_function";
    if (const auto function = read_transfer_function_of(faults, place, source.transfer_function(), files)) {
      result.look = *function;
    }
  }
  result.optics.scattering = source.scattering();
  result.scattering_colour = read_colour(faults, field + ".scattering_colour", source.scattering_colour());
  result.emission = source.emission();
  result.emission_colour = read_colour(faults, field + ".emission_colour", source.emission_colour());
  if (source.has_bsdf()) faults.gather_part(field, [&] { result.optics.bsdf = bsdf_named(source.bsdf()); });
  result.optics.gloss = source.gloss();
  result.optics.seen_through_scattering = source.seen_through_scattering();
  if (source.has_routine()) faults.gather_part(field, [&] { result.optics.routine = routine_named(source.routine()); });
  result.optics.surface = source.surface();
  for (const double parameter : source.parameter()) result.optics.parameters.push_back(static_cast<float>(parameter));
  faults.gather_part(field, [&] { check(result); });
  return result;
}

void read_materials(const v1::Scene& source, const NamedFiles& files, Faults& faults, Scene& scene) {
  faults.check(source.material_size() <= kMaxMaterials, "material", "at most 4, one a tag",
               std::to_string(source.material_size()));
  std::set<int> tags;
  std::set<std::string> names;
  for (int i = 0; i < source.material_size(); ++i) {
    const std::string& name = source.material(i).name();
    const std::string field = fmt::format("material[{}]", name.empty() ? std::to_string(i) : name);
    faults.check(!source.has_world() || !name.empty(), field + ".name", "a name", "none");
    scene.materials.push_back(read_material(source.material(i), i, field, source.has_world(), files, faults));
    faults.check(tags.insert(scene.materials.back().tag).second, field + ".tag", "a tag of its own",
                 std::to_string(scene.materials.back().tag));
    faults.check(name.empty() || names.insert(name).second, field + ".name", "a name of its own", in_quotes(name));
  }
}

SceneLight read_light(const v1::Light& source, const std::string& field, Faults& faults) {
  SceneLight result;
  result.name = source.name();
  result.colour = read_colour(faults, field + ".colour", source.colour());
  if (!faults.check_one(field, "one of towards, point, rectangle and sphere",
                        {source.has_towards(), source.has_point(), source.has_rectangle(), source.has_sphere()})) {
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
  faults.gather_part(field, [&] { check(result); });
  return result;
}

void read_lights(const v1::Scene& source, Faults& faults, Scene& scene) {
  for (int i = 0; i < source.light_size(); ++i) {
    const v1::Light& light_source = source.light(i);
    const std::string field =
        fmt::format("light[{}]", light_source.has_name() ? light_source.name() : std::to_string(i));
    scene.lights.push_back(read_light(light_source, field, faults));
    faults.check(!light_source.has_colour() || scene.lighting.colour_passes, field + ".colour",
                 "illumination.colour_passes with it: irradiance alone has no colour", "none");
  }
}

Lighting read_illumination(const v1::Illumination& source, Faults& faults) {
  Lighting result;
  faults.gather("illumination", [&] { set_albedo(source.albedo(), "albedo", result); });
  faults.gather("illumination", [&] { result.settings.rules = rules_named(source.rules(), "rules"); });
  Illumination& settings = result.settings;
  settings.rays_per_face_voxel =
      faults.check_whole("illumination.rays_per_face_voxel", source.rays_per_face_voxel(), 1, kMaxRays);
  settings.step = faults.check_range("illumination.step", source.step(), 1.0 / 64, 16);
  settings.jitter = source.jitter();
  settings.lifetime = faults.check_whole("illumination.lifetime", source.lifetime(), 0, kMaxFlights);
  settings.seed = source.seed();
  faults.check(source.exposure() >= 0 && std::isfinite(source.exposure()), "illumination.exposure",
               "a number above 0, or 0 for the driver's choice", shown(source.exposure()));
  result.exposure = source.exposure();
  result.colour_passes = source.colour_passes();
  return result;
}

void read_engines(const v1::Scene& source, Faults& faults, Scene& scene) {
  faults.check(static_cast<std::size_t>(source.engine_size()) <= kMaxEngines, "engine", "at most 1000",
               std::to_string(source.engine_size()));
  for (int i = 0; i < source.engine_size(); ++i) {
    const v1::Engine& from = source.engine(i);
    const std::string field = fmt::format("engine[{}]", i);
    Engine engine;
    engine.target = from.target();
    for (int k = 0; k < from.key_size(); ++k) {
      faults.check(from.key(k).has_time() && from.key(k).has_value(), fmt::format("{}.key[{}]", field, k),
                   "time and value", "one of them, or none");
      engine.keys.push_back({from.key(k).time(), from.key(k).value()});
    }
    engine.start = from.start();
    engine.rate = from.rate();
    faults.gather_part(field, [&] { check(engine); });
    if (!engine.target.empty()) {
      faults.gather(field, [&] { find_parameter(scene, engine.target); });
    }
    scene.engines.push_back(std::move(engine));
  }
}

// Checks that the materials of all nodes exist.
void check_names(const Scene& scene, Faults& faults) {
  if (!scene.world) return;
  const auto visit = [&](const auto& self, const Node& node, const std::string& material) -> void {
    const std::string& own = node.material.empty() ? material : node.material;
    if (!std::holds_alternative<Group>(node.content)) {
      const bool found = std::ranges::count(scene.materials, own, &SceneMaterial::name) > 0;
      faults.check(found && !own.empty(), "node[" + node.name + "].material", "a material of the scene",
                   own.empty() ? "none" : in_quotes(own));
    }
    for (const Node& child : node.children) self(self, child, own);
  };
  visit(visit, scene.world->root, "");
}

}  // namespace

void read_graph(const v1::Scene& source, const NamedFiles& files, Faults& faults, Scene& scene) {
  if (source.has_world()) scene.world = read_world(source.world(), files, faults);
  read_materials(source, files, faults, scene);
  if (source.has_illumination()) scene.lighting = read_illumination(source.illumination(), faults);
  read_lights(source, faults, scene);
  read_engines(source, faults, scene);
  if (source.has_background()) scene.background = read_colour(faults, "background", source.background());
  scene.view.lifetime = faults.check_whole("lifetime", source.lifetime(), 0, kMaxFlights);
  scene.view.high_albedo = source.high_albedo();
  faults.check(!source.high_albedo() || scene.lighting.on, "high_albedo", "an illumination with it", "none");
  scene.view.seed = source.seed();
  scene.own_codebook = source.own_codebook();
  check_names(scene, faults);
}

}  // namespace gicube::scene
