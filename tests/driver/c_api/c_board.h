// A board opened by the C ABI, a volume for it, and the same by the C++ API.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "gicube/board.h"
#include "gicube/c_api.h"

namespace gicube::c_api_test {

inline constexpr int kEdge = 32;

inline std::vector<std::uint8_t> cube() {
  std::vector<std::uint8_t> voxels(std::size_t{kEdge} * kEdge * kEdge);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const std::size_t x = i % kEdge, y = i / kEdge % kEdge, z = i / (kEdge * kEdge);
    const auto inside = [](std::size_t v) { return v >= 8 && v < 24; };
    voxels[i] = inside(x) && inside(y) && inside(z) ? static_cast<std::uint8_t>(100 + 4 * x) : 0;
  }
  return voxels;
}

template <typename Record>
Record made(gicube_status (*init)(Record*, std::size_t)) {
  Record record;
  std::memset(static_cast<void*>(&record), 0xAA, sizeof record);
  EXPECT_EQ(init(&record, sizeof record), GICUBE_OK);
  EXPECT_EQ(record.size, sizeof record);
  return record;
}

class CApi : public testing::Test {
 protected:
  static void SetUpTestSuite() { setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1); }
  void SetUp() override { ASSERT_EQ(gicube_open("emu:", nullptr, &board_), GICUBE_OK) << gicube_last_error(); }
  void TearDown() override { gicube_close(board_); }

  gicube_volume volume() {
    gicube_volume record = made(gicube_volume_init);
    record.type = GICUBE_SAMPLE_UINT8;
    for (std::int32_t& edge : record.dims) edge = kEdge;
    record.samples = voxels_.data();
    record.sample_bytes = voxels_.size();
    return record;
  }
  gicube_status make_visible() {
    const gicube_colour_point colours[] = {{0, {1, 0.5, 0.25}}};
    const gicube_opacity_point opacities[] = {{90, 0}, {250, 0.3}};
    return gicube_set_transfer_function(board_, 0, colours, 1, opacities, 2);
  }
  void load() {
    const gicube_volume record = volume();
    ASSERT_EQ(gicube_load_volume(board_, &record, nullptr, nullptr), GICUBE_OK) << gicube_last_error();
    ASSERT_EQ(make_visible(), GICUBE_OK) << gicube_last_error();
  }
  gicube_view view() {
    gicube_view record = made(gicube_view_init);
    record.width = 40;
    record.height = 30;
    record.eye[0] = 70;
    record.eye[1] = 50;
    record.eye[2] = -40;
    for (double& axis : record.look_at) axis = 15.5;
    return record;
  }
  static std::vector<gicube_host_ray> rays(std::size_t count) {
    std::vector<gicube_host_ray> all(count);
    for (std::size_t i = 0; i < count; ++i) {
      all[i].id = static_cast<std::uint32_t>(1000 + i);
      all[i].position[0] = static_cast<double>(i % 31);
      all[i].position[1] = static_cast<double>(i / 31 % 31);
      all[i].direction[2] = 1;
    }
    return all;
  }

  gicube_board* board_ = nullptr;
  const std::vector<std::uint8_t> voxels_ = cube();
};

// The same calls by the C++ API on a board of its own.
inline Board twin(const std::vector<std::uint8_t>& voxels) {
  Board board = Board::open("emu:");
  board.load_volume({.samples = std::as_bytes(std::span(voxels)), .dims = {kEdge, kEdge, kEdge}});
  board.set_transfer_function({.colours = {{0, {1, 0.5, 0.25}}}, .opacities = {{90, 0}, {250, 0.3}}});
  return board;
}

}  // namespace gicube::c_api_test
