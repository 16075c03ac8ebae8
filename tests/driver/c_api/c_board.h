// A board opened by the C ABI, a volume for it, and the same by the C++ API.
#pragma once

#include "gicube/board.h"
#include "gicube/c_api.h"
#include "test.h"

namespace gicube::c_api_test {

// The call was turned away, and the words begin with the argument's name.
#define EXPECT_REFUSED(call, name)                                   \
  do {                                                               \
    EXPECT_EQ((call), GICUBE_BAD_ARGUMENT) << #call;                 \
    EXPECT_STREQ(gicube_last_error_field(), name) << #call;          \
    EXPECT_THAT(gicube_last_error(), StartsWith(name ": expected")); \
  } while (false)

#define EXPECT_OK(call) EXPECT_EQ((call), GICUBE_OK) << gicube_last_error()
#define ASSERT_OK(call) ASSERT_EQ((call), GICUBE_OK) << gicube_last_error()

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
  EXPECT_OK(init(&record, sizeof record));
  EXPECT_EQ(record.size, sizeof record);
  return record;
}

class CApi : public testing::Test {
 protected:
  void SetUp() override { ASSERT_OK(gicube_open("emu:", nullptr, &board_)); }
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
    ASSERT_OK(gicube_load_volume(board_, &record, nullptr, nullptr));
    ASSERT_OK(make_visible());
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

// The view of CApi::view().
inline View twin_view() {
  View view;
  view.width = 40;
  view.height = 30;
  view.eye = {70, 50, -40};
  view.look_at = {15.5, 15.5, 15.5};
  return view;
}

inline void expect_same(const std::vector<gicube_pixel>& pixels, const Image& image) {
  ASSERT_EQ(pixels.size(), image.pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    ASSERT_EQ((Pixel{pixels[i].red, pixels[i].green, pixels[i].blue, pixels[i].alpha}), image.pixels[i]) << i;
  }
}

}  // namespace gicube::c_api_test
