#include <gicube/board.h>

#include <algorithm>
#include <cstdio>

int main() {
  constexpr int n = 64;  // a soft ball in a cube of bytes
  std::vector<std::byte> voxels;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const double radius = length(gicube::Vec3{x - 31.5, y - 31.5, z - 31.5});
        voxels.push_back(static_cast<std::byte>(std::clamp(128 + 16 * (24 - radius), 0.0, 255.0)));
      }
    }
  }
  auto board = gicube::Board::open("emu:");  // a private emulated board
  board.load_volume({.samples = voxels, .type = gicube::SampleType::kUint8, .dims = {n, n, n}});
  board.set_transfer_function({.colours = {{0, {1.0, 0.6, 0.3}}}, .opacities = {{96, 0.0}, {160, 0.4}}});
  gicube::View view;
  view.eye = {150, 120, -60};
  view.look_at = {31.5, 31.5, 31.5};
  const gicube::Image image = board.render(view);
  const gicube::Pixel centre = image.at(view.width / 2, view.height / 2);
  std::printf("centre %d %d %d, alpha %.3f, %.2f simulated ms\n", centre.red, centre.green, centre.blue,
              centre.alpha / 4095.0, gicube::to_ms(board.now()));
}
