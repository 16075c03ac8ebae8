// A photon map [P §2; Jensen 1996]: the caustic of a polished ring on the floor inside it.
//
// The host sends photons from a lamp and keeps those that arrive on the floor; the board finds their hits (kFirstHit).
// The light on a place is the power of the photons near it. The picture's rays are traced in the same way.
//
//   c++ -std=c++20 -O2 photon_map.cpp $(pkg-config --cflags --libs gicube) -o photon_map
//   ./photon_map
//
// Writes photon_map.ppm. Prints the RMS error of the light on the floor beside the ring, where it comes only from the
// lamp, power cos / (4 pi r^2), and the error of the power inside the ring, which must equal the power through its
// opening. Returns 1 if one is above 3%.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <random>

#include "picture.h"
#include "voxels.h"

using gicube::Vec3;
using std::numbers::pi;

constexpr int kSize = 64;                   // voxels along each edge; lengths below are in voxels
constexpr double kFloor = 4, kTop = 17;     // heights of the floor and of the ring's upper rim
constexpr Vec3 kAxis{37, 0, 31.5};          // of the ring
constexpr double kInner = 16, kOuter = 19;  // its radii
constexpr Vec3 kLamp{-40, 70, 31.5};
constexpr double kPower = 4 * pi * 10000;  // so that the light is about 1
constexpr double kGather = 1.0;            // radius of the disc in which photons are counted

double from_axis(Vec3 place) { return std::hypot(place.x - kAxis.x, place.z - kAxis.z); }

// Power per unit of horizontal area.
double direct_light(Vec3 place) {
  const Vec3 way = kLamp - place;
  return kPower * way.y / (4 * pi * std::pow(length(way), 3));
}

// Ends of rays, by ids, on the floor or the ring's outside, after any number of reflections inside the ring.
std::vector<std::optional<Vec3>> ends_of(gicube::Board& board, std::vector<gicube::HostRay> rays, std::size_t ids) {
  std::vector<std::optional<Vec3>> ends(ids);
  while (!rays.empty()) {
    const gicube::RayBatch hits =
        board.receive(board.submit(rays, {.type = gicube::RayType::kFirstHit, .opacity = 0.5, .step = 0.25}));
    std::vector<gicube::HostRay> reflected;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Vec3 from = rays[i].position, way = normalise(rays[i].direction), hit = hits.rays[i].position;
      const Vec3 outwards = (1 / from_axis(hit)) * Vec3{hit.x - kAxis.x, 0, hit.z - kAxis.z};
      if (hits.rays[i].opacity < 0.5) continue;
      if (hit.y < kFloor + 0.3) {
        ends[rays[i].id] = from + (kFloor - from.y) / way.y * way;
      } else if (from_axis(hit) > (kInner + kOuter) / 2 || dot(outwards, way) < 0 || hit.y > kTop - 0.3) {
        ends[rays[i].id] = hit;
      } else {  // the mirror: hits lie up to a step behind it, so the ray is continued where it crosses the cylinder
        const Vec3 level{way.x, 0, way.z}, offset{from.x - kAxis.x, 0, from.z - kAxis.z};
        const double a = dot(level, level), b = dot(level, offset), c = dot(offset, offset) - kInner * kInner;
        const Vec3 place = from + (-b + std::sqrt(std::max(0.0, b * b - a * c))) / a * way;
        reflected.push_back({rays[i].id, place - 0.3 * outwards, way - 2 * dot(way, outwards) * outwards});
      }
    }
    rays = std::move(reflected);
  }
  return ends;
}

int main() {
  const auto values = make_voxels({kSize, kSize, kSize}, [](Vec3 place) {  // 0.5 at the surfaces
    const double radius = from_axis(place);
    const double ring = std::min({radius - kInner, kOuter - radius, kTop - place.y});
    return std::clamp(0.5 + std::max(kFloor - place.y, ring) / 4, 0.0, 1.0);
  });
  auto board = gicube::Board::open("emu:");
  board.load_volume({.samples = std::as_bytes(std::span(values)),
                     .type = gicube::SampleType::kFloat32,
                     .dims = {kSize, kSize, kSize},
                     .range = gicube::ValueRange{0, 1}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0.5, 0}, {0.5, 1}}});

  // One photon to a random place in each cell of a grid on the floor, which is slightly wider than the volume.
  constexpr int kCells = 500;
  constexpr double kLow = -8, kEdge = 88;
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> uniform;
  std::vector<gicube::HostRay> photons;
  for (int i = 0; i < kCells * kCells; ++i) {
    const double x = (i % kCells + uniform(engine)) / kCells, z = (i / kCells + uniform(engine)) / kCells;
    const Vec3 target{kLow + kEdge * x, kFloor, kLow + kEdge * z};
    gicube::HostRay whole = gicube::ray_between(0, kLamp, target);
    whole.length = 2 * length(target - kLamp);
    whole.energy = direct_light(target) * std::pow(kEdge / kCells, 2);  // the photon's power
    whole.id = static_cast<std::uint32_t>(photons.size());
    if (const auto ray = gicube::clip_to_volume(whole, {kSize, kSize, kSize})) photons.push_back(*ray);
  }
  std::vector<std::vector<std::pair<Vec3, double>>> map(kSize * kSize);  // places and powers, by voxels of the floor
  double inside = 0;
  const auto arrivals = ends_of(board, photons, photons.size());
  for (std::size_t i = 0; i < photons.size(); ++i) {
    if (!arrivals[i] || arrivals[i]->y > kFloor + 0.1) continue;
    const Vec3 place = *arrivals[i];
    if (std::min(place.x, place.z) < 0 || std::max(place.x, place.z) > kSize - 1) continue;
    map[static_cast<std::size_t>(std::lround(place.z) * kSize + std::lround(place.x))].push_back(
        {place, photons[i].energy});
    if (from_axis(place) < kInner) inside += photons[i].energy;
  }
  const auto light_on = [&map](Vec3 place) {
    double sum = 0;
    for (long z = std::max(0L, std::lround(place.z) - 1); z <= std::min(kSize - 1L, std::lround(place.z) + 1); ++z) {
      for (long x = std::max(0L, std::lround(place.x) - 1); x <= std::min(kSize - 1L, std::lround(place.x) + 1); ++x) {
        for (const auto& [photon, power] : map[static_cast<std::size_t>(z * kSize + x)])
          if (length(photon - place) < kGather) sum += power;
      }
    }
    return sum / (pi * kGather * kGather);
  };

  constexpr int kPixels = 240;
  const Vec3 eye{28, 110, -75}, forward = normalise(Vec3{33, 4, 29} - eye),
                                right = normalise(cross(forward, {0, 1, 0}));
  const Vec3 up = cross(right, forward);
  std::vector<gicube::HostRay> views;
  for (std::uint32_t i = 0; i < kPixels * kPixels; ++i) {
    const double u = (i % kPixels + 0.5) / kPixels - 0.5, v = 0.5 - (i / kPixels + 0.5) / kPixels;
    const gicube::HostRay ray{i, eye, forward + 0.48 * (u * right + v * up), 400};
    if (const auto part = gicube::clip_to_volume(ray, {kSize, kSize, kSize})) views.push_back(*part);
  }
  std::vector<gicube::Colour> pixels(kPixels * kPixels, {0.01, 0.01, 0.012});
  const auto seen = ends_of(board, views, pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!seen[i]) continue;
    const bool floor = seen[i]->y < kFloor + 0.1;
    const double light = floor ? 0.45 * light_on(*seen[i]) : seen[i]->y > kTop - 0.3 ? 0.5 : 0.04;
    pixels[i] = {light, (floor ? 0.85 : 0.7) * light, (floor ? 0.65 : 0.3) * light};
  }
  write_light("photon_map.ppm", kPixels, pixels);

  double squares = 0, opening = 0;
  int places = 0;
  for (double x = 3; x < kAxis.x - kOuter - 3; x += 0.5) {
    for (double z = 10; z < 54; z += 0.5, ++places) {
      const Vec3 place{x, kFloor, z};
      squares += std::pow(light_on(place) / direct_light(place) - 1, 2);
    }
  }
  constexpr double kFine = 0.1;  // of a sum over the opening
  for (double x = -kInner; x < kInner; x += kFine) {
    for (double z = -kInner; z < kInner; z += kFine)
      if (std::hypot(x, z) < kInner) opening += direct_light(kAxis + Vec3{x, kTop, z}) * kFine * kFine;
  }
  const double error = std::sqrt(squares / places), power_error = inside / opening - 1;
  std::printf("light beside the ring: RMS error %.2f%%; power inside it %.1f, through its opening %.1f, error %.2f%%\n",
              100 * error, inside, opening, 100 * power_error);
  return error > 0.03 || std::abs(power_error) > 0.03;
}
