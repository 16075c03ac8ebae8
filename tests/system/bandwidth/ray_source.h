// Boards with a volume in which nothing is visible, and rays for them: what such rays cost is known beforehand.
#pragma once

#include <gicube/testing.h>

#include <cstddef>
#include <vector>

namespace gicube::bandwidth {

// All rays cross the volume along z.
inline std::vector<HostRay> rays_along_z(std::size_t count, int edge) {
  std::vector<HostRay> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto side = static_cast<std::size_t>(edge - 1);
    rays[i].id = static_cast<std::uint32_t>(i);
    rays[i].position = {static_cast<double>(i % side) + 0.5, static_cast<double>(i / side % side) + 0.5, 0};
    rays[i].direction = {0, 0, 1};
  }
  return rays;
}

// Rays sample each voxel of their way: `edge` samples per ray.
inline const RayRequest kEveryVoxel{.step = 1, .leap = false, .sampling = {.shade = false}};

// A cube of ones, which no transfer function makes visible. The tables and such rays' registers are on the board.
inline Board open_with_volume(const test::BoardSetup& setup, int edge) {
  Board board = setup.open();
  const auto size = static_cast<std::size_t>(edge);
  const std::vector<std::byte> samples(size * size * size, std::byte{1});
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {edge, edge, edge}});
  View view;
  view.eye = {0, 0, -10};
  view.look_at = {0, 0, 0};
  view.width = view.height = 1;
  view.step = kEveryVoxel.step;
  view.shade = false;
  view.leap = kEveryVoxel.leap;
  board.render_to_framebuffer(view);
  return board;
}

}  // namespace gicube::bandwidth
