#include "turntable.h"

#include <string>

namespace example {

using namespace gicube::scene;

Scene turntable(const std::filesystem::path& scan) {
  Node table;
  table.name = "table";
  table.transforms = {Translate{{0, 0, -0.9}}};
  table.content = CylinderShape{.radius = 0.9, .height = 0.2, .inner_radius = 0, .rounding = 0.05};
  table.material = "wood";

  Node thing;
  thing.name = "thing";
  thing.transforms = {Rotate{{0, 0, 1}, 0}};  // the engine's
  thing.content = ScanContent{{.builtin = {}, .file = scan, .size = 0, .raw = {}, .spacing = {}}};
  thing.material = "scanned";

  World world;
  world.size = kSize;
  world.root.children = {table, thing};

  SceneMaterial wood, scanned;
  wood.name = "wood";
  wood.look = SolidLook{{0.6, 0.4, 0.25}, 0.5};
  wood.optics.bsdf = gicube::Bsdf::kDiffuse;
  wood.optics.scattering = 0.4;
  scanned.name = "scanned";
  scanned.tag = 1;
  scanned.look = find_preset("ramp");

  Scene scene;
  scene.world = world;
  scene.materials = {wood, scanned};
  scene.lights = {{"lamp", gicube::PointLight{{-1.5, -1, 2}, 30}, {1, 1, 1}}};
  set_albedo("low", "albedo", scene.lighting);
  scene.lighting.settings.rays_per_face_voxel = 4;
  scene.camera.eye = gicube::Vec3{0, -4, 2};
  scene.camera.look_at = gicube::Vec3{0, 0, -0.3};
  scene.camera.fov_degrees = 32;
  scene.view.width = scene.view.height = 256;
  scene.engines = {{"node[thing].transform[0].rotate.degrees", {}, 0, 45}};
  return scene;
}

gicube::Image picture(gicube::Board& board, const Scene& scene, double seconds) {
  const SceneSetup setup = set_up(at_time(scene, seconds));  // all nodes become voxels
  load(board, setup, false);
  board.set_shading(setup.shading);
  for (std::size_t tag = 0; tag < setup.optics.size(); ++tag) {
    board.set_material(setup.optics[tag], static_cast<int>(tag));
  }
  board.illuminate(setup.lights, setup.lighting.settings);
  return board.render(setup.view);
}

}  // namespace example
