#include "gicube/scene/engine.h"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
#include <set>
#include <string_view>
#include <variant>

#include "gicube/scene/scene.h"
#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

// A number of the scene, or a vector with numbers .x, .y and .z; null if the scene does not set it.
struct Member {
  Member(std::string_view own, double& value) : name(own), number(&value) {}
  Member(std::string_view own, Vec3& value) : name(own), vector(&value) {}
  Member(std::string_view own, std::optional<double>& value) : name(own), number(value ? &*value : nullptr) {}
  Member(std::string_view own, std::optional<Vec3>& value) : name(own), vector(value ? &*value : nullptr) {}

  std::string_view name;
  double* number = nullptr;
  Vec3* vector = nullptr;
};

// The number that `place` names; null if there is none.
double* among(std::initializer_list<Member> members, std::string_view place) {
  for (const Member& member : members) {
    if (!place.starts_with(member.name)) continue;
    const std::string_view part = place.substr(member.name.size());
    if (part.empty() && member.number != nullptr) return member.number;
    if (member.vector == nullptr) continue;
    if (part == ".x") return &member.vector->x;
    if (part == ".y") return &member.vector->y;
    if (part == ".z") return &member.vector->z;
  }
  return nullptr;
}

// Removes "[INDEX]" from the front. An index may contain dots.
std::optional<std::string_view> cut_index(std::string_view& place) {
  const std::size_t close = place.find(']');
  if (!place.starts_with('[') || close == std::string_view::npos) return std::nullopt;
  const std::string_view index = place.substr(1, close - 1);
  place.remove_prefix(close + 1);
  return index;
}

template <typename Element>
Element* element(std::vector<Element>& list, std::string_view index) {
  const auto number = parse_number<std::size_t>(index);
  return number && *number < list.size() ? &list[*number] : nullptr;
}

double* find(CameraSettings& camera, std::string_view place) {
  return among({{".eye", camera.eye},
                {".look_at", camera.look_at},
                {".up", camera.up},
                {".fov_degrees", camera.fov_degrees},
                {".orthographic_height", camera.orthographic_height}},
               place);
}

double* find(PointLight& light, std::string_view place) {
  return among({{".power", light.power}, {".position", light.position}}, place);
}
double* find(DirectionalLight& light, std::string_view place) {
  return among({{".power", light.irradiance}, {".towards", light.towards}}, place);
}
double* find(RectangleLight& light, std::string_view place) {
  return among(
      {{".power", light.power}, {".corner", light.corner}, {".edge_u", light.edge_u}, {".edge_v", light.edge_v}},
      place);
}
double* find(SphereLight& light, std::string_view place) {
  return among({{".power", light.power}, {".radius", light.radius}, {".centre", light.centre}}, place);
}

double* find(Translate& translate, std::string_view place) { return among({{".translate", translate.by}}, place); }
double* find(Scale& scale, std::string_view place) { return among({{".scale", scale.by}}, place); }
double* find(Rotate& rotate, std::string_view place) {
  return among({{".rotate.degrees", rotate.degrees}, {".rotate.axis", rotate.axis}}, place);
}

template <typename... Kinds>
double* find(std::variant<Kinds...>& one, std::string_view place) {
  return std::visit([place](auto& kind) { return find(kind, place); }, one);
}

Node* node_named(Node& node, std::string_view name) {
  if (node.name == name) return &node;
  for (Node& child : node.children) {
    if (Node* found = node_named(child, name)) return found;
  }
  return nullptr;
}

double* find(Hypertexture& texture, std::string_view place) {
  return among({{".softness", texture.softness},
                {".frequency", texture.frequency},
                {".amplitude", texture.amplitude},
                {".time", texture.time},
                {".length", texture.length},
                {".curl", texture.curl},
                {".stretch", texture.stretch}},
               place);
}

double* in_node(Node* node, std::string_view place) {
  constexpr std::string_view kTransform = ".transform", kHypertexture = ".hypertexture";
  if (node == nullptr) return nullptr;
  if (place.starts_with(kHypertexture)) {
    auto* texture = std::get_if<Hypertexture>(&node->content);
    return texture != nullptr ? find(*texture, place.substr(kHypertexture.size())) : nullptr;
  }
  if (!place.starts_with(kTransform)) return nullptr;
  place.remove_prefix(kTransform.size());
  const auto index = cut_index(place);
  Transform* transform = index ? element(node->transforms, *index) : nullptr;
  return transform != nullptr ? find(*transform, place) : nullptr;
}

double* find(Scene& scene, std::string_view target) {
  const std::string_view kind = target.substr(0, target.find_first_of(".["));
  std::string_view place = target.substr(kind.size());
  const auto index = cut_index(place);
  if (kind == "camera") {
    if (!index || scene.camera.name == *index) return find(scene.camera, place);
    for (CameraSettings& camera : scene.more_cameras) {
      if (camera.name == *index) return find(camera, place);
    }
  }
  if (!index) return nullptr;
  if (kind == "light") {
    for (SceneLight& light : scene.lights) {
      if (light.name == *index) return find(light.light, place);
    }
    SceneLight* light = element(scene.lights, *index);
    return light != nullptr ? find(light->light, place) : nullptr;
  }
  if (kind == "node" && scene.world) return in_node(node_named(scene.world->root, *index), place);
  if (kind != "cut_plane") return nullptr;
  CutPlane* plane = element(scene.view.cut_planes, *index);
  return plane != nullptr ? among({{".normal", plane->normal}, {".offset", plane->offset}}, place) : nullptr;
}

}  // namespace

double Engine::at(double time) const {
  if (keys.empty()) return start + rate * time;
  if (time <= keys.front().time) return keys.front().value;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (time <= keys[i].time) {
      return std::lerp(keys[i - 1].value, keys[i].value, (time - keys[i - 1].time) / (keys[i].time - keys[i - 1].time));
    }
  }
  return keys.back().value;
}

void check(const Engine& engine) {
  if (engine.target.empty()) throw InputError("target", "the place of a number in the scene", "none");
  for (std::size_t i = 0; i < engine.keys.size(); ++i) {
    const EngineKey& key = engine.keys[i];
    if (!std::isfinite(key.time) || !std::isfinite(key.value)) throw InputError("key", "finite numbers", "others");
    if (i > 0 && !(key.time > engine.keys[i - 1].time)) {
      throw InputError("key.time", fmt::format("more than {}", engine.keys[i - 1].time), fmt::format("{}", key.time));
    }
  }
  if (!std::isfinite(engine.start) || !std::isfinite(engine.rate)) {
    throw InputError("start, rate", "finite numbers", "others");
  }
  if (!engine.keys.empty() && (engine.start != 0 || engine.rate != 0)) {
    throw InputError("key", "keys, or start and rate", "both");
  }
}

double& find_parameter(Scene& scene, const std::string& target) {
  double* found = find(scene, target);
  if (found == nullptr) {
    throw InputError("engine.target",
                     "a number of a node's transform or hypertexture, a light, a camera or a cut plane of the scene",
                     in_quotes(target));
  }
  return *found;
}

Scene at_time(const Scene& scene, double time) {
  Scene result = scene;
  std::set<const double*> driven;
  for (const Engine& engine : scene.engines) {
    double& value = find_parameter(result, engine.target);
    if (!driven.insert(&value).second) {
      throw InputError("engine.target", "one engine for each number", in_quotes(engine.target) + " twice");
    }
    value = engine.at(time);
  }
  return result;
}

}  // namespace gicube::scene
