// Parts of volumes and coarser ones.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "encode/argument.h"
#include "encode/volume/samples.h"
#include "gicube/level_of_detail.h"
#include "gicube/wire/voxel.h"

namespace gicube {
namespace {

constexpr int kMaxLevels = 6;

// Calls take(index) for each original voxel of a coarse one. Positions beyond a face count as the voxel on it.
void for_each_original(const Dims& dims, const Dims& coarse, int edge, const auto& take) {
  const Dims low{coarse[0] * edge, coarse[1] * edge, coarse[2] * edge};
  for_each_position(low, {low[0] + edge, low[1] + edge, low[2] + edge}, [&](const Dims& at) {
    take(index_of(dims, std::min(at[0], dims[0] - 1), std::min(at[1], dims[1] - 1), std::min(at[2], dims[2] - 1)));
  });
}

Vec3 direction_at(std::span<const float> gradients, std::size_t voxel) {
  return unit({gradients[3 * voxel], gradients[3 * voxel + 1], gradients[3 * voxel + 2]});
}

std::uint8_t commonest(const std::array<int, wire::kTags>& counts) {
  return static_cast<std::uint8_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

void average(const VolumeView& volume, const auto& source, int edge, DerivedVolume& out) {
  std::vector<float> values(voxel_count(out.dims));
  const double share = 1.0 / (edge * edge * edge);
  for_each_position({}, out.dims, [&](const Dims& at) {
    double sum = 0;
    for_each_original(volume.dims, at, edge, [&](std::size_t from) {
      sum += std::clamp(static_cast<double>(source[from]), out.range.low, out.range.high);
    });
    values[index_of(out.dims, at)] = static_cast<float>(share * sum);
  });
  const auto bytes = std::as_bytes(std::span(values));
  out.samples.assign(bytes.begin(), bytes.end());
}

void gather_materials(const VolumeView& volume, int edge, DerivedVolume& out) {
  if (!volume.tags.empty()) out.tags.resize(voxel_count(out.dims));
  if (!volume.gradients.empty()) out.gradients.resize(3 * voxel_count(out.dims));
  if (!volume.colours.empty()) out.colours.resize(wire::kColourBytes * voxel_count(out.dims));
  if (out.tags.empty() && out.gradients.empty() && out.colours.empty()) return;
  const int all = edge * edge * edge;
  for_each_position({}, out.dims, [&](const Dims& at) {
    const std::size_t to = index_of(out.dims, at);
    std::array<int, wire::kTags> counts{};
    Vec3 sum;
    std::array<int, wire::kColourBytes> colour{};
    for_each_original(volume.dims, at, edge, [&](std::size_t from) {
      if (!out.tags.empty()) ++counts[volume.tags[from]];
      if (!out.gradients.empty()) sum = sum + direction_at(volume.gradients, from);
      for (std::size_t c = 0; !out.colours.empty() && c < colour.size(); ++c) {
        colour[c] += volume.colours[wire::kColourBytes * from + c];
      }
    });
    for (std::size_t c = 0; !out.colours.empty() && c < colour.size(); ++c) {
      out.colours[wire::kColourBytes * to + c] = static_cast<std::uint8_t>((colour[c] + all / 2) / all);
    }
    if (!out.tags.empty()) out.tags[to] = commonest(counts);
    if (out.gradients.empty()) return;
    out.gradients[3 * to] = static_cast<float>(sum.x);
    out.gradients[3 * to + 1] = static_cast<float>(sum.y);
    out.gradients[3 * to + 2] = static_cast<float>(sum.z);
  });
}

// Copies the rows of a box, `size` values per voxel.
template <typename T>
void copy_rows(std::span<const T> from, std::size_t size, const VolumeView& volume, const VoxelBox& box,
               std::vector<T>& into) {
  if (from.empty()) return;
  into.reserve(size * voxel_count(box.size));
  for (int z = box.low[2]; z < box.low[2] + box.size[2]; ++z) {
    for (int y = box.low[1]; y < box.low[1] + box.size[1]; ++y) {
      const auto row =
          from.subspan(size * index_of(volume.dims, box.low[0], y, z), size * static_cast<std::size_t>(box.size[0]));
      into.insert(into.end(), row.begin(), row.end());
    }
  }
}

}  // namespace

VolumeView DerivedVolume::view() const {
  return {.samples = samples,
          .type = type,
          .dims = dims,
          .spacing = spacing,
          .range = range,
          .gradients = gradients,
          .tags = tags,
          .colours = colours};
}

View Placement::view(View original) const {
  const auto moved = [this](Vec3 p) { return (1 / edge) * (p - low); };
  original.eye = moved(original.eye);
  original.look_at = moved(original.look_at);
  original.orthographic_height /= edge;
  for (CutPlane& plane : original.cut_planes) plane.offset = (plane.offset - dot(plane.normal, low)) / edge;
  for (Lamp& lamp : original.lamps) {
    if (auto* area = std::get_if<RectangleLight>(&lamp.light)) {
      area->corner = moved(area->corner);
      area->edge_u = (1 / edge) * area->edge_u;
      area->edge_v = (1 / edge) * area->edge_v;
      area->power /= edge * edge;  // keeps the brightness
    } else if (auto* sphere = std::get_if<SphereLight>(&lamp.light)) {
      sphere->centre = moved(sphere->centre);
      sphere->radius /= edge;
      sphere->power /= edge * edge;
    }
  }
  return original;
}

TransferFunction Placement::look(const TransferFunction& original, ValueRange range) const {
  if (edge == 1) return original;
  TransferFunction out{original.colours, {}};
  for (int density = 0; density <= wire::kDensityMax; ++density) {
    const double value = range.low + density * (range.high - range.low) / wire::kDensityMax;
    if (!out.opacities.empty() && !(value > out.opacities.back().value))
      continue;  // the range has fewer numbers than densities
    out.opacities.push_back({value, 1 - std::pow(1 - original.opacity_at(value), edge)});
  }
  return out;
}

DerivedVolume cropped(const VolumeView& volume, const VoxelBox& box) {
  check_volume(volume, std::numeric_limits<int>::max());
  constexpr const char* kAxes[] = {"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    expect_within(std::string("box.low.") + kAxes[axis], box.low[axis], 0, volume.dims[axis] - 2);
    expect_within(std::string("box.size.") + kAxes[axis], box.size[axis], 2, volume.dims[axis] - box.low[axis]);
  }
  DerivedVolume out;
  out.type = volume.type;
  out.dims = box.size;
  out.spacing = volume.spacing;
  out.range = resolve_range(volume);
  out.placement.low = {double(box.low[0]), double(box.low[1]), double(box.low[2])};
  copy_rows(volume.samples, bytes_per_sample(volume.type), volume, box, out.samples);
  copy_rows(volume.gradients, 3, volume, box, out.gradients);
  copy_rows(volume.tags, 1, volume, box, out.tags);
  copy_rows(volume.colours, wire::kColourBytes, volume, box, out.colours);
  return out;
}

DerivedVolume coarser(const VolumeView& volume, int level) {
  check_volume(volume, std::numeric_limits<int>::max());
  expect_within("level", level, 1, kMaxLevels);
  const int edge = 1 << level;
  if (*std::min_element(volume.dims.begin(), volume.dims.end()) <= edge) {
    throw BadArgument("level", "a level that leaves two voxels on each axis", std::to_string(level));
  }
  DerivedVolume out;
  out.dims = block_grid(volume.dims, edge);
  out.spacing = double(edge) * volume.spacing;
  out.range = resolve_range(volume);
  const double middle = 0.5 * (edge - 1);
  out.placement = {{middle, middle, middle}, double(edge)};
  with_samples(volume, [&](auto source) { average(volume, source, edge, out); });
  gather_materials(volume, edge, out);
  return out;
}

}  // namespace gicube
