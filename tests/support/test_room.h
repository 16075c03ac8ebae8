// A closed room of voxels: walls one voxel thick around a medium, for the tests of form factors.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>

#include "gicube/scene/scene.h"
#include "scene/names.h"
#include "voxels.h"

namespace gicube::reference {

enum RoomTag : std::uint8_t { kAir = 0, kWall = 1, kLamp = 2, kObstacle = 3 };

struct Room {
  int size = 8;      // voxels an edge inside of the walls
  double kappa = 0;  // of its air, a voxel
  double wall_albedo = 0, air_albedo = 0;
  Vec3 spacing{1, 1, 1};
  // Tag of a voxel, 0..size+1 each; unset: kAir inside, else kWall.
  std::function<std::uint8_t(int x, int y, int z)> tag{};
};

// The default tag.
inline std::uint8_t room_tag(const Room& room, int x, int y, int z) {
  const auto inside = [&room](int at) { return at >= 1 && at <= room.size; };
  return inside(x) && inside(y) && inside(z) ? kAir : kWall;
}

inline samples::SceneSetup setup_of(const Room& room) {
  samples::SceneSetup setup;
  const int edge = room.size + 2;
  setup.volume.dims = {edge, edge, edge};
  setup.volume.spacing = room.spacing;
  for_each_voxel({edge, edge, edge}, [&](int x, int y, int z) {
    const std::uint8_t tag = room.tag ? room.tag(x, y, z) : room_tag(room, x, y, z);
    setup.tags.push_back(tag);
    setup.volume.samples.push_back(std::byte{tag == kAir ? std::uint8_t{0} : std::uint8_t{255}});
  });
  const samples::TransferFunctionFile air{{{{0, {1, 1, 1}}}, {{0, 1 - std::exp(-room.kappa)}}}};
  const samples::TransferFunctionFile solid{{{{0, {1, 1, 1}}}, {{0, 0}, {255, 1}}}};
  setup.materials = {air, solid, solid, solid};
  setup.optics.resize(4);
  setup.scattering_colours.assign(4, {1, 1, 1});
  setup.optics[kAir].scattering = room.air_albedo;
  for (const std::uint8_t tag : {kWall, kLamp, kObstacle}) setup.optics[tag].scattering = room.wall_albedo;
  return setup;
}

}  // namespace gicube::reference
