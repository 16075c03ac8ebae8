#include "tomography.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gicube::reference {
namespace {

std::array<double, 3> parts(Vec3 v) { return {v.x, v.y, v.z}; }

// Calls visit(voxel, weight) for all samples of the ray of a pixel: what its integral is made of.
template <typename Visit>
void along(const ProjectorSetup& setup, const ViewPose& view, int column, int row, const Visit& visit) {
  constexpr double kStep = 0.01;  // voxels
  const Vec3 pixel =
      view.centre + (column - (setup.columns - 1) / 2.0) * view.u + (row - (setup.rows - 1) / 2.0) * view.v;
  const auto from = parts(view.source), way = parts(pixel - view.source), edge = parts(setup.spacing);
  std::array<double, 3> start{}, step{};
  double enters = 0, leaves = 1e9;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double last = setup.dims[axis] - 1.0;
    start[axis] = from[axis] / edge[axis] + last / 2;
    step[axis] = way[axis] / edge[axis];
    if (step[axis] == 0) {
      if (start[axis] < 0 || start[axis] > last) return;
      continue;
    }
    const double a = -start[axis] / step[axis], b = (last - start[axis]) / step[axis];
    enters = std::max(enters, std::min(a, b));
    leaves = std::min(leaves, std::max(a, b));
  }
  if (leaves <= enters) return;
  const double voxels = (leaves - enters) * std::hypot(step[0], step[1], step[2]);
  const int count = std::max(1, static_cast<int>(std::ceil(voxels / kStep)));
  const double length = (leaves - enters) * std::hypot(way[0], way[1], way[2]) / count;
  for (int i = 0; i < count; ++i) {
    const double t = enters + (leaves - enters) * (i + 0.5) / count;
    std::array<std::size_t, 3> low{};
    std::array<double, 3> part{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = std::clamp(start[axis] + t * step[axis], 0.0, setup.dims[axis] - 1.0);
      low[axis] = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(setup.dims[axis] - 2));
      part[axis] = at - static_cast<double>(low[axis]);
    }
    for (std::size_t corner = 0; corner < 8; ++corner) {
      double weight = length;
      std::size_t voxel = 0, stride = 1;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t high = corner >> axis & 1;
        weight *= high == 1 ? part[axis] : 1 - part[axis];
        voxel += (low[axis] + high) * stride;
        stride *= static_cast<std::size_t>(setup.dims[axis]);
      }
      visit(voxel, weight);
    }
  }
}

template <typename Visit>
void for_each_pixel(const ProjectorSetup& setup, const Visit& visit) {
  std::size_t i = 0;
  for (const ViewPose& view : setup.views) {
    for (int row = 0; row < setup.rows; ++row) {
      for (int column = 0; column < setup.columns; ++column) visit(view, column, row, i++);
    }
  }
}

double square_sum(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

}  // namespace

std::vector<double> project(const ProjectorSetup& setup, const std::vector<double>& volume) {
  std::vector<double> out(setup.views.size() * static_cast<std::size_t>(setup.rows * setup.columns));
  for_each_pixel(setup, [&](const ViewPose& view, int column, int row, std::size_t i) {
    along(setup, view, column, row, [&](std::size_t voxel, double weight) { out[i] += weight * volume[voxel]; });
  });
  return out;
}

std::vector<double> backproject(const ProjectorSetup& setup, const std::vector<double>& values) {
  std::vector<double> out(static_cast<std::size_t>(setup.dims[0] * setup.dims[1] * setup.dims[2]));
  for_each_pixel(setup, [&](const ViewPose& view, int column, int row, std::size_t i) {
    along(setup, view, column, row, [&](std::size_t voxel, double weight) { out[voxel] += weight * values[i]; });
  });
  return out;
}

std::vector<double> cgls(const ProjectorSetup& setup, const std::vector<double>& measured, int iterations) {
  std::vector<double> residual = measured, gradient = backproject(setup, residual), direction = gradient;
  std::vector<double> out(gradient.size());
  double square = square_sum(gradient);
  for (int i = 0; i < iterations; ++i) {
    const std::vector<double> seen = project(setup, direction);
    const double step = square / square_sum(seen);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += step * direction[k];
    for (std::size_t k = 0; k < seen.size(); ++k) residual[k] -= step * seen[k];
    gradient = backproject(setup, residual);
    const double now = square_sum(gradient);
    for (std::size_t k = 0; k < out.size(); ++k) direction[k] = gradient[k] + now / square * direction[k];
    square = now;
  }
  return out;
}

}  // namespace gicube::reference
