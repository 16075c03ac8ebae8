// A volumetric texture [P §5.6]: a small volume of woven threads covers a torus.
//
// The mesh's quads and their outer copies are the ends of hexahedra, each with one copy of the volume. A hexahedron is
// divided into six tetrahedra with affine texture coordinates (Porumbescu et al. 2005), so that a straight viewing ray
// is also straight in the volume. The board traces one segment per ray and tetrahedron, and the host composites.
//
//   c++ -std=c++20 -O2 volumetric_texture.cpp $(pkg-config --cflags --libs gicube) -o volumetric_texture
//   ./volumetric_texture
//
// Writes volumetric_texture.ppm. Prints the mean difference between the segments' opacities and integrals of the
// threads' formula, for one segment in 50. Returns 1 if it is above 0.02.
#include <gicube/board.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "picture.h"

using gicube::Vec3;
using std::numbers::pi;

constexpr gicube::Dims kTile{40, 40, 24};  // voxels along the texture's u, v and outwards
constexpr double kOpacity = 0.5;           // of one voxel length in the middle of a thread
constexpr int kAround = 30, kAcross = 12;  // quads of the torus
constexpr double kRing = 1, kTube = 0.36, kThickness = 0.13;

// Two threads run along u and two along v, over and under one another; all coordinates are 0..1. Returns the depth of a
// place in the threads of one direction: 1 in the middle of a thread, 0 outside.
double thread(double along, double across, double w, double sign) {
  double depth = 0;
  for (const double middle : {0.25, 0.75}) {
    const double height = 0.5 + (middle < 0.5 ? sign : -sign) * 0.2 * std::sin(2 * pi * along);
    depth = std::max(depth, 1 - std::hypot((across - middle) / 0.2, (w - height) / 0.26));
  }
  return depth;
}
double density(Vec3 p) {
  return std::clamp(4 * std::max(thread(p.x, p.y, p.z, 1), thread(p.y, p.x, p.z, -1)), 0.0, 1.0);
}

// A corner of the layer: i and j count quads, k is 0 on the mesh and 1 at its outer copy.
Vec3 corner(int i, int j, int k) {
  const double turn = 2 * pi * i / kAround, tilt = 2 * pi * j / kAcross, radius = kTube + k * kThickness;
  const double out = kRing + radius * std::cos(tilt);
  return {out * std::cos(turn), radius * std::sin(tilt), out * std::sin(turn)};
}

struct Segment {
  int pixel = 0;
  double distance = 0;  // from the eye
  Vec3 from, to;        // texture coordinates
};

int main() {
  std::vector<float> values;
  std::vector<std::uint8_t> tags;  // 0: along u, 1: along v
  for (int z = 0; z < kTile[2]; ++z) {
    for (int y = 0; y < kTile[1]; ++y) {
      for (int x = 0; x < kTile[0]; ++x) {
        const Vec3 p{x / (kTile[0] - 1.0), y / (kTile[1] - 1.0), z / (kTile[2] - 1.0)};
        values.push_back(static_cast<float>(density(p)));
        tags.push_back(thread(p.x, p.y, p.z, 1) >= thread(p.y, p.x, p.z, -1) ? 0 : 1);
      }
    }
  }
  auto board = gicube::Board::open("emu:");
  board.load_volume({.samples = std::as_bytes(std::span(values)),
                     .type = gicube::SampleType::kFloat32,
                     .dims = kTile,
                     .range = gicube::ValueRange{0, 1},
                     .tags = tags});
  board.set_transfer_function({.colours = {{0, {1.0, 0.62, 0.25}}}, .opacities = {{0, 0}, {1, kOpacity}}}, 0);
  board.set_transfer_function({.colours = {{0, {0.3, 0.6, 0.9}}}, .opacities = {{0, 0}, {1, kOpacity}}}, 1);
  board.set_shading(
      {.phong = {.ambient = 0.35, .diffuse = 0.8, .specular = 0.3}, .light = {0.3, 0.2, 1}});  // in the texture

  constexpr int kPixels = 240;
  constexpr double kWide = 0.9;  // width of the picture at unit distance from the eye
  const Vec3 eye{0, 2.3, -3.0}, forward = normalise(-1.0 * eye), right = normalise(cross(forward, {0, 1, 0}));
  const Vec3 up = cross(right, forward);
  const auto direction = [&](int x, int y) {
    return forward + kWide * (((x + 0.5) / kPixels - 0.5) * right + (0.5 - (y + 0.5) / kPixels) * up);
  };

  std::vector<Segment> segments;
  std::array<int, 3> axes{0, 1, 2};
  do {  // the six ways from a hexahedron's first corner to its last along its edges are six tetrahedra
    for (int cell = 0; cell < kAround * kAcross; ++cell) {
      std::array<Vec3, 4> at, texture;
      std::array<int, 3> steps{};
      std::array<int, 4> columns{}, rows{};  // of the corners in the picture
      for (std::size_t i = 0; i < 4; ++i) {
        if (i > 0) steps[static_cast<std::size_t>(axes[i - 1])] = 1;
        texture[i] = {double(steps[0]), double(steps[1]), double(steps[2])};
        at[i] = corner(cell % kAround + steps[0], cell / kAround + steps[1], steps[2]);
        const Vec3 seen = (1 / dot(at[i] - eye, forward)) * (at[i] - eye);
        columns[i] = int(kPixels * (0.5 + dot(seen, right) / kWide));
        rows[i] = int(kPixels * (0.5 - dot(seen, up) / kWide));
      }
      // Weights of the corners along a ray: eye part + distance * direction part.
      const Vec3 a = at[1] - at[0], b = at[2] - at[0], c = at[3] - at[0];
      const double volume = dot(a, cross(b, c));
      const auto weights = [&](Vec3 v) {
        const Vec3 part = (1 / volume) * Vec3{dot(v, cross(b, c)), dot(v, cross(c, a)), dot(v, cross(a, b))};
        return std::array{-part.x - part.y - part.z, part.x, part.y, part.z};
      };
      for (int y = std::max(0, std::ranges::min(rows)); y <= std::min(kPixels - 1, std::ranges::max(rows)); ++y) {
        for (int x = std::max(0, std::ranges::min(columns)); x <= std::min(kPixels - 1, std::ranges::max(columns));
             ++x) {
          auto begin = weights(eye - at[0]);
          const auto change = weights(direction(x, y));
          begin[0] += 1;
          double enter = 0, leave = std::numeric_limits<double>::infinity();
          for (std::size_t i = 0; i < 4; ++i) {  // inside all weights are above 0
            const double zero = -begin[i] / change[i];
            if (change[i] > 0) enter = std::max(enter, zero);
            if (change[i] < 0) leave = std::min(leave, zero);
          }
          if (enter >= leave) continue;
          Segment segment{y * kPixels + x, enter, {}, {}};
          for (std::size_t i = 0; i < 4; ++i) {
            segment.from = segment.from + (begin[i] + enter * change[i]) * texture[i];
            segment.to = segment.to + (begin[i] + leave * change[i]) * texture[i];
          }
          segments.push_back(segment);
        }
      }
    }
  } while (std::ranges::next_permutation(axes).found);
  std::ranges::sort(segments, {}, [](const Segment& segment) { return std::pair(segment.pixel, segment.distance); });

  std::vector<gicube::HostRay> rays;
  const auto voxel = [](double part, int size) { return std::clamp(part, 0.0, 1.0) * (size - 1); };
  const auto place = [&](Vec3 p) { return Vec3{voxel(p.x, kTile[0]), voxel(p.y, kTile[1]), voxel(p.z, kTile[2])}; };
  for (const Segment& s : segments) rays.push_back(gicube::ray_between(0, place(s.from), place(s.to)));
  const gicube::RayBatch traced = board.receive(board.submit(rays, {.type = gicube::RayType::kSegment}));

  std::vector<gicube::Colour> pixels(kPixels * kPixels);
  std::vector<double> clear(kPixels * kPixels, 1.0);
  double error = 0;
  int compared = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& s = segments[i];
    const auto pixel = static_cast<std::size_t>(s.pixel);
    for (std::size_t c = 0; c < 3; ++c) pixels[pixel][c] += clear[pixel] * traced.rays[i].colour[c];
    clear[pixel] *= 1 - traced.rays[i].opacity;
    if (s.to.z < 1e-6) clear[pixel] = 0;  // the mesh itself is black
    if (i % 50 != 0) continue;
    constexpr int kSteps = 200;
    double depth = 0;
    for (double at = 0.5 / kSteps; at < 1; at += 1.0 / kSteps)
      depth -= std::log(1 - kOpacity * density(s.from + at * (s.to - s.from))) * rays[i].length / kSteps;
    error += std::abs(traced.rays[i].opacity - (1 - std::exp(-depth)));
    ++compared;
  }
  for (std::size_t i = 0; i < pixels.size(); ++i)
    for (double& part : pixels[i]) part += 0.1 * clear[i];  // a grey background
  write_display_colours("volumetric_texture.ppm", kPixels, pixels);
  error /= compared;
  std::printf("%zu segments, mean error of an opacity %.4f\n", segments.size(), error);
  return error > 0.02;
}
