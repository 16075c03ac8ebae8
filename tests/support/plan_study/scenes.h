// The scenes that plans are checked with. Two were there while make_plan() was written; the others, the held-out ones, were
// named in this file before it was run on them, and nothing in it was changed for them afterwards.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/scene.h"

namespace gicube::plan_study {

struct StudyScene {
  std::string name;
  std::string look;  // for the table
  samples::Scene scene;
  bool held_out = true;
  int max_volume_voxels = 0;  // what the board must hold; 0 = its default is enough

  bool available() const;  // false for a scan that is not there
};

// `data`: the folder of the real scans; `sources`: of this tree.
std::vector<StudyScene> study_scenes(const std::filesystem::path& data, const std::filesystem::path& sources);

}  // namespace gicube::plan_study
