// From a parsed scene file to the structs of the scenegraph. A fault leaves that part of the scene at its default.
#pragma once

#include <filesystem>

#include "scene/graph/faults.h"
#include "scene/graph/source_reader.h"
#include "scene/scene.h"

namespace gicube::samples {

// World, materials, lights, illumination, engines. Paths of files are relative to `folder`.
void read_graph(const v1::Scene& source, const std::filesystem::path& folder, Faults& faults, Scene& scene);

World read_world(const v1::World& source, const std::filesystem::path& folder, Faults& faults);

}  // namespace gicube::samples
