// The scenes that plans are checked with. Two were there while make_plan() was written. The first eight held-out ones
// were named in this file before it was run on them; in two of them the error was above its bound, and what was changed
// for that is told in docs/guide/plan.md. So the next seven were named, before it was run on them, and nothing was
// changed afterwards.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gicube/scene/scene.h"
#include "scene/names.h"

namespace gicube::plan_study {

struct StudyScene {
  std::string name;
  std::string look;  // for the table
  samples::Scene scene;
  int batch = 0;              // of held-out scenes: 1 or 2; 0: was there from the beginning
  int max_volume_voxels = 0;  // what the board must hold; 0 = its default is enough

  bool available() const;  // false for a scan that is not there
};

// `data`: the folder of the real scans; `sources`: of this tree.
std::vector<StudyScene> study_scenes(const std::filesystem::path& data, const std::filesystem::path& sources);

// Those that plans of light are checked with, each with its target. Three were there while plan_light() was written
// (batch 0); the others were named in this file before it was run on them.
struct LitScene {
  StudyScene study;
  double max_error = 0;  // of light and picture together
};
std::vector<LitScene> lit_scenes(const std::filesystem::path& data, const std::filesystem::path& sources);

}  // namespace gicube::plan_study
