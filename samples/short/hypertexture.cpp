// Hypertexture [P §2; Perlin and Hoffert 1989]: a ball of fire, a soft solid with a surface displaced by noise.
//
//   c++ -std=c++20 -O2 hypertexture.cpp $(pkg-config --cflags --libs gicube) -o hypertexture
//   ./hypertexture
//
// Writes hypertexture.ppm. Prints the mean difference between the board's opacities along 1000 chords and integrals of
// the formula without voxels: the total error of voxels and samples. Returns 1 if it is above 0.01.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "picture.h"
#include "voxels.h"

using gicube::Vec3;

constexpr int kSize = 96;  // voxels along each edge
constexpr Vec3 kMiddle{47.5, 47.5, 47.5};
constexpr double kRadius = 27, kSoftness = 14;  // of the ball, and width of its surface; voxels
constexpr double kAmplitude = 15, kCell = 22;   // of the noise: greatest displacement, largest cells; voxels
constexpr double kOpacity = 0.07;               // of one voxel length at density 1

// Uniform random number in -1..1 for each point of the lattice.
double at_lattice(int x, int y, int z) {
  auto bits = static_cast<std::uint32_t>(x) * 0x8DA6B343u ^ static_cast<std::uint32_t>(y) * 0xD8163841u ^
              static_cast<std::uint32_t>(z) * 0xCB1AB31Fu;
  bits = (bits ^ bits >> 15) * 0x2C1B3C6Du;
  bits = (bits ^ bits >> 12) * 0x297A2D39u;
  return (bits ^ bits >> 15) / 2147483647.5 - 1;
}

// Smooth interpolation between values of the lattice.
double noise(Vec3 place) {
  const Vec3 cell{std::floor(place.x), std::floor(place.y), std::floor(place.z)}, within = place - cell;
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const auto weight = [](double t, int end) { return end == 1 ? t * t * (3 - 2 * t) : 1 - t * t * (3 - 2 * t); };
    sum += weight(within.x, i) * weight(within.y, j) * weight(within.z, k) *
           at_lattice(int(cell.x) + i, int(cell.y) + j, int(cell.z) + k);
  }
  return sum;
}

// 1 deep inside the displaced surface, 0 far outside.
double density(Vec3 place) {
  double turbulence = 0, share = 1;
  for (double cell = kCell; cell > 4; cell /= 2, share /= 2) turbulence += share * std::abs(noise((1 / cell) * place));
  const double depth = kRadius - length(place - kMiddle) + kAmplitude * (2 * turbulence - 1);
  const double ramp = std::clamp(0.5 + depth / kSoftness, 0.0, 1.0);
  return ramp * ramp * (3 - 2 * ramp);
}

int main() {
  const auto values = make_voxels({kSize, kSize, kSize}, density);
  auto board = gicube::Board::open("emu:");
  board.load_volume({.samples = std::as_bytes(std::span(values)),
                     .type = gicube::SampleType::kFloat32,
                     .dims = {kSize, kSize, kSize},
                     .range = gicube::ValueRange{0, 1},
                     .find_gradients = false});  // fire is not shaded
  board.set_transfer_function(
      {.colours = {{0, {0.4, 0.03, 0.01}}, {0.4, {0.85, 0.18, 0.02}}, {0.8, {1, 0.5, 0.08}}, {1, {1, 0.85, 0.5}}},
       .opacities = {{0, 0}, {1, kOpacity}}});
  gicube::View view;
  view.eye = {140, 110, -170};
  view.look_at = kMiddle;
  view.fov_degrees = 20;
  view.width = view.height = 320;
  view.shade = false;
  write_image("hypertexture.ppm", board.render(view), 0.03);

  // Chords between random places.
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> inside(0, kSize - 1.0);
  const auto place = [&] { return Vec3{inside(engine), inside(engine), inside(engine)}; };
  std::vector<gicube::HostRay> rays;
  for (std::uint32_t i = 0; i < 1000; ++i) rays.push_back(gicube::ray_between(i, place(), place()));
  const gicube::RayBatch traced = board.receive(board.submit(rays, {.type = gicube::RayType::kOpacity, .step = 0.5}));
  double error = 0;
  for (const gicube::TracedRay& ray : traced.rays) {
    const gicube::HostRay& sent = rays[ray.id];
    const Vec3 along = normalise(sent.direction);
    double depth = 0;
    constexpr double kStep = 0.1;  // voxels
    for (double at = kStep / 2; at < sent.length; at += kStep)
      depth -= kStep * std::log(1 - kOpacity * density(sent.position + at * along));
    error += std::abs(ray.opacity - (1 - std::exp(-depth))) / static_cast<double>(rays.size());
  }
  std::printf("mean error of the opacity of %zu chords: %.4f\n", rays.size(), error);
  return error > 0.01;
}
