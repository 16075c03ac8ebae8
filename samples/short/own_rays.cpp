// Rays of the application, and visibility between points [P §3.5, §5.6]: a panorama, which is not a camera of the
// board.
//
// Rays in all directions from the middle of a round room end at the first opaque sample (kFirstHit). From each hit,
// another ray tests the visibility of a lamp (kOpacity).
//
//   c++ -std=c++20 -O2 own_rays.cpp $(pkg-config --cflags --libs gicube) -o own_rays
//   ./own_rays
//
// Writes own_rays.ppm. Prints the mean error of the distances against exact intersections with spheres, and the share
// of rays with a visibility other than the exact one. Returns 1 if they are above 0.2 voxels or 1%.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "picture.h"
#include "voxels.h"

using gicube::Vec3;
using std::numbers::pi;

constexpr int kSize = 96;  // voxels along each edge
constexpr Vec3 kMiddle{47.5, 47.5, 47.5};
constexpr Vec3 kLamp{47.5, 74, 40};
constexpr double kRoom = 45;                // the room's radius, voxels
constexpr int kWidth = 384, kHeight = 192;  // pixels: 360 by 180 degrees

struct Ball {
  Vec3 centre;
  double radius;
};

// A ring of balls at different heights around the middle.
std::vector<Ball> balls() {
  std::vector<Ball> out;
  for (int i = 0; i < 11; ++i) {
    const double turn = 2 * pi * i / 11, height = 14 * std::sin(2.5 * i) - 6;
    out.push_back({kMiddle + Vec3{26 * std::cos(turn), height, 26 * std::sin(turn)}, 5.0 + i % 3});
  }
  return out;
}

// Distance at which a ray enters a ball, or infinity. `direction` has unit length.
double distance_to(const Ball& ball, Vec3 place, Vec3 direction) {
  const Vec3 to = ball.centre - place;
  const double along = dot(to, direction), inside = ball.radius * ball.radius - dot(to, to) + along * along;
  return inside >= 0 && along > 0 ? along - std::sqrt(inside) : INFINITY;
}

int main() {
  const std::vector<Ball> scene = balls();
  // 0.5 at the surfaces, more inside the balls and outside the room.
  const auto values = make_voxels({kSize, kSize, kSize}, [&](Vec3 place) {
    double depth = length(place - kMiddle) - kRoom;
    for (const Ball& ball : scene) depth = std::max(depth, ball.radius - length(place - ball.centre));
    return std::clamp(0.5 + depth / 4, 0.0, 1.0);
  });
  auto board = gicube::Board::open("emu:");
  board.load_volume({.samples = std::as_bytes(std::span(values)),
                     .type = gicube::SampleType::kFloat32,
                     .dims = {kSize, kSize, kSize},
                     .range = gicube::ValueRange{0, 1}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0.5, 0}, {0.5, 1}}});  // a step

  std::vector<gicube::HostRay> rays;
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
    const double longitude = 2 * pi * (i % kWidth + 0.5) / kWidth, latitude = pi * (0.5 - (i / kWidth + 0.5) / kHeight);
    const double level = std::cos(latitude);
    rays.push_back({i, kMiddle, {level * std::sin(longitude), std::sin(latitude), level * std::cos(longitude)}});
  }
  const gicube::RayBatch hits =
      board.receive(board.submit(rays, {.type = gicube::RayType::kFirstHit, .opacity = 0.5, .step = 0.25}));

  // Exact distances and normals; rays to the lamp start slightly off the surface.
  std::vector<gicube::HostRay> to_lamp;
  std::vector<gicube::Colour> pixels;
  double distance_error = 0;
  for (const gicube::TracedRay& hit : hits.rays) {
    const Vec3 direction = rays[hit.id].direction;
    double exact = kRoom;
    std::size_t nearest = scene.size();  // the room
    for (std::size_t i = 0; i < scene.size(); ++i) {
      if (const double distance = distance_to(scene[i], kMiddle, direction); distance < exact) {
        exact = distance;
        nearest = i;
      }
    }
    distance_error += std::abs(length(hit.position - kMiddle) - exact) / static_cast<double>(rays.size());
    const bool is_room = nearest == scene.size();
    const Vec3 normal = is_room ? -1.0 * direction : normalise(hit.position - scene[nearest].centre);
    to_lamp.push_back(gicube::ray_between(hit.id, hit.position + 2.0 * normal, kLamp));
    const Vec3 way = kLamp - hit.position;
    constexpr double kExposure = 1300;
    const double light = 1 - std::exp(-kExposure * std::max(0.0, dot(normal, normalise(way))) / dot(way, way));
    const bool dark_tile = (hit.id % kWidth / 16 + hit.id / kWidth / 16) % 2 != 0;  // of 16 by 16 pixels
    const double white = is_room ? (dark_tile ? 0.35 : 0.6) : 0.9;
    const double hue = 2 * pi * static_cast<double>(nearest) / static_cast<double>(scene.size());
    const double colourful = is_room ? 0 : 0.45;
    pixels.push_back({light * white * (1 - colourful + colourful * std::cos(hue)),
                      light * white * (1 - colourful + colourful * std::cos(hue - 2)),
                      light * white * (1 - colourful + colourful * std::cos(hue + 2))});
  }
  const gicube::RayBatch seen = board.receive(board.submit(to_lamp, {.type = gicube::RayType::kOpacity, .step = 0.25}));

  int different = 0;
  for (const gicube::TracedRay& ray : seen.rays) {
    const gicube::HostRay& sent = to_lamp[ray.id];
    const auto blocks = [&](const Ball& ball) {
      return distance_to(ball, sent.position, normalise(sent.direction)) < sent.length;
    };
    if ((ray.opacity > 0.5) != std::ranges::any_of(scene, blocks)) ++different;
    for (double& part : pixels[ray.id]) part *= 0.08 + 0.92 * (1 - ray.opacity);  // some light reaches the shadows
  }
  write_light("own_rays.ppm", kWidth, pixels);
  const double disagreement = different / static_cast<double>(rays.size());
  std::printf("mean error of a distance %.3f voxels; visibility differs for %.2f%% of %zu rays\n", distance_error,
              100 * disagreement, rays.size());
  return distance_error > 0.2 || disagreement > 0.01;
}
