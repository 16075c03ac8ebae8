#include "cone_beam/phantom/phantom.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gicube/error.h"
#include "gicube/parallel_for.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

using Field = std::vector<double>;

void expect_size(const char* name, std::size_t size, const Grid& grid) {
  const std::size_t voxels = voxel_count(grid.dims);
  expect(size == voxels, name, fmt::format("{} values", voxels), static_cast<double>(size));
}

std::vector<std::size_t> voxels_in(const FieldOfView& field, const Grid& grid) {
  std::vector<std::size_t> inside;
  std::size_t i = 0;
  for (std::size_t z = 0; z < static_cast<std::size_t>(grid.dims[2]); ++z) {
    for_each_in_slice(grid, z, [&](Vec3 at) {
      if (std::hypot(at.x, at.y) <= field.radius && std::abs(at.z) <= field.half_height) inside.push_back(i);
      ++i;
    });
  }
  return inside;
}

constexpr int kReach = 5;
constexpr double kSigma = 1.5;

// Windowed means at each place of `lanes` adjacent lines, whose places are `stride` apart.
void smooth_lines(double* first, int length, std::size_t stride, std::size_t lanes, const std::vector<double>& weights,
                  std::vector<double>& copy) {
  copy.resize(static_cast<std::size_t>(length) * lanes);
  for (std::size_t i = 0; i < static_cast<std::size_t>(length); ++i) {
    std::copy_n(first + i * stride, lanes, copy.data() + i * lanes);
  }
  for (int i = 0; i < length; ++i) {
    double* const out = first + static_cast<std::size_t>(i) * stride;
    std::fill_n(out, lanes, 0.0);
    double all = 0;
    const int begin = std::max(0, i - kReach), end = std::min(length - 1, i + kReach);
    for (int j = begin; j <= end; ++j) all += weights[static_cast<std::size_t>(std::abs(j - i))];
    for (int j = begin; j <= end; ++j) {
      const double weight = weights[static_cast<std::size_t>(std::abs(j - i))] / all;
      const double* const in = copy.data() + static_cast<std::size_t>(j) * lanes;
      for (std::size_t lane = 0; lane < lanes; ++lane) out[lane] += weight * in[lane];
    }
  }
}

// Means over Gaussian windows, by axes. A window across a face has the mean of its part inside.
void smooth(Field& field, const Dims& dims) {
  std::vector<double> weights;
  for (int i = 0; i <= kReach; ++i) weights.push_back(std::exp(-i * i / (2 * kSigma * kSigma)));
  std::size_t stride = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t run = stride * static_cast<std::size_t>(dims[axis]);
    constexpr std::size_t kLanes = 64;  // chosen: a line's piece stays in the cache
    const std::size_t chunks = (stride + kLanes - 1) / kLanes;
    parallel_for(field.size() / run * chunks, 0, [&, stride, axis](std::size_t part) {
      thread_local std::vector<double> copy;
      const std::size_t lane = part % chunks * kLanes;
      smooth_lines(field.data() + part / chunks * run + lane, dims[axis], stride, std::min(kLanes, stride - lane),
                   weights, copy);
    });
    stride = run;
  }
}

double similarity(const Grid& grid, std::span<const float> values, std::span<const float> truth, double span,
                  const std::vector<std::size_t>& inside) {
  const std::size_t size = values.size();
  Field a(size), b(size), aa(size), bb(size), ab(size);
  for (std::size_t i = 0; i < size; ++i) {
    a[i] = static_cast<double>(values[i]);
    b[i] = static_cast<double>(truth[i]);
    aa[i] = a[i] * a[i];
    bb[i] = b[i] * b[i];
    ab[i] = a[i] * b[i];
  }
  for (Field* field : {&a, &b, &aa, &bb, &ab}) smooth(*field, grid.dims);
  const double c1 = 0.01 * span * 0.01 * span, c2 = 0.03 * span * 0.03 * span;
  double sum = 0;
  for (const std::size_t i : inside) {
    const double means = a[i] * b[i], squares = a[i] * a[i] + b[i] * b[i];
    const double variances = aa[i] + bb[i] - squares, covariance = ab[i] - means;
    const double below = (squares + c1) * (variances + c2);
    sum += below == 0 ? 1 : (2 * means + c1) * (2 * covariance + c2) / below;
  }
  return sum / static_cast<double>(inside.size());
}

}  // namespace

Comparison compare(const Grid& grid, std::span<const float> values, std::span<const float> truth,
                   const FieldOfView& field) {
  expect_size("values", values.size(), grid);
  expect_size("truth", truth.size(), grid);
  const std::vector<std::size_t> inside = voxels_in(field, grid);
  if (inside.empty()) {
    throw BadArgument("field of view", "at least one voxel's centre in it",
                      fmt::format("radius {}, half height {}", field.radius, field.half_height));
  }
  Comparison out;
  out.voxels = inside.size();
  const auto all = static_cast<double>(inside.size());
  double squares = 0, size = 0, sum = 0;
  float low = truth[inside[0]], high = low;
  for (const std::size_t i : inside) {
    const double real = static_cast<double>(truth[i]), off = static_cast<double>(values[i]) - real;
    squares += off * off;
    size += real * real;
    sum += off;
    low = std::min(low, truth[i]);
    high = std::max(high, truth[i]);
  }
  const double span = static_cast<double>(high) - static_cast<double>(low);
  out.rmse = std::sqrt(squares / all);
  out.bias = sum / all;
  out.relative_l2 = squares == 0 ? 0 : std::sqrt(squares / size);
  out.psnr = 20 * std::log10(span / out.rmse);
  if (squares == 0) out.psnr = std::numeric_limits<double>::infinity();
  out.ssim = similarity(grid, values, truth, span, inside);
  return out;
}

std::vector<float> differences(std::span<const float> values, std::span<const float> truth) {
  expect(values.size() == truth.size(), "values", fmt::format("{} of them", truth.size()),
         static_cast<double>(values.size()));
  std::vector<float> out(values.size());
  std::transform(values.begin(), values.end(), truth.begin(), out.begin(), std::minus<>());
  return out;
}

std::vector<float> profile(const Grid& grid, std::span<const float> values, int axis, Dims through) {
  expect_size("values", values.size(), grid);
  expect(axis >= 0 && axis <= 2, "axis", "0, 1 or 2", axis);
  for (std::size_t k = 0; k < 3; ++k) {
    expect(through[k] >= 0 && through[k] < grid.dims[k], fmt::format("through[{}]", k),
           fmt::format("0..{}", grid.dims[k] - 1), through[k]);
  }
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  std::vector<float> out;
  int& i = through[at(axis)];
  for (i = 0; i < grid.dims[at(axis)]; ++i) {
    out.push_back(values[(at(through[2]) * at(grid.dims[1]) + at(through[1])) * at(grid.dims[0]) + at(through[0])]);
  }
  return out;
}

}  // namespace gicube::samples
