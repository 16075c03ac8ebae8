#include "scene/label_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "scene/common/cells.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {
namespace {

constexpr std::size_t kTags = 4;

// Okabe and Ito (2008): distinguishable with any colour vision.
struct Named {
  const char* name;
  Colour colour;
};
constexpr std::array<Named, kTags> kColours{{{"orange", {0.90, 0.62, 0.00}},
                                             {"sky blue", {0.34, 0.71, 0.91}},
                                             {"green", {0.00, 0.62, 0.45}},
                                             {"purple", {0.80, 0.47, 0.65}}}};
constexpr double kThrough = 0.7;  // chosen: the share of light that passes through a translucent label
constexpr double kShell = 0.2;    // chosen: the opacity of a voxel at its surface, which is shaded

// Calls use(i, next) for each pair of neighbouring voxels.
template <typename Use>
void for_each_pair(const Dims& dims, const Use& use) {
  const std::array<std::size_t, 3> strides{1, static_cast<std::size_t>(dims[0]), voxels_of({dims[0], dims[1], 1})};
  each_voxel(dims, [&](const Dims& at, std::size_t i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (at[axis] + 1 < dims[axis]) use(i, i + strides[axis]);
    }
  });
}

// The number of faces between voxels of two labels, by both labels.
using Contacts = std::vector<std::map<std::uint16_t, std::size_t>>;
Contacts contacts_of(const SceneSetup& setup) {
  Contacts contacts(setup.label_values.size());
  for_each_pair(setup.volume.dims, [&](std::size_t i, std::size_t next) {
    const std::uint16_t a = setup.labels[i], b = setup.labels[next];
    if (a == b) return;
    ++contacts[a][b];
    ++contacts[b][a];
  });
  return contacts;
}

// Labels in the order of their number of neighbours: each gets the tag that is rarest among its neighbours.
std::vector<std::uint8_t> tags_of(const Contacts& contacts) {
  const std::size_t count = contacts.size();
  std::vector<std::uint8_t> tags(count);
  if (count <= kTags + 1) {
    for (std::size_t label = 1; label < count; ++label) tags[label] = static_cast<std::uint8_t>(label - 1);
    return tags;
  }
  std::vector<std::size_t> order;
  for (std::size_t label = 1; label < count; ++label) order.push_back(label);
  std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t label) { return contacts[label].size(); });
  std::vector<bool> done(count);
  std::array<std::size_t, kTags> used{};
  for (const std::size_t label : order) {
    std::array<std::size_t, kTags> touched{};
    for (const auto& [other, faces] : contacts[label]) {
      if (done[other]) touched[tags[other]] += faces;
    }
    std::size_t best = 0;
    for (std::size_t tag = 1; tag < kTags; ++tag) {
      if (std::pair(touched[tag], used[tag]) < std::pair(touched[best], used[best])) best = tag;
    }
    tags[label] = static_cast<std::uint8_t>(best);
    ++used[best];
    done[label] = true;
  }
  return tags;
}

// The opacities of a voxel by label: below 1 for labels that enclose another, whose box is inside theirs on all sides.
std::vector<double> opacities_of(const SceneSetup& setup) {
  struct Extent {
    std::array<int, 3> low{INT32_MAX, INT32_MAX, INT32_MAX}, high{-1, -1, -1};
    double voxels = 0;

    bool holds(const Extent& other) const {
      bool all = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        all = all && other.low[axis] > low[axis] && other.high[axis] < high[axis];
      return all;
    }
    // The mean number of voxels along a line through it, for an ellipsoid in that box.
    double depth() const {
      double faces = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t next = (axis + 1) % 3;
        faces += (high[axis] - low[axis] + 1.0) * (high[next] - low[next] + 1.0);
      }
      return std::max(1.0, voxels / (std::numbers::pi / 4 * faces / 3));
    }
  };
  std::vector<Extent> extents(setup.label_values.size());
  each_voxel(setup.volume.dims, [&](const Dims& at, std::size_t i) {
    Extent& extent = extents[setup.labels[i]];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent.low[axis] = std::min(extent.low[axis], at[axis]);
      extent.high[axis] = std::max(extent.high[axis], at[axis]);
    }
    ++extent.voxels;
  });
  std::vector<double> opacities(extents.size(), 1);
  for (std::size_t outer = 1; outer < extents.size(); ++outer) {
    for (std::size_t inner = 1; inner < extents.size(); ++inner) {
      if (extents[outer].holds(extents[inner])) opacities[outer] = 1 - std::pow(kThrough, 1 / extents[outer].depth());
    }
  }
  return opacities;
}

// Finds the labels among the values, in increasing order after the background, which is 0 or otherwise the lowest.
void find_labels(SceneSetup& setup) {
  const Volume& volume = setup.volume;
  with_sample(volume.type, [&](auto sample) {
    using Sample = decltype(sample);
    std::map<Sample, std::uint16_t> places;
    const std::size_t count = voxels_of(volume.dims);
    for (std::size_t i = 0; i < count; ++i) places.try_emplace(sample_at<Sample>(volume.samples, i), 0);
    const Sample background = places.contains(Sample{0}) ? Sample{0} : places.begin()->first;
    setup.label_values = {static_cast<double>(background)};
    for (auto& [value, place] : places) {
      if (value == background) continue;
      place = static_cast<std::uint16_t>(std::min<std::size_t>(setup.label_values.size(), 65535));
      setup.label_values.push_back(static_cast<double>(value));
    }
    setup.labels.resize(count);
    for (std::size_t i = 0; i < count; ++i) setup.labels[i] = places[sample_at<Sample>(volume.samples, i)];
  });
}

// Background voxels beside a label get its tag, because a sample between them uses the tag of the nearest voxel.
void tag_voxels(SceneSetup& setup, const std::vector<std::uint8_t>& tag_of) {
  const std::size_t count = setup.labels.size();
  setup.tags.assign(count, 0);
  std::vector<std::uint8_t> known(count);
  for (std::size_t i = 0; i < count; ++i) {
    known[i] = setup.labels[i] != 0 ? 1 : 0;
    setup.tags[i] = tag_of[setup.labels[i]];
  }
  for (std::uint8_t round = 2; round < 4; ++round) {
    for_each_pair(setup.volume.dims, [&](std::size_t i, std::size_t next) {
      const auto take = [&](std::size_t to, std::size_t from) {
        if (known[to] == 0 && known[from] != 0 && known[from] < round)
          known[to] = round, setup.tags[to] = setup.tags[from];
      };
      take(i, next);
      take(next, i);
    });
  }
}

}  // namespace

void colour_labels(SceneSetup& setup) {
  if (setup.volume.planes) return;
  find_labels(setup);
  const Contacts contacts = contacts_of(setup);
  const std::vector<std::uint8_t> tag_of = tags_of(contacts);
  tag_voxels(setup, tag_of);

  const std::size_t count = setup.label_values.size() - 1;
  const std::vector<double> opacities = count <= kTags ? opacities_of(setup) : std::vector<double>(count + 1, 1);
  const bool is_mask = count == 1;
  setup.built_in.materials.clear();
  std::vector<std::string> names;
  for (std::size_t tag = 0; tag < std::min(count, kTags); ++tag) {
    const bool translucent = opacities[tag + 1] < 1;
    const auto& [name, colour] = kColours[tag];
    setup.built_in.materials.push_back({{{{0, colour}}, {{110, 0}, {146, 1}}}});
    if (translucent)
      setup.built_in.materials.back().function.opacities = {
          {110, 0}, {146, kShell}, {220, kShell}, {250, opacities[tag + 1]}};
    names.push_back(fmt::format("{} {}{}", setup.label_values[tag + 1], name, translucent ? " (translucent)" : ""));
  }
  if (count <= kTags && !is_mask) setup.look_why += fmt::format("; {}", fmt::join(names, ", "));
  if (count > kTags)
    setup.look_why += fmt::format("; {} labels in four colours, so that those that touch differ", count);

  Volume& volume = setup.volume;
  volume.type = SampleType::kUint8;
  volume.range = ValueRange{0, 255};
  volume.samples.assign(setup.labels.size(), std::byte{0});
  for (std::size_t i = 0; i < setup.labels.size(); ++i) {
    if (setup.labels[i] != 0) volume.samples[i] = std::byte{255};
  }
}

}  // namespace gicube::scene
