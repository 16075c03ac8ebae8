// What the tests of docs/studies/stability.md share: each shows a failure, holds its bound, and checks what
// the software does about it.
#pragma once

#include <cstdio>

#include "gicube/board.h"
#include "test.h"
#include "test_board.h"

namespace gicube::stability {

// Small blocks, so that small volumes have many.
inline constexpr std::string_view kSmallBlocks = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64";

inline std::string small_board(std::string_view more = "") { return std::string(kSmallBlocks) + std::string(more); }

// A number of docs/studies/stability.md: stability_test --gtest_output=json:FILE has all of them.
inline void record(const std::string& name, double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  testing::Test::RecordProperty(name, text);
}

// Words of the paper's formats, as the driver rounds what it is given: so a test can say where a ray's samples lie.
inline constexpr double kPositionOne = 16'384, kDirectionOne = 16'384, kStepOne = 65'536;

// A volume of one value, whose opacity a voxel is `opacity`. Nothing is shaded.
inline void load_fog(Board& board, const Dims& dims, double opacity) {
  const std::vector<std::byte> samples(
      static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(dims[2]),
      std::byte{100});
  board.load_volume({.samples = samples, .dims = dims});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, opacity}}});
}

inline double ratio(std::uint64_t a, std::uint64_t b) { return static_cast<double>(a) / static_cast<double>(b); }

}  // namespace gicube::stability
