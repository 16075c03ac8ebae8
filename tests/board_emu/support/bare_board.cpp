#include "bare_board.h"

#include <cmath>

namespace gicube::emu {

wire::Ray host_ray(std::uint32_t id, const std::array<double, 3>& position, const std::array<double, 3>& direction) {
  wire::Ray ray;
  ray.set_host_id(id);
  ray.flags = wire::kHostRay;
  const double length = std::hypot(direction[0], direction[1], direction[2]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.position[axis] = static_cast<std::uint32_t>(std::lround(position[axis] * wire::kVoxel));
    ray.direction[axis] =
        static_cast<std::int16_t>(std::lround(direction[axis] / length * (1 << wire::kDirectionFractionBits)));
  }
  return ray;
}

wire::RenderCommand corner_view(const std::array<int, 3>& size, int image_size) {
  wire::RenderCommand view;
  view.width = view.height = static_cast<std::uint16_t>(image_size);
  const double edge = size[0], pixel = 1.1 / image_size;
  // Looks along (-1, -1, -1) / sqrt 3; right and down complete the frame.
  const std::array<double, 3> forward{-0.57735, -0.57735, -0.57735}, right{0.70711, -0.70711, 0},
      down{0.40825, 0.40825, -0.8165};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    view.origin[axis] = size[axis] / 2.0 - 1.7 * edge * forward[axis];
    view.du[axis] = pixel * right[axis];
    view.dv[axis] = pixel * down[axis];
    view.forward[axis] = forward[axis] - 0.55 * right[axis] - 0.55 * down[axis];
  }
  return view;
}

}  // namespace gicube::emu
