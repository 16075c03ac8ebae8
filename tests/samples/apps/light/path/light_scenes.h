// Small scenes of light, and each as the reference's path tracer takes it.
#pragma once

#include <string>

#include "gicube/scene/scene.h"
#include "light_reference/path_scene_of.h"
#include "scene/names.h"

namespace gicube::samples {

inline const std::string kView = R"(
  camera { eye { x: 0.3 y: -4.2 z: 0.9 } look_at { z: -0.1 } fov_degrees: 26 } image { width: 32 height: 32 } )";

inline const std::string kRoom = R"(
  node { name: "red wall" material: "red" box { low { x: -1.3 y: -1.3 z: -1.3 } high { x: -0.8 y: 1.3 z: 1.3 } } }
  node { name: "floor" material: "white" box { low { x: -0.8 y: -1.3 z: -1.3 } high { x: 1.3 y: 1.3 z: -0.8 } } }
  node { name: "back" material: "white" box { low { x: -0.8 y: 0.8 z: -1 } high { x: 1.3 y: 1.3 z: 1.3 } } } )";

inline const std::string kWalls = R"(
  material { name: "white" solid { } scattering: 0.7 bsdf: "diffuse" }
  material { name: "red" solid { } scattering: 0.8 scattering_colour { red: 1 green: 0.2 blue: 0.1 }
    bsdf: "diffuse" } )";

struct LightScene {
  std::string name, text;
};

inline LightScene fog_scene() {
  return {"lamp in fog",
          "world { size: 24 node { material: \"fog\" box { low { x: -3 y: -3 z: -3 } high { x: 3 y: 3 z: 3 } } } }"
          "material { name: \"fog\" fog { extinction: 1.5 } scattering: 0.9"
          "  scattering_colour { red: 1 green: 0.8 blue: 0.5 } bsdf: \"isotropic\" }"
          "light { point { position { x: 0.2 y: -0.3 z: 1.4 } } power: 30 }" +
              kView};
}

inline LightScene forward_scene() {
  return {
      "sun in forward scattering fog",
      "world { size: 24 node { material: \"fog\" sphere { radius: 0.8 } } }"
      "material { name: \"fog\" fog { extinction: 4 } scattering: 0.95 bsdf: \"trap\" routine: \"henyey_greenstein\""
      "  parameter: 0.6 }"
      "light { towards { x: 1 y: 0.5 z: 1.5 } power: 3 }" +
          kView};
}

inline LightScene room_scene() {
  return {
      "room with fog",
      "world { size: 28 " + kRoom +
          "node { material: \"fog\" box { low { x: -3 y: -3 z: -3 } high { x: 3 y: 3 z: 3 } } } }" + kWalls +
          "material { name: \"fog\" fog { extinction: 0.3 } scattering: 0.8 bsdf: \"isotropic\" }"
          "light { rectangle { corner { x: -0.4 y: 0.4 z: 1.5 } edge_u { x: 0.8 } edge_v { y: -0.8 } } power: 20 }" +
          kView};
}

inline LightScene mirror_scene() {
  return {
      "mirror ball",
      "world { size: 28 " + kRoom +
          "node { material: \"mirror\" transform { translate { x: 0.3 y: 0.1 z: -0.25 } } sphere { radius: 0.45 } } }" +
          kWalls +
          "material { name: \"mirror\" solid { } scattering: 0.95 bsdf: \"specular\" }"
          "light { sphere { centre { x: 0.9 y: -0.7 z: 1.6 } radius: 0.6 } power: 25 }" +
          kView};
}

inline LightScene glass_scene() {
  return {
      "glass ball",
      "world { size: 32 " + kRoom +
          "node { material: \"glass\" transform { translate { x: 0.25 y: 0.0 z: -0.15 } } sphere { radius: 0.45 } } }" +
          kWalls +
          "material { name: \"glass\" solid { } scattering: 1 bsdf: \"trap\" routine: \"fresnel\" surface: true"
          "  parameter: 1.5 }"
          "light { sphere { centre { x: 0.2 y: -0.3 z: 1.8 } radius: 0.65 } power: 25 }" +
          kView};
}

inline SceneSetup setup_of(const LightScene& scene) {
  Scene read = parse_scene(scene.text, scene.name, ".");
  read.lighting.on = true;
  return set_up(read, 1);
}

}  // namespace gicube::samples
