// How far a ray may go without a look at what lies between: cubes of cells in which there is nothing.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "gicube/vector.h"

namespace gicube::reference::paths {

class EmptySpace {
 public:
  EmptySpace() = default;
  // A flag a cell, x fastest, other than 0 where there is something.
  EmptySpace(const std::array<int, 3>& cells, std::vector<std::uint8_t> something) : cells_(cells) {
    reach_ = std::move(something);
    for (std::uint8_t& cell : reach_) cell = cell != 0 ? 0 : kFarthest;
    for (std::size_t axis = 0; axis < 3; ++axis) spread(axis);
  }

  // Where on a ray (all in cells) the empty cube round the cell at `distance` ends: not beyond `distance` if that cell
  // is not empty.
  double leave(const std::array<double, 3>& from, const std::array<double, 3>& step, double distance) const {
    std::array<int, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell[axis] = std::clamp(static_cast<int>(std::floor(from[axis] + distance * step[axis])), 0, cells_[axis] - 1);
    }
    const int reach = reach_[index(cell)];
    if (reach == 0) return distance;
    double end = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (step[axis] == 0) continue;
      const int face = step[axis] > 0 ? cell[axis] + reach : cell[axis] - reach + 1;
      end = std::min(end, (face - from[axis]) / step[axis]);
    }
    return end;
  }

 private:
  static constexpr std::uint8_t kFarthest = 255;

  std::size_t index(const std::array<int, 3>& cell) const {
    return static_cast<std::size_t>((cell[2] * cells_[1] + cell[1]) * cells_[0] + cell[0]);
  }
  // Chebyshev's distance, the number of cells to the nearest that is not empty, axis by axis. max(|i - j|, r[j]) has
  // its least over j where a cube of r about i has something: 255 tries at most, and as few as the result.
  void spread(std::size_t axis) {
    const std::vector<std::uint8_t> before = reach_;
    std::array<int, 3> cell{};
    for (cell[2] = 0; cell[2] < cells_[2]; ++cell[2]) {
      for (cell[1] = 0; cell[1] < cells_[1]; ++cell[1]) {
        for (cell[0] = 0; cell[0] < cells_[0]; ++cell[0]) {
          int least = before[index(cell)];
          for (int off = 1; off < least; ++off) {
            for (const int sign : {-1, 1}) {
              std::array<int, 3> other = cell;
              other[axis] += sign * off;
              if (other[axis] < 0 || other[axis] >= cells_[axis]) continue;
              least = std::min(least, std::max<int>(off, before[index(other)]));
            }
          }
          reach_[index(cell)] = static_cast<std::uint8_t>(least);
        }
      }
    }
  }

  std::array<int, 3> cells_{};
  std::vector<std::uint8_t> reach_;
};

}  // namespace gicube::reference::paths
