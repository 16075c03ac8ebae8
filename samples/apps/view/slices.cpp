#include "view/slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "gicube/scene/error.h"
#include "gicube/scene/marks.h"

namespace gicube::samples::view {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMost = 4095;

// The first window of the slices: soft tissue and bone for a CT, otherwise the range from background to the brightest.
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

// By tag; `labels` has places in label_values.
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

Slice slice_of(Board& board, const SceneSetup& setup, const Request& request, const Progress& progress) {
  const Dims dims = board.dims();
  const auto axis = static_cast<std::size_t>(request.axis);
  if (request.at >= dims[axis])
    throw InputError("at", fmt::format("a voxel from 0 to {}", dims[axis] - 1), std::to_string(request.at));
  const ValueRange range = board.value_range();
  const double scale = range.high > range.low ? kMost / (range.high - range.low) : 0;
  Slice slice{axis == 0 ? dims[1] : dims[0], axis == 2 ? dims[1] : dims[2], {}};
  const std::size_t pixels = static_cast<std::size_t>(slice.width) * static_cast<std::size_t>(slice.height);
  std::vector<double> words(pixels);
  VoxelBox box{{0, 0, 0}, dims};
  const bool has_labels = setup.labels.size() == voxels_of(dims);
  // Calls use(pixel, index of the voxel, its value) for the voxels of the box.
  const auto each = [&](const auto& use) {
    const std::vector<float> values = has_labels ? std::vector<float>() : board.read_volume(box);
    std::size_t i = 0;
    for (int z = box.low[2]; z < box.low[2] + box.size[2]; ++z) {
      for (int y = box.low[1]; y < box.low[1] + box.size[1]; ++y) {
        for (int x = box.low[0]; x < box.low[0] + box.size[0]; ++x, ++i) {
          const int across = axis == 0 ? y : x, up = axis == 2 ? y : z;
          const auto pixel =
              static_cast<std::size_t>(up) * static_cast<std::size_t>(slice.width) + static_cast<std::size_t>(across);
          const std::size_t voxel =
              voxels_of({dims[0], dims[1], z}) + voxels_of({dims[0], y, 1}) + static_cast<std::size_t>(x);
          use(pixel, has_labels ? double{1.0 * setup.labels[voxel]} : (double{values[i]} - range.low) * scale);
        }
      }
    }
  };
  if (request.show == Request::Show::kSlice) {
    box.low[axis] = request.at;
    box.size[axis] = 1;
    each([&](std::size_t pixel, double word) { words[pixel] = word; });
  } else {
    constexpr int kSlab = 32;  // chosen: 8 MB of a 256^3 volume at once
    for (int z = 0; z < dims[2]; z += kSlab) {
      box.low[2] = z;
      box.size[2] = std::min(kSlab, dims[2] - z);
      // The mean of labels would be none: the last one counts, as for the maximum.
      const bool mean = request.show == Request::Show::kMean && !has_labels;
      each([&](std::size_t pixel, double word) {
        words[pixel] = mean ? words[pixel] + word / dims[axis] : std::max(words[pixel], word);
      });
      if (progress) progress(static_cast<std::uint32_t>(z + box.size[2]), static_cast<std::uint32_t>(dims[2]));
    }
  }
  for (const double word : words) {
    const auto bits = static_cast<std::uint16_t>(std::clamp(std::lround(word), 0L, 65535L));
    slice.words.push_back(static_cast<std::uint8_t>(bits));
    slice.words.push_back(static_cast<std::uint8_t>(bits >> 8));
  }
  return slice;
}

}  // namespace gicube::samples::view
