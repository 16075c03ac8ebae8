// What no caller should pass: NULL everywhere, records of other versions, boards that are none.
#include "c_board.h"

namespace gicube::c_api_test {
namespace {

class CArguments : public CApi {};

TEST(CArgumentsWithoutABoard, AreRefusedAndWriteNothing) {
  std::uint64_t value = 7;
  EXPECT_REFUSED(gicube_now(nullptr, &value), "board");
  EXPECT_EQ(value, 7u);
  EXPECT_REFUSED(gicube_host_compute(nullptr, 1), "board");
  EXPECT_REFUSED(gicube_set_time_limit(nullptr, 1), "board");
  EXPECT_REFUSED(gicube_reopen(nullptr, nullptr), "board");
  EXPECT_EQ(gicube_last_loss(), GICUBE_LOSS_NONE);
  EXPECT_REFUSED(gicube_get_info(nullptr, nullptr), "board");
  EXPECT_REFUSED(gicube_load_volume(nullptr, nullptr, nullptr, nullptr), "board");
  EXPECT_REFUSED(gicube_value_range(nullptr, nullptr, nullptr), "low");
  EXPECT_REFUSED(gicube_read_volume(nullptr, nullptr, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_write_volume(nullptr, nullptr, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_set_transfer_function(nullptr, 0, nullptr, 0, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_set_shading(nullptr, nullptr), "board");
  EXPECT_REFUSED(gicube_set_material(nullptr, 0, nullptr), "board");
  EXPECT_REFUSED(gicube_set_scattering_routine(nullptr, nullptr, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_set_gradient_codebook(nullptr, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_get_blocks(nullptr, nullptr), "blocks");
  EXPECT_REFUSED(gicube_set_empty_flags(nullptr, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_get_empty_flags(nullptr, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_illuminate(nullptr, nullptr, 0, nullptr, nullptr, nullptr, nullptr), "board");
  EXPECT_REFUSED(gicube_read_irradiance(nullptr, nullptr, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_write_irradiance(nullptr, nullptr, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_clear_irradiance(nullptr, 1), "board");
  EXPECT_REFUSED(gicube_clear_sums(nullptr, 1), "board");
  EXPECT_REFUSED(gicube_render_to_framebuffer(nullptr, nullptr, nullptr, nullptr), "board");
  EXPECT_REFUSED(gicube_get_framebuffer_size(nullptr, nullptr, nullptr), "board");
  EXPECT_REFUSED(gicube_read_framebuffer(nullptr, nullptr, 0), "board");
  EXPECT_REFUSED(gicube_render(nullptr, nullptr, nullptr, 0, nullptr, nullptr), "board");
  EXPECT_REFUSED(gicube_submit(nullptr, nullptr, 0, nullptr, nullptr), "ticket");
  EXPECT_REFUSED(gicube_submit_gather(nullptr, nullptr, 0, nullptr, nullptr), "ticket");
  EXPECT_REFUSED(gicube_receive(nullptr, 1, 0, nullptr, 0, nullptr), "board");
  EXPECT_REFUSED(gicube_poll(nullptr, nullptr), "board");
  EXPECT_REFUSED(gicube_cancel(nullptr, 1, nullptr), "cancelled");
  EXPECT_REFUSED(gicube_get_counters(nullptr, nullptr), "list");
  EXPECT_REFUSED(gicube_counters_value(nullptr, "x", &value), "list");
  EXPECT_REFUSED(gicube_counters_at(nullptr, 0, nullptr, nullptr, nullptr), "list");
  EXPECT_EQ(gicube_lighting_warning(nullptr, 0), nullptr);
  EXPECT_EQ(gicube_why_invisible(nullptr), nullptr);
  gicube_close(nullptr);
}

TEST(CArgumentsWithoutABoard, OpeningGivesNoBoardUnlessItSucceeds) {
  gicube_board* board = reinterpret_cast<gicube_board*>(8);
  EXPECT_REFUSED(gicube_open("emu:", nullptr, nullptr), "board");
  EXPECT_REFUSED(gicube_open(nullptr, nullptr, &board), "uri");
  EXPECT_EQ(board, nullptr);
  EXPECT_REFUSED(gicube_open("isa:", nullptr, &board), "URI");
  EXPECT_EQ(gicube_open("unix:/there/is/no/board", nullptr, &board), GICUBE_OPEN_FAILED);
  EXPECT_STREQ(gicube_last_error_field(), "");
  EXPECT_THAT(gicube_last_error(), HasSubstr("/there/is/no/board"));
  gicube_open_options options;
  ASSERT_OK(gicube_open_options_init(&options, sizeof options));
  options.back_pressure = 2;
  EXPECT_REFUSED(gicube_open("emu:", &options, &board), "options.back_pressure");
  options.back_pressure = GICUBE_BACK_PRESSURE_WAIT;
  options.force = 2;
  EXPECT_REFUSED(gicube_open("emu:", &options, &board), "options.force");
  EXPECT_EQ(board, nullptr);
}

TEST(CArgumentsWithoutABoard, ErrorsAreTheThreadsOwn) {
  EXPECT_REFUSED(gicube_host_compute(nullptr, 1), "board");
  std::string seen = "?";
  std::thread([&] { seen = gicube_last_error(); }).join();
  EXPECT_EQ(seen, "");
  EXPECT_STREQ(gicube_status_name(GICUBE_INTERNAL), "GICUBE_INTERNAL");
  EXPECT_STREQ(gicube_status_name(GICUBE_WOULD_BLOCK), "GICUBE_WOULD_BLOCK");
  EXPECT_STREQ(gicube_status_name(-1), "?");
  EXPECT_STREQ(gicube_status_name(1000), "?");
}

TEST(CRecord, OfNoVersionIsRefused) {
  gicube_view view;
  EXPECT_REFUSED(gicube_view_init(nullptr, sizeof view), "view");
  EXPECT_REFUSED(gicube_view_init(&view, offsetof(gicube_view, lamps) - 1), "view.size");
  EXPECT_REFUSED(gicube_view_init(&view, 1 << 20), "view.size");
  EXPECT_REFUSED(gicube_view_init(&view, 0), "view.size");
}

// A caller of a later version has fields that this library does not know.
struct LaterView {
  gicube_view view;
  std::uint64_t more[3];
};

TEST_F(CArguments, ALaterRecordIsTakenIfItsNewFieldsAreZero) {
  LaterView later;
  std::memset(static_cast<void*>(&later), 0xFF, sizeof later);
  ASSERT_OK(gicube_view_init(&later.view, sizeof later));
  EXPECT_EQ(later.view.size, sizeof later);
  EXPECT_EQ(later.more[2], 0u);
  EXPECT_EQ(gicube_render_to_framebuffer(board_, &later.view, nullptr, nullptr), GICUBE_BAD_ARGUMENT);  // no eye yet
  EXPECT_STRNE(gicube_last_error_field(), "view.size");
  later.more[1] = 1;
  EXPECT_REFUSED(gicube_render_to_framebuffer(board_, &later.view, nullptr, nullptr), "view");

  struct {
    gicube_board_info info;
    std::uint64_t more;
  } info;
  std::memset(static_cast<void*>(&info), 0xFF, sizeof info);
  info.info.size = sizeof info;
  ASSERT_OK(gicube_get_info(board_, &info.info));
  EXPECT_EQ(info.info.processors, 4);
  EXPECT_EQ(info.info.size, sizeof info);
  EXPECT_EQ(info.more, 0u);
}

TEST_F(CArguments, OfEveryRecordAreCheckedByName) {
  gicube_volume volume;
  ASSERT_OK(gicube_volume_init(&volume, sizeof volume));
  EXPECT_REFUSED(gicube_load_volume(board_, nullptr, nullptr, nullptr), "volume");
  EXPECT_REFUSED(gicube_load_volume(board_, &volume, nullptr, nullptr), "volume.samples");
  volume.type = 5;
  EXPECT_REFUSED(gicube_load_volume(board_, &volume, nullptr, nullptr), "volume.type");
  volume.type = -1;
  EXPECT_REFUSED(gicube_load_volume(board_, &volume, nullptr, nullptr), "volume.type");
  const std::uint8_t samples[8] = {};
  ASSERT_OK(gicube_volume_init(&volume, sizeof volume));
  volume.samples = samples;
  volume.sample_bytes = 8;
  volume.dims[0] = volume.dims[1] = volume.dims[2] = 2;
  volume.tag_count = 8;
  EXPECT_REFUSED(gicube_load_volume(board_, &volume, nullptr, nullptr), "volume.tags");
  volume.tag_count = 0;
  volume.has_range = 2;
  EXPECT_REFUSED(gicube_load_volume(board_, &volume, nullptr, nullptr), "volume.has_range");
  volume.find_gradients = 2;
  EXPECT_REFUSED(gicube_load_volume(board_, &volume, nullptr, nullptr), "volume.find_gradients");

  gicube_material material;
  ASSERT_OK(gicube_material_init(&material, sizeof material));
  material.parameter_count = 33;
  EXPECT_REFUSED(gicube_set_material(board_, 0, &material), "material.parameter_count");
  material.parameter_count = 1;
  EXPECT_REFUSED(gicube_set_material(board_, 0, &material), "material.parameters");
  material.bsdf = 7;
  EXPECT_REFUSED(gicube_set_material(board_, 0, &material), "material.bsdf");

  gicube_view view;
  ASSERT_OK(gicube_view_init(&view, sizeof view));
  view.cut_plane_count = 1;
  EXPECT_REFUSED(gicube_render_to_framebuffer(board_, &view, nullptr, nullptr), "view.cut_planes");
  view.cut_plane_count = 0xFFFFFFFF;
  EXPECT_REFUSED(gicube_render_to_framebuffer(board_, &view, nullptr, nullptr), "view.cut_plane_count");
  view.cut_plane_count = 0;
  view.lamp_count = 1;
  EXPECT_REFUSED(gicube_render_to_framebuffer(board_, &view, nullptr, nullptr), "view.lamps");
  view.lamp_count = 33;
  EXPECT_REFUSED(gicube_render_to_framebuffer(board_, &view, nullptr, nullptr), "view.lamp_count");
  gicube_lamp lamps[2] = {};
  lamps[0].light = {GICUBE_LIGHT_SPHERE, 0, {0, 0, 90}, {}, {}, 5, 1};
  lamps[1].light.kind = 4;
  view.lamps = lamps;
  view.lamp_count = 2;
  EXPECT_REFUSED(gicube_render_to_framebuffer(board_, &view, nullptr, nullptr), "view.lamps[1].light.kind");
  lamps[1].light = {GICUBE_LIGHT_POINT, 0, {0, 0, 90}, {}, {}, 0, 1};
  view.look_at[2] = 1;
  EXPECT_REFUSED(gicube_render_to_framebuffer(board_, &view, nullptr, nullptr), "lamps[1].light");
  view.lamp_count = 0;
  view.filter = 2;
  EXPECT_REFUSED(gicube_render_to_framebuffer(board_, &view, nullptr, nullptr), "view.filter");
  EXPECT_REFUSED(gicube_render(board_, &view, nullptr, 0, nullptr, nullptr), "view.filter");

  EXPECT_REFUSED(gicube_set_transfer_function(board_, 0, nullptr, 1, nullptr, 0), "colours");
  std::uint32_t ticket = 5;
  EXPECT_REFUSED(gicube_submit(board_, nullptr, 1, nullptr, &ticket), "rays");
  EXPECT_EQ(ticket, 0u);
  EXPECT_REFUSED(gicube_submit(board_, reinterpret_cast<gicube_host_ray*>(8), SIZE_MAX, nullptr, &ticket), "rays");
  const gicube_ray_span span{nullptr, 3};
  EXPECT_REFUSED(gicube_submit_gather(board_, &span, 1, nullptr, &ticket), "spans[0].rays");
  gicube_ray_request request;
  ASSERT_OK(gicube_ray_request_init(&request, sizeof request));
  request.type = 7;
  const gicube_host_ray ray{};
  EXPECT_REFUSED(gicube_submit(board_, &ray, 1, &request, &ticket), "request.type");
  request.type = GICUBE_RAY_OPACITY;
  gicube_view sampled;
  ASSERT_OK(gicube_view_init(&sampled, sizeof sampled));
  sampled.cut_plane_count = 7;
  request.sampled_as = &sampled;
  EXPECT_REFUSED(gicube_submit(board_, &ray, 1, &request, &ticket), "request.sampled_as.cut_plane_count");
  request.sampled_as = nullptr;
}

TEST_F(CArguments, WhatNeedsAVolumeIsRejectedWithoutOne) {
  double low = 0, high = 0;
  EXPECT_EQ(gicube_value_range(board_, &low, &high), GICUBE_REJECTED);
  gicube_pixel pixel;
  EXPECT_EQ(gicube_read_framebuffer(board_, &pixel, 1), GICUBE_REJECTED);
  EXPECT_STREQ(gicube_last_error_field(), "");
  std::int32_t width = 5, height = 5;
  EXPECT_OK(gicube_get_framebuffer_size(board_, &width, &height));
  EXPECT_EQ(width, 0);
  EXPECT_EQ(height, 0);
}

}  // namespace
}  // namespace gicube::c_api_test
