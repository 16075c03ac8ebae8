// What is wrong with a scene file.
#pragma once

#include <string>

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"

namespace gicube::scene {

// The faults of this text as the file "a.scene" in the folder /data, or "none".
inline std::string faults_of(const std::string& text) {
  try {
    parse_scene(text, "a.scene", "/data");
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

}  // namespace gicube::scene
