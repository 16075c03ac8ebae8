// Path tracing [P §2]: a cloud, lit by a lamp, with all orders of scattering.
//
// Paths begin at the eye. A first hit ends a segment where the ray's opacity reaches a number; with a random number,
// segments have the lengths of free paths in the medium. At each scattering, another ray of the board finds the share
// of the lamp's light that arrives there (kOpacity).
//
//   c++ -std=c++20 -O2 path_tracing.cpp $(pkg-config --cflags --libs gicube) -o path_tracing
//   ./path_tracing
//
// Writes path_tracing.ppm. Prints the power that a box in the cloud absorbs, by paths that begin there and by photons
// of the board (illuminate()), two methods that share only the volume. Returns 1 if they differ by more than 5%.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <random>

#include "picture.h"
#include "voxels.h"

using gicube::Vec3;
using std::numbers::pi;

constexpr int kSize = 48;  // voxels along each edge
constexpr gicube::Dims kDims{kSize, kSize, kSize};
constexpr double kExtinction = 0.5, kAlbedo = 0.9;  // of the densest part, per voxel; share of scattering
constexpr Vec3 kLamp{-20, 75, 0};
constexpr double kPower = 1e5;

// Extinction per voxel of soft balls, denser in their middles.
double extinction(Vec3 place) {
  double density = 0;
  for (const auto& [ball, radius] :
       {std::pair{Vec3{16, 17, 24}, 13.0}, {Vec3{31, 18, 22}, 14.0}, {Vec3{23, 29, 26}, 13.0}})
    density += std::clamp(1.5 - 1.5 * length(place - ball) / radius, 0.0, 1.0);
  return kExtinction * std::min(density, 1.0);
}

struct Path {
  std::size_t id;  // of its estimate
  Vec3 place, direction;
  double weight = 1;
};

Vec3 in_volume(Vec3 place) {
  const auto held = [](double part) { return std::clamp(part, 0.0, kSize - 1.0); };
  return {held(place.x), held(place.y), held(place.z)};
}

class Tracer {
 public:
  explicit Tracer(gicube::Board& board) : board_(board) {}

  double uniform() { return std::uniform_real_distribution<double>()(engine_); }
  Vec3 any_direction() {
    const double z = 2 * uniform() - 1, turn = 2 * pi * uniform(), level = std::sqrt(1 - z * z);
    return {level * std::cos(turn), level * std::sin(turn), z};
  }

  // The lamp's attenuated power per unit of area that faces it, at each place.
  std::vector<double> lamp_at(const std::vector<Path>& paths) {
    std::vector<gicube::HostRay> rays;
    for (const Path& path : paths) {
      const auto ray = gicube::clip_to_volume(gicube::ray_between(0, path.place, kLamp), kDims);
      rays.push_back(ray.value_or(gicube::HostRay{.position = path.place, .direction = kLamp}));  // of no length
    }
    std::vector<double> out;
    for (const gicube::TracedRay& ray : board_.receive(board_.submit(rays, {.type = gicube::RayType::kOpacity})).rays) {
      const Vec3 way = kLamp - paths[out.size()].place;
      out.push_back(kPower * (1 - ray.opacity) / (4 * pi * dot(way, way)));
    }
    return out;
  }

  // Sums by id of the radiances that arrive at the paths' places against their directions.
  std::vector<double> radiances(std::vector<Path> paths, std::size_t ids) {
    std::vector<double> sums(ids);
    while (!paths.empty()) {
      paths = flown(std::move(paths));
      const std::vector<double> lamp = lamp_at(paths);
      std::vector<Path> scattered;
      for (std::size_t i = 0; i < paths.size(); ++i) {
        sums[paths[i].id] += kAlbedo * paths[i].weight * lamp[i] / (4 * pi);  // scatters isotropically
        if (uniform() < kAlbedo) scattered.push_back({paths[i].id, paths[i].place, any_direction(), paths[i].weight});
      }
      paths = std::move(scattered);
    }
    return sums;
  }

 private:
  // Moves each path to its next scattering; paths that leave the volume end.
  std::vector<Path> flown(std::vector<Path> paths) {
    constexpr std::size_t kRequests = 64;  // one request has one opacity: paths are assigned at random
    constexpr double kStep = 0.5;          // voxels
    std::shuffle(paths.begin(), paths.end(), engine_);
    std::vector<Path> out;
    for (std::size_t request = 0; request < std::min(kRequests, paths.size()); ++request) {
      std::vector<gicube::HostRay> rays;
      for (std::size_t i = request; i < paths.size(); i += kRequests) {  // samples are in the middles of steps
        rays.push_back(
            {std::uint32_t(i), in_volume(paths[i].place + kStep / 2 * paths[i].direction), paths[i].direction});
      }
      const double opacity = (double(request) + uniform()) / kRequests;
      const gicube::RayRequest first_hit{.type = gicube::RayType::kFirstHit, .opacity = opacity, .step = kStep};
      for (const gicube::TracedRay& hit : board_.receive(board_.submit(rays, first_hit)).rays) {
        if (hit.opacity < opacity) continue;
        Path path = paths[hit.id];  // ends somewhere in the sample's step
        const double beyond = std::log((1 - opacity) / (1 - hit.opacity)) / std::max(extinction(hit.position), 1e-3);
        path.place = in_volume(hit.position + std::max(-kStep / 2, kStep / 2 - beyond) * path.direction);
        out.push_back(path);
      }
    }
    return out;
  }

  gicube::Board& board_;
  std::mt19937 engine_{1};
};

int main() {
  const auto values = make_voxels(kDims, extinction);
  auto board = gicube::Board::open("emu:?set=asic.datapath=wide");
  board.load_volume({.samples = std::as_bytes(std::span(values)),
                     .type = gicube::SampleType::kFloat32,
                     .dims = kDims,
                     .range = gicube::ValueRange{0, kExtinction},
                     .find_gradients = false});
  gicube::TransferFunction function{.colours = {{0, {1, 1, 1}}}};
  for (double e = 0; e <= kExtinction; e += kExtinction / 32) function.opacities.push_back({e, 1 - std::exp(-e)});
  board.set_transfer_function(function);
  Tracer tracer(board);

  constexpr std::size_t kPixels = 96, kPaths = 16;  // of the picture's edge, and per pixel
  const Vec3 eye{23.5, 15, -110}, forward = normalise(Vec3{23.5, 22, 23.5} - eye);
  const Vec3 right = normalise(cross(forward, {0, 1, 0})), up = cross(right, forward);
  std::vector<Path> paths;
  for (std::size_t i = 0; i < kPixels * kPixels * kPaths; ++i) {
    const std::size_t pixel = i / kPaths;
    const double u = (double(pixel % kPixels) + tracer.uniform()) / kPixels - 0.5;
    const double v = 0.5 - (double(pixel / kPixels) + tracer.uniform()) / kPixels;
    const auto ray = gicube::clip_to_volume({0, eye, forward + 0.36 * (u * right + v * up), 400}, kDims);
    if (ray) paths.push_back({pixel, ray->position, normalise(ray->direction)});
  }
  std::vector<gicube::Colour> pixels;
  constexpr double kExposure = 6;
  for (const double sum : tracer.radiances(paths, kPixels * kPixels)) {
    const double light = kExposure * sum / kPaths;
    pixels.push_back({light, 0.95 * light + 0.01, 0.9 * light + 0.04});
  }
  write_light("path_tracing.ppm", kPixels, pixels);

  // The power that a box absorbs: its volume times the mean of extinction (1 - albedo) fluence, from paths that begin
  // in it.
  const gicube::VoxelBox box{{14, 16, 14}, {16, 12, 16}};
  const double volume = box.size[0] * box.size[1] * box.size[2];
  constexpr std::size_t kBegins = 30'000;
  std::vector<Path> begins;
  for (std::size_t i = 0; i < kBegins; ++i) {
    const auto place = [&](std::size_t axis) { return box.low[axis] - 0.5 + box.size[axis] * tracer.uniform(); };
    const Vec3 from{place(0), place(1), place(2)};
    begins.push_back({0, from, tracer.any_direction(), (1 - kAlbedo) * extinction(from) * volume / kBegins});
  }
  double by_paths = 0;
  const std::vector<double> lamp_light = tracer.lamp_at(begins);
  for (std::size_t i = 0; i < kBegins; ++i) by_paths += begins[i].weight * lamp_light[i];
  by_paths += 4 * pi * tracer.radiances(begins, 1)[0];

  board.set_material({.scattering = kAlbedo, .bsdf = gicube::Bsdf::kIsotropic});
  const gicube::Light lamp = gicube::PointLight{kLamp, kPower};
  board.illuminate({&lamp, 1}, {.albedo = gicube::Albedo::kHigh, .rays_per_face_voxel = 64, .lifetime = 1000});
  const std::vector<float> absorbed = board.read_irradiance(box);
  const double by_photons = std::accumulate(absorbed.begin(), absorbed.end(), 0.0);
  const double difference = by_paths / by_photons - 1;
  std::printf("a box in the cloud absorbs %.1f by paths, %.1f by photons of the board, difference %.2f%%\n", by_paths,
              by_photons, 100 * difference);
  return std::abs(difference) > 0.05;
}
