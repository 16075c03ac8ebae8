// Stages of volumes that have closed forms, and boards for them.
#pragma once

#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "compose/picture.h"

namespace gicube::samples {

inline std::vector<Board> open_boards(const std::string& options = "", int count = 1) {
  std::vector<Board> boards;
  for (int i = 0; i < count; ++i) {
    boards.push_back(Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64" + options));
  }
  return boards;
}
inline constexpr const char* kWide = "&set=asic.datapath=wide";

// Density 0..1 by voxel; opacity of a voxel: `opacity` times its density. Nothing is shaded. Voxel 0 lies at the origin
// of the space, and a voxel is 1 long, until `to_voxels` says otherwise.
inline StageMedium medium(const Dims& dims, const Colour& colour, double opacity,
                          const std::function<double(Vec3)>& density) {
  StageMedium out{"medium", {}, {}};
  static_cast<VoxelWorld&>(out.setup) = VoxelWorld(dims, "medium", false);
  out.setup.volume.range = ValueRange{0, kMaxDensity};
  std::size_t index = 0;
  for (int z = 0; z < dims[2]; ++z) {
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x) out.setup.set_density(index++, density({double(x), double(y), double(z)}));
    }
  }
  out.setup.materials = {{{{{0, colour}}, {{0, 0}, {kMaxDensity, opacity}}}}};
  out.setup.box = whole_box(dims);
  out.setup.view.shade = false;
  return out;
}
inline StageMedium fog(const Dims& dims, const Colour& colour, double opacity) {
  return medium(dims, colour, opacity, [](Vec3) { return 1.0; });
}

// Seen along +z from `eye`, in parallel, one voxel a pixel. Surfaces have their own colours.
inline Stage stage_of(std::vector<StageMedium> media, std::vector<PlacedSurface> surfaces, Vec3 eye, int width,
                      int height) {
  Stage stage;
  stage.media = std::move(media);
  std::vector<Mesh> meshes;
  for (PlacedSurface& surface : surfaces) meshes.push_back(std::move(surface.mesh));
  stage.surfaces = std::move(surfaces);
  stage.meshes = std::make_shared<const MeshCaster>(std::move(meshes));
  stage.view.eye = eye;
  stage.view.look_at = eye + Vec3{0, 0, 1};
  stage.view.up = {0, 1, 0};
  stage.view.orthographic_height = height;
  stage.view.width = width, stage.view.height = height;
  stage.view.opacity_threshold = 1;
  stage.light = {0, 0, -1};
  stage.phong = {.ambient = 1, .diffuse = 0, .specular = 0};
  return stage;
}

inline Picture picture_of(const Stage& stage, const std::string& options = "") {
  std::vector<Board> boards = open_boards(options);
  std::vector<MediumCost> costs;
  return compose(stage, boards, costs);
}

}  // namespace gicube::samples
