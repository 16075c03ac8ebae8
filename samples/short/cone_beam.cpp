// Cone-beam reconstruction [P §5.6] by the method of Feldkamp, Davis and Kress (1984).
//
// The host filters the projections of a source that moves around the object, and the board backprojects them: each ray
// adds a constant amount to the voxels on its path. Rays diverge from the source, so their density decreases with the
// square of the distance, which is the method's weight. docs/guide/cone_beam.md derives the amounts.
//
//   c++ -std=c++20 -O2 cone_beam.cpp $(pkg-config --cflags --libs gicube) -o cone_beam
//   ./cone_beam
//
// Writes cone_beam.ppm: the middle slice of the object and of the reconstruction. Prints the mean density
// near the middle of the large ball, and its error. Returns 1 if that is above 2%.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "picture.h"

using gicube::Vec3;
using std::numbers::pi;

constexpr int kSize = 64;  // voxels along each edge; a voxel's edge is the unit of length
constexpr Vec3 kMiddle{31.5, 31.5, 31.5};
constexpr double kToAxis = 180, kToDetector = 360;      // from the source
constexpr int kViews = 96, kColumns = 176, kRows = 96;  // pixels of the detector
constexpr double kPitch = 1.0;                          // between pixels: half a voxel at the axis
constexpr double kAtAxis = kPitch * kToAxis / kToDetector;

struct Ball {
  Vec3 centre;
  double radius, density;  // per unit of length; overlapping balls add their densities
};
constexpr Ball kObject[] = {{kMiddle, 26, 1.0},
                            {{44, 36, 31.5}, 6, 0.8},
                            {{20, 40, 30}, 7, -0.7},
                            {{30, 15, 33}, 4, 1.5},
                            {{41, 18, 31}, 3, -0.9}};

double density(Vec3 place) {
  double sum = 0;
  for (const Ball& ball : kObject) sum += length(place - ball.centre) < ball.radius ? ball.density : 0;
  return sum;
}

// Exact line integral through all balls.
double projection(Vec3 source, Vec3 direction) {
  double sum = 0;
  for (const Ball& ball : kObject) {
    const Vec3 offset = cross(ball.centre - source, direction);
    sum += 2 * ball.density * std::sqrt(std::max(0.0, ball.radius * ball.radius - dot(offset, offset)));
  }
  return sum;
}

// Convolves a row with the band-limited ramp (Kak and Slaney, chapter 3), scaled to the axis.
std::vector<double> filtered(const std::vector<double>& row) {
  std::vector<double> out(row.size(), 0.0);
  for (int i = 0; i < kColumns; ++i) {
    for (int j = 0; j < kColumns; ++j) {
      const int apart = std::abs(i - j);
      if (apart != 0 && apart % 2 == 0) continue;
      const double ramp = apart == 0 ? 1 / (4 * kAtAxis) : -1 / (pi * pi * apart * apart * kAtAxis);
      out[static_cast<std::size_t>(i)] += ramp * row[static_cast<std::size_t>(j)];
    }
  }
  return out;
}

int main() {
  const std::vector<std::byte> nothing(kSize * kSize * kSize);
  auto board = gicube::Board::open("emu:");
  board.load_volume({.samples = nothing, .dims = {kSize, kSize, kSize}, .find_gradients = false});
  board.clear_sums(1e-5);  // one unit of a voxel's sum, as a density

  for (int view = 0; view < kViews; ++view) {
    const double turn = 2 * pi * view / kViews;
    const Vec3 outwards{std::cos(turn), std::sin(turn), 0}, across{-std::sin(turn), std::cos(turn), 0}, up{0, 0, 1};
    const Vec3 source = kMiddle + kToAxis * outwards, detector = source - kToDetector * outwards;
    std::vector<gicube::HostRay> rays;
    for (int row = 0; row < kRows; ++row) {
      const double v = (row - (kRows - 1) / 2.0) * kPitch;
      std::vector<gicube::HostRay> to_pixels;
      std::vector<double> weighted, slants;
      for (int column = 0; column < kColumns; ++column) {
        const double u = (column - (kColumns - 1) / 2.0) * kPitch;
        to_pixels.push_back(gicube::ray_between(0, source, detector + u * across + v * up));
        const gicube::HostRay& ray = to_pixels.back();
        slants.push_back(kToDetector / ray.length);  // the cosine to the central ray
        weighted.push_back(slants.back() * projection(source, normalise(ray.direction)));
      }
      const std::vector<double> values = filtered(weighted);
      constexpr double kArc = pi / kViews;  // half of a view's part of the turn, because each line is measured twice
      for (std::size_t i = 0; i < kColumns; ++i) {
        const auto part = gicube::clip_to_volume(to_pixels[i], {kSize, kSize, kSize});
        if (!part) continue;
        rays.push_back(*part);
        rays.back().energy = kArc * values[i] * slants[i] * kAtAxis * kAtAxis;
      }
    }
    board.receive(board.submit(rays, {.type = gicube::RayType::kBackproject, .step = 1}));
  }
  const std::vector<float> found = board.read_sums({{0, 0, 0}, {kSize, kSize, kSize}});

  std::vector<gicube::Colour> pixels;
  double mean = 0, squares = 0;
  int inner = 0, all = 0;
  for (int y = kSize - 1; y >= 0; --y) {
    for (int x = 0; x < 2 * kSize; ++x) {
      const Vec3 place{double(x % kSize), double(y), kSize / 2};
      const double value = found[static_cast<std::size_t>((kSize / 2 * kSize + y) * kSize + x % kSize)];
      const double grey = (x < kSize ? density(place) : value) / 2.5;
      pixels.push_back({grey, grey, grey});
      if (x < kSize) continue;
      squares += std::pow(value - density(place), 2);
      ++all;
      if (length(place - kMiddle) > 4) continue;  // only the large ball is near the middle
      mean += value;
      ++inner;
    }
  }
  write_display_colours("cone_beam.ppm", 2 * kSize, pixels);
  const double error = mean / inner / kObject[0].density - 1;
  std::printf("density about the middle %.4f, the object's %.4f, error %.2f%%; RMS error of the slice %.3f\n",
              mean / inner, kObject[0].density, 100 * error, std::sqrt(squares / all));
  return std::abs(error) > 0.02;
}
