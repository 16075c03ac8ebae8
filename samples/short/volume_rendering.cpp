// Volume rendering [P §2.1]: a translucent ball around three dense ones.
//
// The program makes a volume from a formula and sets a transfer function for colours and opacities; the board renders
// it.
//
//   c++ -std=c++20 -O2 volume_rendering.cpp $(pkg-config --cflags --libs gicube) -o volume_rendering
//   ./volume_rendering
//
// Writes volume_rendering.ppm. Prints the opacity of the middle pixel and the RMS error of all opacities against their
// closed form, 1 - exp(-sum of extinction times chord). Returns 1 if that error is above 0.01.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "picture.h"
#include "voxels.h"

using gicube::Vec3;

constexpr int kSize = 64;  // voxels along each edge
constexpr Vec3 kMiddle{31.5, 31.5, 31.5};
constexpr double kOuter = 28, kInner = 7;                              // radii, voxels
constexpr double kThinOpacity = 0.02, kDenseOpacity = 0.3;             // of one voxel length
constexpr Vec3 kDense[] = {{46, 38, 24}, {22, 44, 40}, {30, 17, 28}};  // centres of the dense balls

// Length inside a ball of the line through `place` along the unit vector `direction`.
double chord(Vec3 place, Vec3 direction, Vec3 centre, double radius) {
  const Vec3 offset = cross(centre - place, direction);
  return 2 * std::sqrt(std::max(0.0, radius * radius - dot(offset, offset)));
}

int main() {
  // 0.25 at the surface of the thin ball, 0.75 at those of the dense ones. Values rise over a few voxels inwards, so
  // that the transfer function's steps find the surfaces between voxels.
  const auto values = make_voxels({kSize, kSize, kSize}, [](Vec3 place) {
    double value = std::clamp(0.25 + (kOuter - length(place - kMiddle)) / 4, 0.0, 0.5);
    for (const Vec3& centre : kDense) value = std::max(value, 0.75 + (kInner - length(place - centre)) / 4);
    return value;
  });
  auto board = gicube::Board::open("emu:");  // a private emulated board
  board.load_volume({.samples = std::as_bytes(std::span(values)),
                     .type = gicube::SampleType::kFloat32,
                     .dims = {kSize, kSize, kSize},
                     .range = gicube::ValueRange{0, 1}});
  board.set_transfer_function(
      {.colours = {{0.75, {0.6, 0.85, 1.0}}, {0.75, {1.0, 0.5, 0.15}}},
       .opacities = {{0.25, 0}, {0.25, kThinOpacity}, {0.75, kThinOpacity}, {0.75, kDenseOpacity}}});
  board.set_shading({.phong = {.ambient = 0.3, .diffuse = 0.9, .specular = 0.6}, .light = {0.2, 1, -1}});

  gicube::View view;
  view.eye = {100, 80, -60};
  view.look_at = kMiddle;
  view.orthographic_height = kSize;  // parallel rays; the picture is as high as the volume's edge
  view.width = view.height = 320;
  view.step = 0.25;            // voxels
  view.opacity_threshold = 1;  // no ray ends early, so that opacities are exact
  const gicube::Image image = board.render(view);
  write_image("volume_rendering.ppm", image);

  const Vec3 forward = normalise(view.look_at - view.eye), right = normalise(cross(forward, view.up));
  const Vec3 up = cross(right, forward);
  const double thin = -std::log(1 - kThinOpacity), dense = -std::log(1 - kDenseOpacity);  // extinctions per voxel
  double squares = 0, middle = 0;
  for (int row = 0; row < view.height; ++row) {
    for (int column = 0; column < view.width; ++column) {
      const double u = (column + 0.5) / view.width - 0.5, v = 0.5 - (row + 0.5) / view.height;
      const Vec3 place = view.eye + kSize * (u * right + v * up);
      double depth = thin * chord(place, forward, kMiddle, kOuter);
      for (const Vec3& centre : kDense) depth += (dense - thin) * chord(place, forward, centre, kInner);
      const double expected = 1 - std::exp(-depth);
      if (row == view.height / 2 && column == view.width / 2) middle = expected;
      squares += std::pow(image.at(column, row).alpha / 4095.0 - expected, 2);
    }
  }
  const double error = std::sqrt(squares / static_cast<double>(image.pixels.size()));
  std::printf("opacity of the middle pixel %.4f, closed form %.4f; RMS error of all pixels %.4f\n",
              image.at(view.width / 2, view.height / 2).alpha / 4095.0, middle, error);
  return error > 0.01;
}
