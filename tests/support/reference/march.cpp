#include "march.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <thread>

#include "classify.h"
#include "filter.h"

namespace gicube::reference {

namespace {

constexpr double kStepOne = 65536;      // a view's step is kept to 16 fraction bits, here too
constexpr double kPositionOne = 16384;  // 10.14 and 1.14
constexpr double kColourOne = 4095;
constexpr double kOpacityOne = (1 << 24) - 1;
// A sample that falls on the volume's far face belongs to it, whatever the last digit of a quotient of doubles says.
constexpr double kStepTolerance = 1e-9;

double to_grid(double v, double one) { return std::round(v * one) / one; }
Vec3 to_grid(Vec3 v, double one) { return {to_grid(v.x, one), to_grid(v.y, one), to_grid(v.z, one)}; }
// As the board's adders round: half a unit goes up, also below zero. With a step of 1/2 every odd direction word is
// such.
double to_grid_half_up(double v, double one) { return std::floor(v * one + 0.5) / one; }
Vec3 to_grid_half_up(Vec3 v, double one) {
  return {to_grid_half_up(v.x, one), to_grid_half_up(v.y, one), to_grid_half_up(v.z, one)};
}
Vec3 times(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

Vec3 hold(Vec3 p, Dims dims) {
  return {std::clamp(p.x, 0.0, dims[0] - 1.0), std::clamp(p.y, 0.0, dims[1] - 1.0),
          std::clamp(p.z, 0.0, dims[2] - 1.0)};
}

// Calls work(row) for every row.
template <typename Progress>
void for_each_row(int rows, unsigned threads, const Progress& work) {
  std::atomic<int> next{0};
  const auto take_rows = [&] {
    for (int row = next++; row < rows; row = next++) work(row);
  };
  std::vector<std::future<void>> others;
  const unsigned count = threads == 0 ? std::max(1u, std::thread::hardware_concurrency()) : threads;
  for (unsigned i = 1; i < count; ++i) others.push_back(std::async(std::launch::async, take_rows));
  take_rows();
  for (auto& other : others) other.get();
}

}  // namespace

Renderer::Renderer(const Scene& scene, const Quantisers& quantisers)
    : scene_(scene),
      quantisers_(quantisers),
      step_(to_grid(scene.view.step, kStepOne)),
      field_(scene.volume, quantisers),
      camera_(scene.view, field_.spacing()),
      light_(scene.shading, camera_.towards_eye(), quantisers) {}

Rgba Renderer::integrate(Vec3 origin, Vec3 direction) const {
  const Line line{origin, normalise(direction)};
  const auto interval = clip(line, scene_.volume.dims, scene_.view.cut_planes);
  if (!interval) return {};
  return quantisers_.position ? march_in_words(line, *interval) : march(line, *interval);
}

Rgba Renderer::march(const Line& line, Interval interval) const {
  const auto samples = static_cast<long>((interval.end - interval.begin) / step_ + kStepTolerance) + 1;
  const double edges = edges_per_step(line.direction);
  Rgba ray;
  for (long i = 0; i < samples && ray.opacity < scene_.view.opacity_threshold; ++i) {
    const Vec3 position = line.at(interval.begin + static_cast<double>(i) * step_);
    add_sample(ray, hold(position, scene_.volume.dims), line.direction, edges);  // within rounding inside already
  }
  return ray;
}

// The board's way: start, direction and step are words, the step is added on, and the ray ends outside. All sums are of
// multiples of 2^-14 below 2^10, so exact.
Rgba Renderer::march_in_words(const Line& line, Interval interval) const {
  const Dims dims = scene_.volume.dims;
  const Vec3 direction = to_grid(line.direction, kPositionOne);
  const Vec3 step = to_grid_half_up(step_ * direction, kPositionOne);
  const double edges = edges_per_step(normalise(direction));
  const auto kept = [&](Vec3 p) {
    return std::none_of(scene_.view.cut_planes.begin(), scene_.view.cut_planes.end(), [&](const CutPlane& plane) {
      return dot(plane.normal, step) < 0 && dot(plane.normal, p) < plane.offset;
    });
  };
  Rgba ray;
  Vec3 position = hold(to_grid(line.at(interval.begin), kPositionOne), dims);
  while (position == hold(position, dims) && kept(position) && ray.opacity < scene_.view.opacity_threshold) {
    add_sample(ray, position, step, edges);
    position = position + step;
  }
  return ray;
}

void Renderer::add_sample(Rgba& ray, Vec3 position, Vec3 direction, double edges) const {
  const TransferFunction& function = scene_.functions[static_cast<std::size_t>(field_.tag(position))];
  const Material material = classify(function, field_.sample(position), field_.range(), quantisers_);
  if (material.opacity == 0) return;
  std::array<double, 3> colour = material.colour;
  // A face that a plane cuts, and one voxel behind it, shows colours as they are.
  const bool at_cut_face =
      std::any_of(scene_.view.cut_planes.begin(), scene_.view.cut_planes.end(), [&](const CutPlane& plane) {
        return dot(plane.normal, direction) > 0 && dot(plane.normal, position) - plane.offset < length(plane.normal);
      });
  if (scene_.view.shade && !at_cut_face) colour = light_.shade(colour, field_.gradient(position));
  double alpha = 1 - std::pow(1 - material.opacity, edges);
  if (quantisers_.opacity) alpha = to_grid(alpha, kOpacityOne);
  if (quantisers_.colour) {
    for (double& c : colour) c = to_grid(c, kColourOne);
  }
  ray = over(ray, {{alpha * colour[0], alpha * colour[1], alpha * colour[2]}, alpha});
  if (quantisers_.opacity) ray.opacity = to_grid(ray.opacity, kOpacityOne);
  if (quantisers_.colour) {
    for (double& c : ray.colour) c = std::min(to_grid(c, kColourOne), 1.0);
  }
}

double Renderer::edges_per_step(Vec3 direction) const {
  const double edges = step_ * length(times(field_.spacing(), direction));
  return quantisers_.opacity ? to_grid(edges, kStepOne) : edges;
}

Picture Renderer::render(unsigned threads) const {
  const View& view = scene_.view;
  const int per_axis = view.samples_per_axis;
  Picture rays{view.width * per_axis, view.height * per_axis, {}};
  rays.pixels.resize(static_cast<std::size_t>(rays.width) * static_cast<std::size_t>(rays.height));
  for_each_row(rays.height, threads, [&](int row) {
    for (int column = 0; column < rays.width; ++column) {
      const Line line = camera_.line((column + 0.5) / per_axis, (row + 0.5) / per_axis);
      rays.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(rays.width) +
                  static_cast<std::size_t>(column)] = integrate(line.origin, line.direction);
    }
  });
  Picture picture = filter(rays, per_axis, view.filter);
  if (quantisers_.framebuffer) {
    for (Rgba& pixel : picture.pixels) {
      for (double& c : pixel.colour) c = to_grid(c, 255);
      pixel.opacity = to_grid(pixel.opacity, 4095);
    }
  }
  return picture;
}

}  // namespace gicube::reference
