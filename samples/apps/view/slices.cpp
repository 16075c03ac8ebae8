#include "view/slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "gicube/parallel_for.h"
#include "gicube/scene/error.h"
#include "gicube/scene/marks.h"

namespace gicube::samples::view {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMost = 4095;

// The initial window of the slices: soft tissue and bone for a CT, otherwise the robust range.
ValueRange window_of(const SceneSetup& setup, const ValueRange& range) {
  if (!setup.survey) return range;
  const Survey& survey = *setup.survey;
  ValueRange window = survey.robust;
  if (survey.kind == DataKind::kCt) {
    const double unit = (survey.ct.high - survey.ct.low) / 1000;
    window = {survey.ct.high - 400 * unit, survey.ct.high + 800 * unit};
  }
  window = {std::max(window.low, range.low), std::min(window.high, range.high)};
  return window.low < window.high ? window : range;
}

// The labels with their values and colours.
Json labels_of(const SceneSetup& setup) {
  std::vector<std::uint8_t> tags(setup.label_values.size());
  for (std::size_t i = 0; i < setup.labels.size(); ++i) tags[setup.labels[i]] = setup.tags[i];
  Json labels = Json::array();
  for (std::size_t label = 0; label < setup.label_values.size(); ++label) {
    Json colour = {0, 0, 0};
    if (label > 0 && tags[label] < setup.materials.size()) {
      const Colour& of = setup.materials[tags[label]].function.colours.front().colour;
      for (std::size_t c = 0; c < 3; ++c) colour[c] = std::lround(255 * of[c]);
    }
    labels.push_back({{"value", setup.label_values[label]}, {"colour", colour}});
  }
  return labels;
}

Slice in_words(std::span<const float> values, const ValueRange& range, int width, int height) {
  const double scale = range.high > range.low ? kMost / (range.high - range.low) : 0;
  Slice slice{width, height, {}};
  for (const float value : values) {
    const auto word = static_cast<std::uint16_t>(std::clamp(std::lround((value - range.low) * scale), 0L, 65535L));
    slice.words.push_back(static_cast<std::uint8_t>(word));
    slice.words.push_back(static_cast<std::uint8_t>(word >> 8));
  }
  return slice;
}

// The rays of a view's pixels, in voxels; a direction has the length of the smallest edge.
class PixelRays {
 public:
  PixelRays(const View& view, const Vec3& edges, int width, int height)
      : eye_(view.eye), is_parallel_(view.orthographic_height > 0) {
    const double least = std::min({edges.x, edges.y, edges.z});
    edges_ = (1 / least) * edges;
    forward_ = normalise(times_edges(view.look_at - view.eye));
    const Vec3 right = normalise(cross(forward_, times_edges(view.up)));
    const double tall =
        is_parallel_ ? view.orthographic_height : 2 * std::tan(view.fov_degrees * std::numbers::pi / 360);
    const double pixel = tall / height;
    across_ = pixel * right;
    down_ = -pixel * cross(right, forward_);
    corner_ = (0.5 - 0.5 * width) * across_ + (0.5 - 0.5 * height) * down_;
  }
  std::pair<Vec3, Vec3> at(std::size_t column, std::size_t row) const {
    const Vec3 aside = corner_ + static_cast<double>(column) * across_ + static_cast<double>(row) * down_;
    if (is_parallel_) return {eye_ + in_voxels(aside), in_voxels(forward_)};
    return {eye_, in_voxels(normalise(forward_ + aside))};
  }

 private:
  Vec3 times_edges(const Vec3& v) const { return {v.x * edges_.x, v.y * edges_.y, v.z * edges_.z}; }
  Vec3 in_voxels(const Vec3& v) const { return {v.x / edges_.x, v.y / edges_.y, v.z / edges_.z}; }

  Vec3 eye_, edges_, forward_, across_, down_, corner_;
  bool is_parallel_;
};

// Planes of a board's volume from `low` on, interpolated between voxels' centres.
class Slab {
 public:
  Slab(Board& board, int low, int planes) : dims_(board.dims()), low_(low), end_(low + planes) {
    values_ = board.read_volume({{0, 0, low}, {dims_[0], dims_[1], std::min(end_ + 1, dims_[2]) - low}});
  }
  // The interval of the ray, from its origin on, that is within the slab and not cut away.
  std::pair<double, double> span(const Vec3& origin, const Vec3& direction, std::span<const CutPlane> cuts) const {
    double near = 0, far = std::numeric_limits<double>::infinity();
    const auto cut = [&](double from, double step, double low, double high) {
      if (step == 0) {
        if (from < low || from >= high) far = 0;
        return;
      }
      const auto [first, last] = std::minmax({(low - from) / step, (high - from) / step});
      near = std::max(near, first);
      far = std::min(far, last);
    };
    cut(origin.x, direction.x, -0.5, dims_[0] - 0.5);
    cut(origin.y, direction.y, -0.5, dims_[1] - 0.5);
    cut(origin.z, direction.z, low_ == 0 ? -0.5 : low_, end_ == dims_[2] ? end_ - 0.5 : end_);
    for (const auto& [normal, offset] : cuts)
      cut(dot(normal, origin), dot(normal, direction), offset, std::numeric_limits<double>::infinity());
    return {near, far};
  }
  float value(const Vec3& p) const {
    const auto [x, right] = cell(p.x, 0, dims_[0]);
    const auto [y, back] = cell(p.y, 0, dims_[1]);
    const auto [z, up] = cell(p.z, low_, std::min(end_ + 1, dims_[2]));
    const std::size_t dx = right > 0 ? 1 : 0, dy = back > 0 ? voxels_of({dims_[0], 1, 1}) : 0;
    const std::size_t dz = up > 0 ? voxels_of({dims_[0], dims_[1], 1}) : 0;
    const float* const at = &values_[z * voxels_of({dims_[0], dims_[1], 1}) + y * voxels_of({dims_[0], 1, 1}) + x];
    const auto row = [&, share = right](const float* of) { return of[0] + share * (of[dx] - of[0]); };
    const auto plane = [&, share = back](const float* of) { return row(of) + share * (row(of + dy) - row(of)); };
    return plane(at) + up * (plane(at + dz) - plane(at));
  }

 private:
  // The voxel below the coordinate, counted from `low`, and the fraction to the next one.
  static std::pair<std::size_t, float> cell(double at, int low, int end) {
    const double from = std::clamp(at, double{1.0 * low}, double{1.0 * (end - 1)}) - low;
    const auto voxel = static_cast<std::size_t>(from);
    return {voxel, static_cast<float>(from - static_cast<double>(voxel))};
  }

  Dims dims_;
  int low_, end_;
  std::vector<float> values_;
};

}  // namespace

std::string tf_text(const TransferFunctionFile& file) {
  constexpr std::array kScales{"absolute", "normalised", "hounsfield", "robust"};
  std::string text = fmt::format("values {}\n", kScales[static_cast<std::size_t>(file.scale)]);
  for (const ColourPoint& point : file.function.colours) {
    text += fmt::format("colour {} {} {} {}\n", point.value, point.colour[0], point.colour[1], point.colour[2]);
  }
  for (const OpacityPoint& point : file.function.opacities)
    text += fmt::format("opacity {} {}\n", point.value, point.opacity);
  return text;
}

std::string tf_text(const Preset& preset, const SceneSetup* setup) {
  if (setup == nullptr || !setup->survey) return std::string(preset.text);
  const TransferFunctionFile file = find_preset(preset.name);
  const bool asks = file.scale == TransferScale::kHounsfield || file.scale == TransferScale::kRobust;
  return asks ? tf_text(in_values_of(*setup->survey, setup->survey->range, file)) : std::string(preset.text);
}

void describe_values(const SceneSetup& setup, const ValueRange& range, Json& volume) {
  const bool labels = !setup.labels.empty();
  volume["look"] = setup.look_why.empty() || labels ? "" : tf_text(setup.materials.front());
  volume["look_why"] = setup.look_why;
  const ValueRange window = window_of(setup, range);
  volume["window"] = {window.low, window.high};
  const bool hounsfield =
      setup.survey && setup.survey->kind == DataKind::kCt && setup.survey->ct == ValueRange{-1000, 0};
  volume["unit"] = hounsfield ? "HU" : "";
  volume["whole"] = setup.volume.type != SampleType::kFloat32;
  volume["marks"] = axis_marks(setup.volume.placement);
  volume["patient"] = setup.volume.placement.axes == WorldAxes::kPatient;
  if (labels) volume["labels"] = labels_of(setup);
}

Slice slice_of(Board& board, const SceneSetup& setup, const Request& request) {
  const Dims dims = board.dims();
  const auto axis = static_cast<std::size_t>(request.axis);
  if (request.at >= dims[axis])
    throw InputError("at", fmt::format("a voxel from 0 to {}", dims[axis] - 1), std::to_string(request.at));
  VoxelBox box{{0, 0, 0}, dims};
  box.low[axis] = request.at;
  box.size[axis] = 1;
  const int width = axis == 0 ? dims[1] : dims[0], height = axis == 2 ? dims[1] : dims[2];
  if (setup.labels.size() != voxels_of(dims))
    return in_words(board.read_volume(box), board.value_range(), width, height);
  std::vector<float> labels;
  for (int z = box.low[2]; z < box.low[2] + box.size[2]; ++z) {
    for (int y = box.low[1]; y < box.low[1] + box.size[1]; ++y) {
      for (int x = box.low[0]; x < box.low[0] + box.size[0]; ++x) {
        labels.push_back(
            setup.labels[voxels_of({dims[0], dims[1], z}) + voxels_of({dims[0], y, 1}) + static_cast<std::size_t>(x)]);
      }
    }
  }
  return in_words(labels, {0, kMost}, width, height);
}

Slice projection_of(Board& board, const SceneSetup& setup, Request::Projection projection, const Progress& progress) {
  const View& view = setup.view;
  const Dims dims = board.dims();
  const double shrunk = std::min(1.0, 512.0 / std::max(view.width, view.height));
  const int width = std::max(1, static_cast<int>(std::lround(shrunk * view.width)));
  const int height = std::max(1, static_cast<int>(std::lround(shrunk * view.height)));
  const PixelRays rays(view, setup.volume.spacing, width, height);
  const bool mean = projection == Request::Projection::kMean;
  std::vector<float> found(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::vector<float> counts(found.size());
  constexpr int kSlab = 32;  // chosen: 8 MB of a 256^3 volume at once
  for (int z = 0; z < dims[2]; z += kSlab) {
    const Slab slab(board, z, std::min(kSlab, dims[2] - z));
    parallel_for(static_cast<std::size_t>(height), 0, [&](std::size_t row) {
      for (std::size_t column = 0; column < static_cast<std::size_t>(width); ++column) {
        const auto [origin, direction] = rays.at(column, row);
        const auto [near, far] = slab.span(origin, direction, view.cut_planes);
        const std::size_t pixel = row * static_cast<std::size_t>(width) + column;
        for (double t = std::ceil(near); t < far; ++t) {
          const float value = slab.value(origin + t * direction);
          found[pixel] = mean || counts[pixel] == 0 ? found[pixel] + value : std::max(found[pixel], value);
          ++counts[pixel];
        }
      }
    });
    if (progress)
      progress(static_cast<std::uint32_t>(std::min(z + kSlab, dims[2])), static_cast<std::uint32_t>(dims[2]));
  }
  const ValueRange range = board.value_range();
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (counts[i] == 0) found[i] = static_cast<float>(range.low);
    if (mean && counts[i] > 0) found[i] /= counts[i];
  }
  return in_words(found, range, width, height);
}

}  // namespace gicube::samples::view
