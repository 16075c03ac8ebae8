#include "gicube/projector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "encode/argument.h"
#include "encode/vectors.h"
#include "encode/volume/samples.h"
#include "gicube/parallel_for.h"

namespace gicube {
namespace {

std::size_t pixels_of(const ProjectorSetup& setup) {
  return static_cast<std::size_t>(setup.columns) * static_cast<std::size_t>(setup.rows);
}

Vec3 half_of(const ProjectorSetup& setup) {
  const auto half = [](int dim) { return (dim - 1) / 2.0; };
  return {half(setup.dims[0]), half(setup.dims[1]), half(setup.dims[2])};
}
Vec3 to_voxels(const ProjectorSetup& setup, Vec3 place) { return over(place, setup.spacing) + half_of(setup); }

// Distance of a point from the box of voxel centres; 0 inside.
double distance_to_box(const ProjectorSetup& setup, Vec3 place) {
  const Vec3 most = times(half_of(setup), setup.spacing);
  const auto beyond = [](double x, double limit) { return std::max(0.0, std::abs(x) - limit); };
  return length(Vec3{beyond(place.x, most.x), beyond(place.y, most.y), beyond(place.z, most.z)});
}

void check(const ProjectorSetup& setup) {
  constexpr double kMost = 65536;  // chosen: pixels along an edge
  for (const int dim : setup.dims) expect(dim >= 2, "dims", "at least 2", dim);
  for (const double edge : {setup.spacing.x, setup.spacing.y, setup.spacing.z}) {
    expect(std::isfinite(edge) && edge > 0, "spacing", "finite numbers above 0", edge);
  }
  expect_within("columns", setup.columns, 1, kMost);
  expect_within("rows", setup.rows, 1, kMost);
  expect_within("step", setup.step, 1.0 / 64, 16);
  expect(!setup.views.empty(), "views", "at least one", 0);
  for (std::size_t i = 0; i < setup.views.size(); ++i) {
    const auto name = [i](const char* part) { return fmt::format("views[{}].{}", i, part); };
    const ViewPose& view = setup.views[i];
    expect_finite(name("source"), view.source);
    expect_finite(name("centre"), view.centre);
    expect_finite(name("u"), view.u);
    expect_finite(name("v"), view.v);
    const Vec3 normal = cross(view.u, view.v);
    expect(length(normal) > 1e-6 * length(view.u) * length(view.v), name("v"), "a direction that is not along u",
           fmt::format("({}, {}, {})", view.v.x, view.v.y, view.v.z));
    expect(distance_to_box(setup, view.source) > 0, name("source"), "a position outside of the volume",
           fmt::format("({}, {}, {})", view.source.x, view.source.y, view.source.z));
    expect(std::abs(dot(view.centre - view.source, normal)) > 0, name("centre"),
           "a plane that does not contain the source",
           fmt::format("({}, {}, {})", view.centre.x, view.centre.y, view.centre.z));
  }
}

// Projector::rays() into `out`.
void find_rays(const ProjectorSetup& setup, std::size_t view, std::span<HostRay> out) {
  const ViewPose& at = setup.views[view];
  const Vec3 from = to_voxels(setup, at.source);
  const auto columns = static_cast<std::size_t>(setup.columns), rows = static_cast<std::size_t>(setup.rows);
  parallel_for(rows, 0, [&](std::size_t row) {
    const Vec3 middle = at.centre + (static_cast<double>(row) - (setup.rows - 1) / 2.0) * at.v;
    for (std::size_t column = 0; column < columns; ++column) {
      const Vec3 pixel = middle + (static_cast<double>(column) - (setup.columns - 1) / 2.0) * at.u;
      const HostRay line{.position = from,
                         .direction = to_voxels(setup, pixel) - from,
                         .length = std::numeric_limits<double>::infinity()};
      out[row * columns + column] = clip_to_volume(line, setup.dims).value_or(HostRay{});
    }
  });
}

void check_finite(const char* field, std::span<const float> values) {
  const auto bad = std::ranges::find_if(values, [](float value) { return !std::isfinite(value); });
  if (bad != values.end()) throw BadArgument(field, "finite values", std::to_string(*bad));
}

}  // namespace

Projector::Projector(Board& board, ProjectorSetup setup) : board_(board), setup_(std::move(setup)) { check(setup_); }

std::vector<std::size_t> Projector::checked(Views views) const {
  std::vector<std::size_t> out(views.begin(), views.end());
  if (out.empty()) {
    out.resize(setup_.views.size());
    std::iota(out.begin(), out.end(), 0);
  }
  for (const std::size_t view : out) {
    expect(view < setup_.views.size(), "views", fmt::format("indices below {}", setup_.views.size()), view);
  }
  return out;
}

void Projector::load(std::span<const float> volume) {
  float low = 0, high = 0;
  for (const float value : volume) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (low == high) high = low + 1;  // an empty volume
  board_.load_volume({.samples = std::as_bytes(volume),
                      .type = SampleType::kFloat32,
                      .dims = setup_.dims,
                      .spacing = setup_.spacing,
                      .range = ValueRange{low, high},
                      .find_gradients = false});
  loaded_ = true;
}

void Projector::load_nothing() {
  const std::vector<std::byte> nothing(voxel_count(setup_.dims));
  board_.load_volume({.samples = nothing, .dims = setup_.dims, .spacing = setup_.spacing, .find_gradients = false});
  loaded_ = true;
}

std::vector<HostRay> Projector::rays(std::size_t view) const {
  expect(view < setup_.views.size(), "view", fmt::format("below {}", setup_.views.size()), view);
  std::vector<HostRay> out(pixels_of(setup_));
  find_rays(setup_, view, out);
  return out;
}

double Projector::length_of(const HostRay& ray) const {
  if (ray.length <= 0) return 0;
  return ray.length * length(times(ray.direction, setup_.spacing)) / length(ray.direction);
}

double Projector::max_of_a_voxel(std::size_t view) const {
  expect(view < setup_.views.size(), "view", fmt::format("below {}", setup_.views.size()), view);
  const ViewPose& at = setup_.views[view];
  const Vec3 edge = setup_.spacing, normal = cross(at.u, at.v);
  const double longest = std::max({edge.x, edge.y, edge.z}), area = length(normal);
  // Rays are densest where the volume is nearest to the source.
  const double to_detector = std::abs(dot(at.centre - at.source, normal)) / area;
  const double nearest = distance_to_box(setup_, at.source) / to_detector;
  return longest * std::max(1.0, longest * longest / (area * nearest * nearest));
}

void Projector::project(std::span<const float> volume, Views views, const TakeView& take) {
  expect(volume.size() == voxel_count(setup_.dims), "volume", fmt::format("{} values", voxel_count(setup_.dims)),
         volume.size());
  check_finite("volume", volume);
  const std::vector<std::size_t> order = checked(views);
  load(volume);
  struct Batch {
    Ticket ticket;
    std::vector<HostRay> rays;        // those that meet the volume
    std::vector<std::size_t> pixels;  // of these rays
  };
  const auto begin = [&](std::size_t view) {
    Batch batch;
    const std::vector<HostRay> all = rays(view);
    for (std::size_t pixel = 0; pixel < all.size(); ++pixel) {
      if (all[pixel].length <= 0) continue;
      batch.rays.push_back(all[pixel]);
      batch.pixels.push_back(pixel);
    }
    counts_.rays += batch.rays.size();
    batch.ticket = board_.submit(batch.rays, {.type = RayType::kIntegral, .step = setup_.step});
    return batch;
  };
  const double low = board_.value_range().low;
  Batch next = begin(order[0]);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Batch batch = std::exchange(next, Batch());
    if (i + 1 < order.size()) next = begin(order[i + 1]);
    std::vector<TracedRay> traced(batch.rays.size());
    board_.receive(batch.ticket, traced);
    std::vector<float> values(pixels_of(setup_));
    for (std::size_t k = 0; k < traced.size(); ++k) {
      const double below = low == 0 ? 0 : low * length_of(batch.rays[k]);
      values[batch.pixels[k]] = static_cast<float>(traced[k].integral + below);
    }
    take(i, values);
  }
}

std::vector<float> Projector::project(std::span<const float> volume, Views views) {
  std::vector<float> out;
  out.reserve(pixels_of(setup_) * (views.empty() ? setup_.views.size() : views.size()));
  project(volume, views, [&out](std::size_t /*i*/, const std::vector<float>& values) {
    out.insert(out.end(), values.begin(), values.end());
  });
  return out;
}

std::vector<float> Projector::backproject(Views views, double max, const ViewValues& values) {
  expect(std::isfinite(max) && max >= 0, "max", "a finite number from 0 on", max);
  const std::vector<std::size_t> order = checked(views);
  if (!loaded_) load_nothing();
  // The unit is so large that a voxel with the largest value on all rays through it reaches half of a sum's range, and
  // a step deposits at most 2^15 - 1 units, so that thousands of rays fit one command [chosen].
  constexpr double kMaxUnits = (1 << 15) - 1, kMaxSum = 8.0 * (1 << 30);
  const Vec3 edge = setup_.spacing;
  const double of_a_step = std::max({edge.x, edge.y, edge.z}) * setup_.step / kMaxUnits;
  double of_all = 0;
  for (const std::size_t view : order) of_all += max_of_a_voxel(view) / kMaxSum;
  board_.clear_sums(std::max(max, 1e-30) * std::max(of_a_step, of_all));

  constexpr std::size_t kUnderWay = 2;  // chosen: the board traces one view while the host makes the next
  std::deque<Ticket> under_way;
  const auto receive_down_to = [&](std::size_t left) {
    for (; under_way.size() > left; under_way.pop_front()) {
      const BatchReport report = board_.receive(under_way.front());
      counts_.deposits += report.deposits->samples;
      counts_.overflowed += report.deposits->overflowed;
    }
  };
  std::vector<HostRay> of_view(pixels_of(setup_));
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::vector<double> of_rays = values(i);
    expect(of_rays.size() == of_view.size(), "values", fmt::format("{} of a view", of_view.size()), of_rays.size());
    find_rays(setup_, order[i], of_view);
    std::size_t count = 0;  // rays that deposit something
    for (std::size_t k = 0; k < of_view.size(); ++k) {
      of_view[k].energy = of_rays[k];
      if (of_view[k].length > 0 && of_rays[k] != 0) of_view[count++] = of_view[k];
    }
    receive_down_to(kUnderWay - 1);
    counts_.rays += count;
    const auto some = std::span<const HostRay>(of_view).first(count);
    under_way.push_back(board_.submit(some, {.type = RayType::kBackproject, .step = setup_.step}));
  }
  receive_down_to(0);
  return board_.read_sums({{0, 0, 0}, setup_.dims});
}

std::vector<float> Projector::backproject(std::span<const float> values, Views views) {
  const std::size_t size = pixels_of(setup_), count = views.empty() ? setup_.views.size() : views.size();
  expect(values.size() == size * count, "values", fmt::format("{} values", size * count), values.size());
  check_finite("values", values);
  double most = 0;
  for (const float value : values) most = std::max(most, std::abs(double{value}));
  return backproject(views, most, [&](std::size_t i) {
    const auto view = values.subspan(i * size, size);
    return std::vector<double>(view.begin(), view.end());
  });
}

}  // namespace gicube
