#include "form_factors/exchange/elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"

namespace gicube::samples {
namespace {

constexpr int kDensityMax = 4095;
constexpr double kOpacityOne = 65535;  // of the board's segmentation table

double opacity_of(double max_kappa, int density) { return 1 - std::exp(-max_kappa * density / kDensityMax); }

// The extinction of a density in the board's table.
std::vector<double> table(double max_kappa) {
  std::vector<double> kappas;
  for (int density = 0; density <= kDensityMax; ++density) {
    kappas.push_back(-std::log1p(-std::round(opacity_of(max_kappa, density) * kOpacityOne) / kOpacityOne));
  }
  return kappas;
}

// The opacity at the edge of a scene's solid belongs to its surface, which has faces.
bool is_edge(const SceneSetup& setup, std::size_t tag) {
  return tag < setup.looks.size() && std::holds_alternative<SolidLook>(setup.looks[tag]);
}

// A fog's extinction. Its voxels beside solids may have more, to compensate for missing ones
// (gicube/scene/voxeliser.h); here a solid ends with its voxels.
double thickest(const SceneSetup& setup, std::size_t tag) {
  const auto* fog = tag < setup.looks.size() ? std::get_if<FogLook>(&setup.looks[tag]) : nullptr;
  return fog != nullptr ? fog->extinction * setup.grid.voxel : std::numeric_limits<double>::infinity();
}

// Calls visit(index) for a voxel and those around it.
template <typename Visit>
void around(const Medium& medium, const GridCell& cell, const Visit& visit) {
  GridCell first, end;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first[axis] = std::max(cell[axis] - 1, 0);
    end[axis] = std::min(cell[axis] + 2, medium.dims[axis]);
  }
  for_each_voxel(first, end, [&](const GridCell& beside) { visit(medium.at(beside)); });
}

// Open voxels with a solid's tag, and those beside them, become the densest fog around.
void bring_fog_to_solids(Medium& medium, const SceneSetup& setup) {
  const auto fog = [](const MaterialLook& look) { return std::holds_alternative<FogLook>(look); };
  if (std::ranges::none_of(setup.looks, fog)) return;
  constexpr int kVoxels = 2;  // of an edge's open part
  const std::vector<std::uint8_t> own_tags = medium.tags;
  for (int round = 0; round < kVoxels; ++round) {
    const std::vector<std::uint8_t> tags = medium.tags;
    const std::vector<double> kappa = medium.kappa;
    for_each_voxel({}, medium.dims, [&](const GridCell& cell) {
      const std::size_t at = medium.at(cell);
      bool edge = false;
      around(medium, cell, [&](std::size_t near) { edge = edge || is_edge(setup, own_tags[near]); });
      if (medium.solid[at] != 0 || !edge) return;
      around(medium, cell, [&](std::size_t near) {
        if (!std::isfinite(thickest(setup, tags[near])) || kappa[near] <= medium.kappa[at]) return;
        medium.kappa[at] = kappa[near];
        medium.tags[at] = tags[near];
      });
    });
  }
}

// A solid voxel beside open ones has their mean, so that interpolation between them is as in the open.
void continue_into_solids(Medium& medium) {
  const std::vector<std::uint16_t> open = medium.densities;
  const auto& dims = medium.dims;
  for_each_voxel({}, dims, [&](const GridCell& cell) {
    const std::size_t at = medium.at(cell);
    if (medium.solid[at] == 0) return;
    unsigned sum = 0, count = 0;
    around(medium, cell, [&](std::size_t near) {
      if (medium.solid[near] == 0) sum += open[near], ++count;
    });
    medium.densities[at] = static_cast<std::uint16_t>(count > 0 ? (sum + count / 2) / count : 0);
  });
}

}  // namespace

Medium make_medium(const SceneSetup& setup, double solid_opacity) {
  if (!(solid_opacity > 0 && solid_opacity <= 1)) {
    throw InputError("settings.solid_opacity", "more than 0, at most 1", fmt::format("{}", solid_opacity));
  }
  const Volume& volume = setup.volume;
  Medium medium;
  medium.dims = volume.dims;
  const std::size_t voxels = medium.at({0, 0, volume.dims[2]});
  if (voxels == 0 || volume.samples.size() != voxels * bytes_per_sample(volume.type)) {
    throw InputError("setup.volume", "its voxels", fmt::format("{} bytes", volume.samples.size()));
  }
  const Vec3 s = volume.spacing;
  const double smallest = 1 / std::min({s.x, s.y, s.z});
  medium.edges = {smallest * s.x, smallest * s.y, smallest * s.z};
  medium.tags = setup.tags.empty() ? std::vector<std::uint8_t>(voxels) : setup.tags;
  medium.solid.resize(voxels);
  medium.densities.resize(voxels);
  medium.kappa.resize(voxels);

  const ValueRange range = value_range_of(volume);
  Materials materials = setup.materials;
  for (TransferFunctionFile& material : materials) material = {in_values_of(range, material)};
  const std::vector<float> values = values_of(volume);
  for (std::size_t i = 0; i < voxels; ++i) {
    const std::size_t tag = medium.tags[i];
    const double value = std::clamp(double{values[i]}, range.low, range.high);
    const double opacity = tag < materials.size() ? materials[tag].function.opacity_at(value) : 0;
    medium.solid[i] = opacity >= solid_opacity ? 1 : 0;
    if (medium.solid[i] != 0 || is_edge(setup, tag)) continue;
    medium.kappa[i] = std::min(-std::log1p(-opacity), thickest(setup, tag));
  }
  bring_fog_to_solids(medium, setup);
  medium.max_kappa = std::ranges::max(medium.kappa);
  if (medium.max_kappa > 0) {
    const double scale = kDensityMax / medium.max_kappa;
    for (std::size_t i = 0; i < voxels; ++i) {
      medium.densities[i] = static_cast<std::uint16_t>(std::lround(scale * medium.kappa[i]));
    }
  }
  continue_into_solids(medium);
  const std::vector<double> kappas = table(medium.max_kappa);
  for (std::size_t i = 0; i < voxels; ++i) medium.kappa[i] = kappas[medium.densities[i]];
  return medium;
}

void load(Board& board, const Medium& medium) {
  TransferFunction fog{{{0, {1, 1, 1}}}, {}};
  for (int density = 0; density <= kDensityMax; ++density) {
    fog.opacities.push_back({static_cast<double>(density), opacity_of(medium.max_kappa, density)});
  }
  board.set_transfer_function(fog, 0);
  board.set_transfer_function({{{0, {1, 1, 1}}}, {{0, 1}}}, 1);
  board.load_volume({.samples = std::as_bytes(std::span(medium.densities)),
                     .type = SampleType::kUint12,
                     .dims = medium.dims,
                     .spacing = {medium.edges[0], medium.edges[1], medium.edges[2]},
                     .tags = medium.solid});
}

double mean_kappa(const Medium& medium, const GridCell& voxel) {
  // Means of the interpolation's three weights over half a voxel on both sides, or on one side at an end.
  std::array<std::array<double, 3>, 3> weights;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool first = voxel[axis] == 0, last = voxel[axis] == medium.dims[axis] - 1;
    weights[axis] = {first ? 0 : last ? 0.25 : 0.125, 0.75, last ? 0 : first ? 0.25 : 0.125};
  }
  double sum = 0;
  for_each_voxel({}, {3, 3, 3}, [&](const GridCell& beside) {
    double weight = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) weight *= weights[axis][static_cast<std::size_t>(beside[axis])];
    if (weight == 0) return;
    sum += weight *
           medium.kappa[medium.at({voxel[0] + beside[0] - 1, voxel[1] + beside[1] - 1, voxel[2] + beside[2] - 1})];
  });
  return sum;
}

Contents::Contents(const Medium& medium)
    : dims_(medium.dims), ends_{medium.dims[0] + 1, medium.dims[1] + 1, medium.dims[2] + 1} {
  sums_.resize(voxel_index(ends_, {0, 0, ends_[2]}));
  Sums row{};
  for_each_voxel({}, dims_, [&](const GridCell& cell) {
    const auto [x, y, z] = cell;
    const std::size_t at = medium.at(cell);
    const double kappa = medium.kappa[at];
    const Sums here{static_cast<double>(medium.solid[at]), kappa, kappa * kappa};
    Sums& sums = sums_[voxel_index(ends_, {x + 1, y + 1, z + 1})];
    if (x == 0) row = {};
    for (std::size_t i = 0; i < here.size(); ++i) {
      row[i] += here[i];
      sums[i] = row[i] + before({x + 1, y, z + 1})[i] + before({x + 1, y + 1, z})[i] - before({x + 1, y, z})[i];
    }
  });
}

Contents::Of Contents::box(const std::array<double, 3>& low, const std::array<double, 3>& high) const {
  std::array<int, 3> first, last;  // a voxel is half of one around its centre
  double voxels = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first[axis] = std::clamp(static_cast<int>(std::floor(low[axis] + 0.5)), 0, dims_[axis] - 1);
    last[axis] = std::clamp(static_cast<int>(std::ceil(high[axis] - 0.5)), first[axis], dims_[axis] - 1) + 1;
    voxels *= last[axis] - first[axis];
  }
  Sums sums{};
  for (int corner = 0; corner < 8; ++corner) {
    const auto end = [&](std::size_t axis) { return (corner >> axis & 1) != 0 ? last[axis] : first[axis]; };
    const Sums& part = before({end(0), end(1), end(2)});
    const bool odd = ((corner ^ corner >> 1 ^ corner >> 2) & 1) != 0;
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += odd ? part[i] : -part[i];
  }
  const double mean = sums[1] / voxels;
  return {sums[0] > 0.5, mean, std::sqrt(std::max(sums[2] / voxels - mean * mean, 0.0))};
}

}  // namespace gicube::samples
