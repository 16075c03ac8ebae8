// The scenes whose accuracy is measured: the built-in one, and the real scans that lie beside the source tree.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gicube/scene/scene.h"
#include "reference/scene.h"
#include "scene/names.h"

namespace gicube::accuracy {

struct StudyScene {
  std::string name;
  std::string look;  // the preset's name, for the table
  samples::Scene scene;
  int max_volume_voxels = 0;  // what the board must hold; 0 = its default is enough

  // False for a scan that is not there.
  bool available() const;
};

// The buckyball with `buckyball_size` voxels an edge, then the scans in `data`. The image is left at its default size.
std::vector<StudyScene> study_scenes(const std::filesystem::path& data, int buckyball_size);

// Points into `setup`.
reference::Scene to_reference(const samples::SceneSetup& setup);

}  // namespace gicube::accuracy
