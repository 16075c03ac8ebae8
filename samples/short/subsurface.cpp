// Light beneath a surface [P §5.6]: the distance over which a material diffuses light on one point of it.
//
// Photons enter a thick slab of a medium, scatter, and leave its top at another place. A first hit ends a segment where
// the ray's opacity reaches a number; with a random number, segments have the lengths of free paths in the medium. The
// pattern of light is then convolved with the mean profile R(r), the light that leaves a unit of area at distance r.
//
//   c++ -std=c++20 -O2 subsurface.cpp $(pkg-config --cflags --libs gicube) -o subsurface
//   ./subsurface
//
// Writes subsurface.ppm: the pattern, and its image on the material. Prints the reflected share of red, green and blue
// light, and their closed form, 1 - sqrt(1 - albedo) H(1) by Chandrasekhar. Returns 1 if one error is above 0.01.
#include <gicube/board.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "picture.h"

using gicube::Colour;
using gicube::Vec3;
using std::numbers::pi;

constexpr int kSize = 64;  // voxels along each edge; the slab fills the volume
constexpr double kTop = kSize - 1, kMiddle = kTop / 2;
constexpr double kExtinction = 0.5;        // per voxel: the slab is 32 mean free paths thick
constexpr Colour kAlbedo{0.95, 0.8, 0.4};  // shares of scattering: red travels farthest
constexpr int kPhotons = 40'000, kRings = 64;
constexpr double kRingWidth = 0.25;  // voxels

struct Photon {
  Vec3 place, direction;
  Colour weight{1, 1, 1};
};

// Chandrasekhar's H function for isotropic scattering, at 1.
double h_at_one(double albedo) {
  constexpr int kSteps = 200;
  std::vector<double> h(kSteps, 1.0);
  const auto cosine = [](int i) { return (i + 0.5) / kSteps; };
  const auto next = [&](double mu) {
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += cosine(i) * h[static_cast<std::size_t>(i)] / (mu + cosine(i)) / kSteps;
    return 1 / (std::sqrt(1 - albedo) + albedo / 2 * sum);
  };
  for (int round = 0; round < 100; ++round) {
    std::vector<double> better;
    for (int i = 0; i < kSteps; ++i) better.push_back(next(cosine(i)));
    h = better;
  }
  return next(1);
}

int main() {
  const std::vector<std::byte> values(kSize * kSize * kSize, std::byte{1});
  auto board = gicube::Board::open("emu:");
  board.load_volume({.samples = values, .dims = {kSize, kSize, kSize}, .find_gradients = false});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 1 - std::exp(-kExtinction)}}});

  std::mt19937 engine(1);
  std::uniform_real_distribution<double> uniform;
  std::vector<Photon> photons(kPhotons, {{kMiddle, kMiddle, kTop}, {0, 0, -1}});
  std::vector<Colour> rings(kRings);
  Colour reflected{};
  while (!photons.empty()) {
    // One request has one opacity for all its rays, so photons are assigned to requests at random.
    constexpr std::size_t kRequests = 64;
    constexpr double kStep = 0.5;  // voxels
    std::shuffle(photons.begin(), photons.end(), engine);
    std::vector<Photon> scattered;
    for (std::size_t request = 0; request < kRequests; ++request) {
      std::vector<gicube::HostRay> rays;
      for (std::size_t i = request; i < photons.size(); i += kRequests) {
        rays.push_back({static_cast<std::uint32_t>(i), photons[i].place, photons[i].direction});
      }
      if (rays.empty()) break;
      const double opacity = (static_cast<double>(request) + uniform(engine)) / kRequests;
      const auto hits =
          board.receive(board.submit(rays, {.type = gicube::RayType::kFirstHit, .opacity = opacity, .step = kStep}));
      for (const gicube::TracedRay& hit : hits.rays) {
        Photon photon = photons[hit.id];
        // The hit is the sample at the beginning of the step in which the opacity is reached.
        const double beyond = std::log((1 - opacity) / (1 - hit.opacity)) / kExtinction;
        const double flight = length(hit.position - photon.place) + kStep - beyond;
        const Vec3 end = photon.place + flight * photon.direction;
        const double to_top = photon.direction.z > 0 ? (kTop - photon.place.z) / photon.direction.z : INFINITY;
        const bool inside = std::min({end.x, end.y, end.z}) >= 0 && std::max({end.x, end.y, end.z}) <= kTop;
        if (hit.opacity < opacity || !inside) {  // it has left the slab, hardly ever by the sides or below
          const Vec3 exit = photon.place + to_top * photon.direction;
          const double radius = std::hypot(exit.x - kMiddle, exit.y - kMiddle);
          for (std::size_t c = 0; c < 3 && std::isfinite(to_top); ++c) {
            reflected[c] += photon.weight[c] / kPhotons;
            if (radius < kRings * kRingWidth)
              rings[static_cast<std::size_t>(radius / kRingWidth)][c] += photon.weight[c] / kPhotons;
          }
          continue;
        }
        for (std::size_t c = 0; c < 3; ++c) photon.weight[c] *= kAlbedo[c];
        const double survival = std::min(1.0, 10 * photon.weight[0]);  // Russian roulette below a tenth
        if (uniform(engine) >= survival) continue;
        for (double& part : photon.weight) part /= survival;
        const double z = 2 * uniform(engine) - 1, turn = 2 * pi * uniform(engine), level = std::sqrt(1 - z * z);
        scattered.push_back({end, {level * std::cos(turn), level * std::sin(turn), z}, photon.weight});
      }
    }
    photons = std::move(scattered);
  }

  // Left: a star of light. Right: the same star convolved with the profile.
  constexpr int kPixels = 160, kReach = 64;                // of the pictures' edges; radius of the profile in pixels
  constexpr double kPixel = kRings * kRingWidth / kReach;  // voxels
  const auto star = [](int x, int y) {
    const double u = x - kPixels / 2.0, v = y - kPixels / 2.0;
    return std::hypot(u, v) < 32 * (1 + 0.45 * std::sin(5 * std::atan2(v, u)));
  };
  std::vector<Colour> pixels(2 * kPixels * kPixels);
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) {
      if (!star(x, y)) continue;
      pixels[static_cast<std::size_t>(y * 2 * kPixels + x)] = {1, 1, 1};
      for (int v = std::max(0, y - kReach); v < std::min(kPixels, y + kReach); ++v) {
        for (int u = std::max(0, x - kReach); u < std::min(kPixels, x + kReach); ++u) {
          const auto ring = static_cast<std::size_t>(std::hypot(u - x, v - y) * kPixel / kRingWidth);
          if (ring >= kRings) continue;
          const double area = pi * (2.0 * static_cast<double>(ring) + 1) * kRingWidth * kRingWidth / (kPixel * kPixel);
          for (std::size_t c = 0; c < 3; ++c)
            pixels[static_cast<std::size_t>(v * 2 * kPixels + kPixels + u)][c] += rings[ring][c] / area;
        }
      }
    }
  }
  write_light("subsurface.ppm", 2 * kPixels, pixels);

  double worst = 0;
  Colour exact;
  for (std::size_t c = 0; c < 3; ++c) {
    exact[c] = 1 - std::sqrt(1 - kAlbedo[c]) * h_at_one(kAlbedo[c]);
    worst = std::max(worst, std::abs(reflected[c] - exact[c]));
  }
  std::printf("reflected red %.4f, green %.4f, blue %.4f; closed form %.4f, %.4f, %.4f; largest error %.4f\n",
              reflected[0], reflected[1], reflected[2], exact[0], exact[1], exact[2], worst);
  return worst > 0.01;
}
