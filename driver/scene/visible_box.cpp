#include "gicube/scene/scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "scene/common/cells.h"
#include "scene/formats/plane_file.h"

namespace gicube::scene {
namespace {

constexpr double kVisible = 0.005;   // chosen: opacity of one voxel that is visible as haze over many
constexpr std::size_t kBins = 4096;  // as the board's densities
constexpr int kEdge = 4;             // voxels of a cell
constexpr int kLeast = 5;            // chosen: the least number of visible voxels in a cell; a wire of one voxel has 4
constexpr double kPiece =
    0.1;  // chosen: smaller pieces, relative to the largest one's voxels, may be outside the picture

// Visible voxels of a cell, and the box around them.
struct Cell {
  std::array<std::uint16_t, 3> low{}, high{};
  std::uint8_t count = 0;
};

using Box = std::array<std::array<int, 3>, 2>;

class Pieces {
 public:
  explicit Pieces(const Dims& dims) : across_{(dims[0] + 3) / kEdge, (dims[1] + 3) / kEdge, (dims[2] + 3) / kEdge} {
    cells_.resize(voxels_of(across_));
  }

  // Adds the visible ones of the four voxels along x from `first` on, the first of their cell: a bit for each.
  void add(const Dims& first, unsigned visible) {
    if (visible == 0) return;
    Cell& cell = cells_[index_of(across_, {first[0] / kEdge, first[1] / kEdge, first[2] / kEdge})];
    Dims low = first, high = first;
    low[0] += std::countr_zero(visible);
    high[0] += std::bit_width(visible) - 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto from = static_cast<std::uint16_t>(low[axis]), to = static_cast<std::uint16_t>(high[axis]);
      cell.low[axis] = cell.count == 0 ? from : std::min(cell.low[axis], from);
      cell.high[axis] = cell.count == 0 ? to : std::max(cell.high[axis], to);
    }
    cell.count = static_cast<std::uint8_t>(cell.count + std::popcount(visible));
  }

  // The box around the larger pieces; empty (low above high) if nothing is visible.
  Box box() {
    std::vector<std::pair<std::size_t, Box>> pieces;  // voxels
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (cells_[i].count >= kLeast) pieces.push_back(piece_at(i));
    }
    std::size_t most = 0;
    for (const auto& [voxels, box] : pieces) most = std::max(most, voxels);
    Box all = kNothing;
    for (const auto& [voxels, box] : pieces) {
      if (static_cast<double>(voxels) >= kPiece * static_cast<double>(most)) join(all, box[0], box[1]);
    }
    if (!pieces.empty()) return all;
    for (const Cell& cell : cells_) {
      if (cell.count > 0) join(all, cell.low, cell.high);
    }
    return all;
  }

 private:
  static constexpr Box kNothing{{{INT32_MAX, INT32_MAX, INT32_MAX}, {-1, -1, -1}}};

  template <typename Corner>
  static void join(Box& box, const Corner& low, const Corner& high) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box[0][axis] = std::min<int>(box[0][axis], low[axis]);
      box[1][axis] = std::max<int>(box[1][axis], high[axis]);
    }
  }

  // Removes the cells that are connected with this one, also by corners; returns their voxels and box.
  std::pair<std::size_t, Box> piece_at(std::size_t first) {
    std::size_t voxels = 0;
    Box box = kNothing;
    std::vector<std::size_t> open;
    const auto take = [&](std::size_t i) {
      if (cells_[i].count == 0) return;
      if (cells_[i].count < kLeast) return join(box, cells_[i].low, cells_[i].high);  // its last tip
      voxels += cells_[i].count;
      join(box, cells_[i].low, cells_[i].high);
      cells_[i].count = 0;
      open.push_back(i);
    };
    take(first);
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      const auto row = static_cast<std::size_t>(across_[0]), slice = row * static_cast<std::size_t>(across_[1]);
      const std::array<int, 3> at{static_cast<int>(i % row), static_cast<int>(i % slice / row),
                                  static_cast<int>(i / slice)};
      for (int z = std::max(at[2] - 1, 0); z <= std::min(at[2] + 1, across_[2] - 1); ++z) {
        for (int y = std::max(at[1] - 1, 0); y <= std::min(at[1] + 1, across_[1] - 1); ++y) {
          for (int x = std::max(at[0] - 1, 0); x <= std::min(at[0] + 1, across_[0] - 1); ++x)
            take(index_of(across_, {x, y, z}));
        }
      }
    }
    return {voxels, box};
  }

  Dims across_;
  std::vector<Cell> cells_;
};

}  // namespace

SceneBox whole_box(const Dims& dims) { return {{}, {dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0}}; }

SceneBox visible_box(const Volume& volume, const TransferFunctionFile& file) {
  const Dims& dims = volume.dims;
  const ValueRange range = value_range_of(volume);
  if (!(range.low < range.high)) return whole_box(dims);
  const TransferFunction function = in_values_of(range, file);
  std::vector<char> visible(kBins);
  for (std::size_t i = 0; i < kBins; ++i) {
    const double value = range.low + (range.high - range.low) * static_cast<double>(i) / (kBins - 1);
    visible[i] = function.opacity_at(value) > kVisible;
  }
  const double scale = (kBins - 1) / (range.high - range.low);
  const auto seen = [&](double value) {
    const double bin = std::clamp((value - range.low) * scale, 0.0, kBins - 1.0);
    return bin >= 0 && visible[static_cast<std::size_t>(bin)] != 0;  // false for NaNs
  };

  Pieces pieces(dims);
  with_sample(volume.type, [&](auto type) {
    using Sample = decltype(type);
    const auto each_row = [&](const auto& is_seen) {
      for_each_plane(volume, [&](int z, std::span<const std::byte> samples) {
        std::size_t index = 0;
        for (int y = 0; y < dims[1]; ++y) {
          for (int x = 0; x < dims[0]; x += kEdge) {
            const auto bits = [&](int count) {
              unsigned out = 0;
              for (int i = 0; i < count; ++i, ++index)
                out |= static_cast<unsigned>(is_seen(sample_at<Sample>(samples, index))) << i;
              return out;
            };
            pieces.add({x, y, z}, dims[0] - x >= kEdge ? bits(kEdge) : bits(dims[0] - x));
          }
        }
      });
    };
    if constexpr (sizeof(Sample) <= 2) {  // a table of all values
      using Index = std::make_unsigned_t<Sample>;
      std::vector<char> table(std::size_t{1} << (8 * sizeof(Sample)));
      for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = static_cast<char>(seen(static_cast<Sample>(static_cast<Index>(i))));
      each_row([&table](Sample sample) { return table[static_cast<Index>(sample)]; });
    } else {
      each_row([&seen](Sample sample) { return seen(static_cast<double>(sample)); });
    }
  });
  const auto [low, high] = pieces.box();
  if (high[0] < 0) return whole_box(dims);
  const auto below = [&low](std::size_t axis) { return std::max(low[axis] - 1.0, 0.0); };
  const auto above = [&](std::size_t axis) { return std::min(high[axis] + 1.0, dims[axis] - 1.0); };
  return {{below(0), below(1), below(2)}, {above(0), above(1), above(2)}};
}

}  // namespace gicube::scene
