// From a parsed scene file to the structs of the scenegraph: world, materials, lights, illumination, engines.
#pragma once

#include <filesystem>

#include "scene/graph/faults.h"
#include "scene/graph/source_reader.h"
#include "scene/scene.h"

namespace gicube::samples {

// A fault leaves that part of the scene at its default.
class GraphReader {
 public:
  GraphReader(Faults& faults, const std::filesystem::path& folder) : faults_(faults), folder_(folder) {}

  void read(const v1::Scene& source, Scene& scene);

 private:
  World world(const v1::World& source);
  Node node(const v1::Node& source, const std::string& place, int depth);
  Transform transform(const v1::Transform& source, const std::string& field);
  Content content(const v1::Node& source, const std::string& field);
  Shape box(const v1::Box& source, const std::string& field);
  void materials(const v1::Scene& source, Scene& scene);
  SceneMaterial material(const v1::Material& source, int index, const std::string& field, bool in_world);
  void lights(const v1::Scene& source, Scene& scene);
  SceneLight light(const v1::Light& source, const std::string& field);
  Lighting illumination(const v1::Illumination& source);
  void engines(const v1::Scene& source, Scene& scene);
  void check_names(const Scene& scene);

  Faults& faults_;
  const std::filesystem::path& folder_;
};

}  // namespace gicube::samples
