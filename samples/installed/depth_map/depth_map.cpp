#include "depth_map.h"

#include <algorithm>
#include <deque>

namespace example {
namespace {

std::vector<gicube::HostRay> row_of_rays(int edge, int width, int height, int row) {
  const double last = edge - 1;
  std::vector<gicube::HostRay> rays(static_cast<std::size_t>(width));
  for (int x = 0; x < width; ++x) {
    gicube::HostRay& ray = rays[static_cast<std::size_t>(x)];
    ray.id = static_cast<std::uint32_t>(row * width + x);
    ray.position = {(x + 0.5) / width * last, (row + 0.5) / height * last, 0};
    ray.direction = {0, 0, 1};
  }
  return rays;
}

}  // namespace

std::vector<std::byte> ball(int edge, double radius) {
  const double middle = (edge - 1) / 2.0;
  std::vector<std::byte> voxels;
  for (int z = 0; z < edge; ++z) {
    for (int y = 0; y < edge; ++y) {
      for (int x = 0; x < edge; ++x) {
        const double distance = gicube::length({x - middle, y - middle, z - middle});
        voxels.push_back(static_cast<std::byte>(std::clamp(128 + 64 * (radius - distance), 0.0, 255.0)));
      }
    }
  }
  return voxels;
}

void load(gicube::Board& board, const std::vector<std::byte>& voxels, int edge) {
  board.load_volume({.samples = voxels, .type = gicube::SampleType::kUint8, .dims = {edge, edge, edge}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{128, 0}, {128, 1}}});
}

DepthMap depth_map(gicube::Board& board, int edge, int width, int height, int in_flight,
                   gicube::Picoseconds host_time) {
  DepthMap map{width, height, std::vector<float>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
  const gicube::RayRequest first_hit{.type = gicube::RayType::kFirstHit, .opacity = 0.5, .step = 0.25};
  std::vector<gicube::TracedRay> traced(static_cast<std::size_t>(width));
  std::deque<gicube::Ticket> under_way;
  for (int row = 0; row < height || !under_way.empty();) {
    if (row < height && under_way.size() < static_cast<std::size_t>(in_flight)) {
      under_way.push_back(board.submit(row_of_rays(edge, width, height, row++), first_hit));
      continue;
    }
    board.receive(under_way.front(), traced);
    under_way.pop_front();
    for (const gicube::TracedRay& ray : traced) {
      map.depths[ray.id] = ray.opacity >= first_hit.opacity ? static_cast<float>(ray.position.z) : -1.0f;
    }
    board.host_compute(host_time);
  }
  return map;
}

}  // namespace example
