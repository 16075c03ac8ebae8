// Global illumination [P §2.2] in two passes: lighting rays deposit their energy in the volume, then it lights
// pictures.
//
// A lamp is above a corner with a red wall, a white ball and a blue one. All surfaces scatter light diffusely
// (Lambert), so that balls and floor receive colour from neighbouring surfaces. The card has an irradiance word for
// each of three colours.
//
//   c++ -std=c++20 -O2 global_illumination.cpp $(pkg-config --cflags --libs gicube) -o global_illumination
//   ./global_illumination
//
// Writes global_illumination.ppm. Prints the balance of the lamp's energy. Returns 1 if the light that enters the
// volume differs by more than 0.1% from its closed form, the lamp's power times the solid angle of the volume's top
// over 4 pi, or if the sum of the irradiance differs from the deposited energy.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>

#include "picture.h"

using gicube::Vec3;
using std::numbers::pi;

constexpr int kSize = 64;                       // voxels along each edge
constexpr double kLast = kSize - 1, kWall = 5;  // voxels
constexpr Vec3 kWhite{19, 16, 36}, kBlue{40, 13, 36};
constexpr double kWhiteRadius = 11, kBlueRadius = 8;
constexpr Vec3 kLamp{kLast / 2, 110, kLast / 2};  // above the middle of the volume
enum Tag : std::uint8_t { kPlaster, kRedPaint, kBluePaint, kTags };

int main() {
  std::vector<float> values;  // 0.5 at surfaces, rising over four voxels inwards
  std::vector<std::uint8_t> tags;
  for (int z = 0; z < kSize; ++z) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const Vec3 place{double(x), double(y), double(z)};
        const double red = kWall - place.x, blue = kBlueRadius - length(place - kBlue);
        const double plaster =
            std::max({kWall - place.y, place.z - (kLast - kWall), kWhiteRadius - length(place - kWhite)});
        const double depth = std::max({red, blue, plaster});
        values.push_back(static_cast<float>(std::clamp(0.5 + depth / 4, 0.0, 1.0)));
        tags.push_back(depth == blue ? kBluePaint : depth == red ? kRedPaint : kPlaster);
      }
    }
  }
  auto board = gicube::Board::open("emu:?set=asic.datapath=wide&set=asic.irradiance_words=3");
  board.load_volume({.samples = std::as_bytes(std::span(values)),
                     .type = gicube::SampleType::kFloat32,
                     .dims = {kSize, kSize, kSize},
                     .range = gicube::ValueRange{0, 1},
                     .tags = tags});
  constexpr gicube::Colour kColours[kTags] = {{1, 1, 1}, {1, 0.25, 0.15}, {0.2, 0.4, 1}};
  for (int tag = 0; tag < kTags; ++tag) {
    board.set_transfer_function({.colours = {{0, kColours[tag]}}, .opacities = {{0.4, 0}, {0.8, 0.3}}}, tag);
    board.set_material({.scattering = 0.5, .bsdf = gicube::Bsdf::kDiffuse, .scattering_colour = kColours[tag]}, tag);
  }

  constexpr double kPower = 1000;
  const gicube::Light lamp = gicube::PointLight{kLamp, kPower};
  const gicube::LightingReport report = board.illuminate({&lamp, 1}, {.rays_per_face_voxel = 48});

  gicube::View view;
  view.eye = {120, 70, -100};
  view.look_at = {28, 18, 34};
  view.fov_degrees = 22;
  view.width = view.height = 320;
  view.irradiance = true;  // lit by the deposits of the lighting rays
  view.exposure = 110;     // of a unit of power on a unit of area
  write_image("global_illumination.ppm", board.render(view), 0.05);

  // The solid angle of a square from a place above its middle; the lamp's rays enter the volume only through its top.
  // Each of the three colours has the lamp's full power.
  const double half = kLast / 2, height = kLamp.y - kLast;
  const double solid_angle = 4 * std::asin(half * half / (half * half + height * height));
  const double expected = 3 * kPower * solid_angle / (4 * pi);
  const std::vector<float> irradiance = board.read_irradiance();
  const double read_back = std::accumulate(irradiance.begin(), irradiance.end(), 0.0);
  const double emitted_error = report.emitted / expected - 1, deposit_error = read_back / report.deposited - 1;
  std::printf(
      "of 3 x %.0f the volume meets %.3f (closed form %.3f, error %.4f%%): %.1f%% absorbed (read back: error %.4f%%), "
      "%.1f%% escaped\n",
      kPower, report.emitted, expected, 100 * emitted_error, 100 * report.deposited / report.emitted,
      100 * deposit_error, 100 * report.escaped / report.emitted);
  return std::abs(emitted_error) > 1e-3 || std::abs(deposit_error) > 1e-3;
}
