// What is wrong with a scene file.
#pragma once

#include <string>

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "test.h"

namespace gicube::scene {

// The faults of this text as the file "a.scene" in the folder /data, or "none".
inline std::string faults_of(const std::string& text) {
  return message_of<InputError>([&] { parse_scene(text, "a.scene", "/data"); });
}

}  // namespace gicube::scene
