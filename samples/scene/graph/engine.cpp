#include "scene/graph/engine.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <set>

#include "scene/program/input_error.h"
#include "scene/scene.h"

namespace gicube::samples {
namespace {

struct Step {
  std::string name;
  std::optional<std::string> index;
};

// "node[a b].transform[0].translate.x" as its steps; names in brackets may hold dots.
std::vector<Step> steps_of(const std::string& target) {
  std::vector<Step> steps;
  std::size_t at = 0;
  while (at < target.size()) {
    Step step;
    const std::size_t end = std::min(target.find_first_of(".[", at), target.size());
    step.name = target.substr(at, end - at);
    at = end;
    if (at < target.size() && target[at] == '[') {
      const std::size_t close = target.find(']', at);
      if (close == std::string::npos) return {};
      step.index = target.substr(at + 1, close - at - 1);
      at = close + 1;
    }
    steps.push_back(step);
    if (at < target.size() && target[at++] != '.') return {};
  }
  return steps;
}

std::optional<std::size_t> number(const std::string& text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

Node* find_node(Node& node, const std::string& name) {
  if (node.name == name) return &node;
  for (Node& child : node.children) {
    if (Node* found = find_node(child, name)) return found;
  }
  return nullptr;
}

// Follows a target's steps; nullptr where there is no such place.
class Finder {
 public:
  explicit Finder(const std::vector<Step>& steps) : steps_(steps) {}

  double* in(Scene& scene) {
    const std::string& first = name(0);
    if (first == "camera") return in_cameras(scene);
    if (first == "light" && has_index(0)) return in_lights(scene.lights);
    if (first == "node" && has_index(0) && scene.world) {
      Node* node = find_node(scene.world->root, *steps_[0].index);
      return node != nullptr ? in_node(*node) : nullptr;
    }
    if (first == "cut_plane" && has_index(0)) {
      CutPlane* plane = element(scene.view.cut_planes, 0);
      if (plane == nullptr) return nullptr;
      if (name(1) == "offset" && last(1)) return &plane->offset;
      return name(1) == "normal" ? part(plane->normal, 2) : nullptr;
    }
    return nullptr;
  }

 private:
  const std::string& name(std::size_t i) const {
    static const std::string kNone;
    return i < steps_.size() ? steps_[i].name : kNone;
  }
  bool has_index(std::size_t i) const { return i < steps_.size() && steps_[i].index; }
  bool last(std::size_t i) const { return i + 1 == steps_.size() && !steps_[i].index; }

  template <typename Element>
  Element* element(std::vector<Element>& list, std::size_t step) const {
    const auto index = has_index(step) ? number(*steps_[step].index) : std::nullopt;
    return index && *index < list.size() ? &list[*index] : nullptr;
  }

  double* part(Vec3& vector, std::size_t step) const {
    if (!last(step)) return nullptr;
    const std::string& axis = name(step);
    return axis == "x" ? &vector.x : axis == "y" ? &vector.y : axis == "z" ? &vector.z : nullptr;
  }
  double* part(std::optional<Vec3>& vector, std::size_t step) const { return vector ? part(*vector, step) : nullptr; }
  double* scalar(std::optional<double>& value, std::size_t step) const {
    return value && last(step) ? &*value : nullptr;
  }
  double* scalar(double& value, std::size_t step) const { return last(step) ? &value : nullptr; }

  double* in_cameras(Scene& scene) const {
    if (!has_index(0)) return in_camera(scene.camera);
    if (scene.camera.name == *steps_[0].index) return in_camera(scene.camera);
    for (CameraSettings& camera : scene.more_cameras) {
      if (camera.name == *steps_[0].index) return in_camera(camera);
    }
    return nullptr;
  }

  double* in_camera(CameraSettings& camera) const {
    if (name(1) == "eye") return part(camera.eye, 2);
    if (name(1) == "look_at") return part(camera.look_at, 2);
    if (name(1) == "up") return part(camera.up, 2);
    if (name(1) == "fov_degrees") return scalar(camera.fov_degrees, 1);
    if (name(1) == "orthographic_height") return scalar(camera.orthographic_height, 1);
    return nullptr;
  }

  double* in_lights(std::vector<SceneLight>& lights) const {
    for (SceneLight& light : lights) {
      if (light.name == *steps_[0].index) return std::visit([this](auto& l) { return in_light(l); }, light.light);
    }
    SceneLight* light = element(lights, 0);
    return light != nullptr ? std::visit([this](auto& l) { return in_light(l); }, light->light) : nullptr;
  }

  double* in_light(PointLight& light) const {
    if (name(1) == "power") return scalar(light.power, 1);
    return name(1) == "position" ? part(light.position, 2) : nullptr;
  }
  double* in_light(DirectionalLight& light) const {
    if (name(1) == "power") return scalar(light.irradiance, 1);
    return name(1) == "towards" ? part(light.towards, 2) : nullptr;
  }
  double* in_light(RectangleLight& light) const {
    if (name(1) == "power") return scalar(light.power, 1);
    if (name(1) == "corner") return part(light.corner, 2);
    if (name(1) == "edge_u") return part(light.edge_u, 2);
    return name(1) == "edge_v" ? part(light.edge_v, 2) : nullptr;
  }
  double* in_light(SphereLight& light) const {
    if (name(1) == "power") return scalar(light.power, 1);
    if (name(1) == "radius") return scalar(light.radius, 1);
    return name(1) == "centre" ? part(light.centre, 2) : nullptr;
  }

  double* in_node(Node& node) const {
    if (name(1) != "transform") return nullptr;
    Transform* transform = element(node.transforms, 1);
    if (transform == nullptr) return nullptr;
    if (auto* translate = std::get_if<Translate>(transform)) {
      return name(2) == "translate" ? part(translate->by, 3) : nullptr;
    }
    if (auto* scale = std::get_if<Scale>(transform)) return name(2) == "scale" ? part(scale->by, 3) : nullptr;
    auto* rotate = std::get_if<Rotate>(transform);
    if (rotate == nullptr || name(2) != "rotate") return nullptr;
    if (name(3) == "degrees") return scalar(rotate->degrees, 3);
    return name(3) == "axis" ? part(rotate->axis, 4) : nullptr;
  }

  const std::vector<Step>& steps_;
};

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
  const std::vector<Step> steps = steps_of(target);
  double* found = Finder(steps).in(scene);
  if (found == nullptr) {
    throw InputError("engine.target", "a number of a node's transform, a light, a camera or a cut plane of the scene",
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

}  // namespace gicube::samples
