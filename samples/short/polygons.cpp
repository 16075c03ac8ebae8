// Polygons in a participating medium [P §2]: a room with a lamp, coloured walls and a cube, full of settled fog.
//
// The zonal method (Hottel and Sarofim 1967, Rushmeier and Torrance 1987) divides the polygons into patches and the fog
// into zones; each exchanges light with all others. The board has the fog and the cube, and finds the shares of light
// between elements. The picture's rays are divided into segments, which give the transmittance of the fog.
//
//   c++ -std=c++20 -O2 polygons.cpp $(pkg-config --cflags --libs gicube) -o polygons
//   ./polygons
//
// Writes polygons.ppm. Prints the RMS error of the sums of the patches' form factors. They are 1 in a closed room,
// because all light reaches a polygon or the fog. Returns 1 if it is above 3%.
#include <gicube/board.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

#include "picture.h"

using gicube::Colour;
using gicube::Vec3;

constexpr int kSize = 48;                                         // voxels along each edge
constexpr double kLast = kSize - 1, kMost = 0.02;                 // of the fog's extinction, per voxel
constexpr std::array<double, 5> kZones{0, 11.5, 23.5, 35.5, 47};  // borders along each axis: between voxels
constexpr Vec3 kCube{23.5, 11.5, 23.5};                           // its low corner; it fills a zone
constexpr double kEdge = 12;

double extinction(double y) { return kMost * (1 - y / kLast); }
bool in_cube(double x, double y, double z) {
  const auto within = [](double place, double low) { return place > low && place < low + kEdge; };
  return within(x, kCube.x) && within(y, kCube.y) && within(z, kCube.z);
}

struct Face {  // its front is to the side of u x v; patches are counted along u, then along v
  Vec3 origin, u, v;
  Colour albedo;
  int parts;          // along each edge
  std::size_t first;  // the element of the first patch
};

// Faces of a cube, low and high along x, y, z, for views from inside or outside.
void add_faces(std::vector<Face>& out, Vec3 low, double edge, int parts, bool inside,
               const std::array<Colour, 6>& albedos) {
  const Vec3 axes[] = {{edge, 0, 0}, {0, edge, 0}, {0, 0, edge}};
  for (std::size_t i = 0; i < 6; ++i) {
    Face face{low + double(i % 2) * axes[i / 2], axes[(i / 2 + 1) % 3], axes[(i / 2 + 2) % 3], albedos[i], parts, 0};
    if ((i % 2 == 1) == inside) std::swap(face.u, face.v);
    out.push_back(face);
  }
}

// The lower or upper one of the two cells in a row of `count` with middles next to `at`, 0..1, and its weight.
std::pair<std::size_t, double> next_to(double at, int count, int upper) {
  const double place = std::clamp(at * count - 0.5, 0.0, count - 1.0), lower = std::min(std::floor(place), count - 2.0);
  return {std::size_t(lower) + std::size_t(upper), upper == 0 ? 1 - (place - lower) : place - lower};
}

void add(Colour& sum, double weight, const Colour& more) {
  for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * more[c];
}

int main() {
  std::vector<float> values;  // the fog's extinction
  std::vector<std::uint8_t> tags;
  for (int z = 0; z < kSize; ++z) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        values.push_back(static_cast<float>(extinction(y)));
        tags.push_back(in_cube(x, y, z) ? 1 : 0);
      }
    }
  }
  auto board = gicube::Board::open("emu:");
  board.load_volume({.samples = std::as_bytes(std::span(values)),
                     .type = gicube::SampleType::kFloat32,
                     .dims = {kSize, kSize, kSize},
                     .range = gicube::ValueRange{0, kMost},
                     .tags = tags,
                     .find_gradients = false});
  board.set_transfer_function({.colours = {{0, {}}}, .opacities = {{0, 0}, {kMost, 1 - std::exp(-kMost)}}}, 0);
  board.set_transfer_function({.colours = {{0, {}}}, .opacities = {{0, 1}}}, 1);

  const Colour white{0.6, 0.6, 0.6}, blue{0.15, 0.3, 0.7}, red{0.75, 0.12, 0.08}, green{0.15, 0.6, 0.12};
  std::vector<Face> faces;
  add_faces(faces, {0, 0, 0}, kLast, 6, true, {red, green, white, white, white, white});
  add_faces(faces, kCube, kEdge, 2, false, {blue, blue, blue, blue, blue, blue});

  std::vector<gicube::Element> elements;
  std::vector<double> sizes;  // a patch's area, a zone's extinction times its volume
  std::vector<Colour> albedo;
  for (Face& face : faces) {
    face.first = elements.size();
    const Vec3 u = (1.0 / face.parts) * face.u, v = (1.0 / face.parts) * face.v;
    for (int i = 0; i < face.parts * face.parts; ++i) {
      elements.push_back(
          {.origin = face.origin + double(i % face.parts) * u + double(i / face.parts) * v, .u = u, .v = v});
      sizes.push_back(length(cross(u, v)));
      albedo.push_back(face.albedo);
    }
  }
  const std::size_t patches = elements.size();
  std::array<std::size_t, 64> zone_at{};  // the element of each box of the grid, 0 in the cube
  for (std::size_t i = 0; i < zone_at.size(); ++i) {
    const std::size_t x = i % 4, y = i / 4 % 4, z = i / 16;
    const Vec3 low{kZones[x], kZones[y], kZones[z]}, size = Vec3{kZones[x + 1], kZones[y + 1], kZones[z + 1]} - low;
    if (in_cube(low.x + 1, low.y + 1, low.z + 1)) continue;
    zone_at[i] = elements.size();
    elements.push_back({gicube::ElementKind::kBox, low, {size.x, 0, 0}, {0, size.y, 0}, {0, 0, size.z}});
    sizes.push_back(extinction(low.y + size.y / 2) * size.x * size.y * size.z);
    albedo.push_back({0.9, 0.9, 0.9});
  }

  // Form factors, a row per element: shares of its light that arrive at the others. A zone also lights itself.
  const std::size_t n = elements.size();
  std::vector<gicube::ElementPair> pairs;
  for (std::uint32_t a = 0; a < n; ++a) {
    for (std::uint32_t b = a < patches ? a + 1 : a; b < n; ++b) pairs.push_back({a, b, std::uint32_t(pairs.size())});
  }
  const auto found = board.pair_factors(elements, pairs, {.rays = 16});
  std::vector<double> factors(n * n);
  for (const auto& [a, b, id] : pairs) {
    factors[a * n + b] = found[id].transported * sizes[b] / (a < patches ? 1 : 4);
    factors[b * n + a] = found[id].transported * sizes[a] / (b < patches ? 1 : 4);
  }
  double squares = 0;
  for (std::size_t a = 0; a < n; ++a) {
    const std::span<double> row(&factors[a * n], n);
    const double sum = std::accumulate(row.begin(), row.end(), 0.0);
    if (a < patches) squares += std::pow(sum - 1, 2) / static_cast<double>(patches);
    for (double& factor : row) factor /= sum;  // conserves the light
  }

  // The light that leaves each element, pi times its radiance, by iteration. The lamp is the middle of the ceiling.
  std::vector<Colour> emitted(n), light(n);
  for (const std::size_t i : {14, 15, 20, 21}) emitted[faces[3].first + i] = {14, 12.5, 10};
  for (int round = 0; round < 30; ++round) {
    const std::vector<Colour> before = std::exchange(light, emitted);
    for (std::size_t i = 0; i < n * n; ++i) {
      for (std::size_t c = 0; c < 3; ++c) light[i / n][c] += albedo[i / n][c] * factors[i] * before[i % n][c];
    }
  }
  const auto fog_light = [&](Vec3 place) {  // interpolated between the middles of zones
    Colour out{};
    for (int corner = 0; corner < 8; ++corner) {
      const auto [i, a] = next_to(place.x / kLast, 4, corner % 2);
      const auto [j, b] = next_to(place.y / kLast, 4, corner / 2 % 2);
      const auto [k, c] = next_to(place.z / kLast, 4, corner / 4);
      add(out, a * b * c, light[zone_at[i + 4 * j + 16 * k]]);
    }
    return out;
  };

  constexpr int kPixels = 200;
  constexpr std::size_t kLegs = 8;
  const Vec3 eye{6, 38, -50};
  std::vector<Colour> pixels(kPixels * kPixels), ends(pixels.size());  // the light at each line's end
  std::vector<std::array<Vec3, kLegs + 1>> points(pixels.size());
  std::vector<gicube::HostRay> sent;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    // Through the wall z = 0, which shows its back and is not drawn.
    const Vec3 begin{kLast * (double(i % kPixels) + 0.5) / kPixels, kLast * (1 - (double(i / kPixels) + 0.5) / kPixels),
                     0};
    const Vec3 way = begin - eye;
    double nearest = 1e9;
    for (const Face& face : faces) {
      const Vec3 normal = cross(face.u, face.v);
      const double t = dot(face.origin - begin, normal) / dot(way, normal);
      const Vec3 at = begin + t * way - face.origin;
      const double u = dot(at, face.u) / dot(face.u, face.u), v = dot(at, face.v) / dot(face.v, face.v);
      if (dot(way, normal) >= 0 || t >= nearest || std::max(std::abs(u - 0.5), std::abs(v - 0.5)) > 0.5001) continue;
      nearest = t;
      const auto part = [&face](double x) { return std::size_t(std::clamp(int(x * face.parts), 0, face.parts - 1)); };
      ends[i] = emitted[face.first + part(u) + part(v) * std::size_t(face.parts)];
      for (int corner = 0; corner < 4; ++corner) {  // what is reflected is interpolated between the middles of patches
        const auto [x, a] = next_to(u, face.parts, corner % 2);
        const auto [y, b] = next_to(v, face.parts, corner / 2);
        const std::size_t patch = face.first + x + y * std::size_t(face.parts);
        add(ends[i], a * b, light[patch]);
        add(ends[i], -a * b, emitted[patch]);
      }
    }
    for (std::size_t k = 0; k <= kLegs; ++k) points[i][k] = begin + 0.999 * nearest * double(k) / kLegs * way;
    for (std::size_t k = 0; k < kLegs; ++k) {
      sent.push_back(gicube::ray_between(std::uint32_t(i), points[i][k], points[i][k + 1]));
    }
  }
  const gicube::RayBatch legs = board.rays().start(sent, {.type = gicube::RayType::kOpacity}).get();
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    double clear = 1;
    for (std::size_t k = 0; k < kLegs; ++k) {
      const double before = std::exchange(clear, clear * (1 - legs.rays[i * kLegs + k].opacity));
      add(pixels[i], before - clear, fog_light(0.5 * (points[i][k] + points[i][k + 1])));
    }
    add(pixels[i], clear, ends[i]);
  }
  write_light("polygons.ppm", kPixels, pixels);
  const double error = std::sqrt(squares);
  std::printf("%zu patches, %zu zones: RMS error of the sums of form factors %.2f%%\n", patches, n - patches,
              100 * error);
  return error > 0.03;
}
