// The C ABI does what the C++ API does, bit by bit, and turns wrong arguments away by their names.
#include "gicube/c_api.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>
#include <vector>

#include "gicube/board.h"
#include "temporary_directory.h"

namespace gicube {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr int kEdge = 32;

std::vector<std::uint8_t> cube() {
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
Board twin(const std::vector<std::uint8_t>& voxels) {
  Board board = Board::open("emu:");
  board.load_volume({.samples = std::as_bytes(std::span(voxels)), .dims = {kEdge, kEdge, kEdge}});
  board.set_transfer_function({.colours = {{0, {1, 0.5, 0.25}}}, .opacities = {{90, 0}, {250, 0.3}}});
  return board;
}

TEST_F(CApi, RendersTheBitsOfTheCppApiInTheSameTime) {
  load();
  const gicube_view record = view();
  std::vector<gicube_pixel> pixels(40 * 30);
  ASSERT_EQ(gicube_render(board_, &record, pixels.data(), pixels.size(), nullptr, nullptr), GICUBE_OK);
  Board board = twin(voxels_);
  View same;
  same.width = 40;
  same.height = 30;
  same.eye = {70, 50, -40};
  same.look_at = {15.5, 15.5, 15.5};
  const Image image = board.render(same);
  int visible = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Pixel pixel{pixels[i].red, pixels[i].green, pixels[i].blue, pixels[i].alpha};
    ASSERT_EQ(pixel, image.pixels[i]) << i;
    visible += pixel.alpha > 0;
  }
  EXPECT_GT(visible, 50);
  std::uint64_t now = 0;
  EXPECT_EQ(gicube_now(board_, &now), GICUBE_OK);
  EXPECT_EQ(now, board.now());
  std::int32_t width = 0, height = 0;
  EXPECT_EQ(gicube_get_framebuffer_size(board_, &width, &height), GICUBE_OK);
  EXPECT_EQ(width, 40);
  EXPECT_EQ(height, 30);
}

TEST_F(CApi, TracesTheRaysOfTheCppApi) {
  load();
  const auto given = rays(5000);
  std::uint32_t ticket = 0;
  ASSERT_EQ(gicube_submit(board_, given.data(), given.size(), nullptr, &ticket), GICUBE_OK) << gicube_last_error();
  std::vector<gicube_traced_ray> traced(given.size());
  gicube_batch_report report = made(gicube_batch_report_init);
  ASSERT_EQ(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, traced.data(), traced.size(), &report), GICUBE_OK)
      << gicube_last_error();
  EXPECT_EQ(report.ticket, ticket);
  EXPECT_EQ(report.rays, 5000u);
  EXPECT_EQ(report.deposited, 0);

  Board board = twin(voxels_);
  std::vector<HostRay> same;
  for (const gicube_host_ray& ray : given) {
    same.push_back({ray.id, {ray.position[0], ray.position[1], ray.position[2]}, {0, 0, 1}});
  }
  const RayBatch batch = board.receive(board.submit(same));
  for (std::size_t i = 0; i < traced.size(); ++i) {
    ASSERT_EQ(traced[i].id, batch.rays[i].id);
    ASSERT_EQ(traced[i].opacity, batch.rays[i].opacity);
    ASSERT_EQ(traced[i].position[2], batch.rays[i].position.z);
    ASSERT_EQ(traced[i].colour[1], batch.rays[i].colour[1]);
  }
  EXPECT_EQ(report.completed_ps, batch.completed);
}

TEST_F(CApi, AskedForRaysOfEveryTypeItPassesTheRequestOn) {
  load();
  auto given = rays(500);
  for (gicube_host_ray& ray : given) ray.length = 16, ray.energy = 10;
  gicube_ray_request request = made(gicube_ray_request_init);
  std::vector<gicube_traced_ray> whole(given.size()), half(given.size());
  std::uint32_t ticket = 0;
  for (const auto& [type, into] : {std::pair(GICUBE_RAY_INTEGRATE, &whole), std::pair(GICUBE_RAY_OPACITY, &half)}) {
    request.type = type;
    ASSERT_EQ(gicube_submit(board_, given.data(), given.size(), &request, &ticket), GICUBE_OK) << gicube_last_error();
    ASSERT_EQ(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, into->data(), into->size(), nullptr), GICUBE_OK);
  }
  const std::size_t middle = 12 * 31 + 12;
  EXPECT_GT(whole[middle].opacity, half[middle].opacity);
  EXPECT_GT(half[middle].opacity, 0);
  EXPECT_EQ(half[middle].colour[0], 0);

  ASSERT_EQ(gicube_clear_irradiance(board_, 0.5), GICUBE_OK) << gicube_last_error();
  request.type = GICUBE_RAY_DEPOSIT;
  ASSERT_EQ(gicube_submit(board_, given.data(), given.size(), &request, &ticket), GICUBE_OK) << gicube_last_error();
  gicube_batch_report report = made(gicube_batch_report_init);
  ASSERT_EQ(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, nullptr, 0, &report), GICUBE_OK) << gicube_last_error();
  EXPECT_EQ(report.deposited, 1);
  EXPECT_EQ(report.rays, 0u);
  EXPECT_GT(report.lighting.deposited, 0);
  std::vector<float> irradiance(voxels_.size());
  ASSERT_EQ(gicube_read_irradiance(board_, nullptr, irradiance.data(), irradiance.size()), GICUBE_OK);
  double sum = 0;
  for (const float value : irradiance) sum += value;
  EXPECT_NEAR(sum, report.lighting.deposited, 1e-3 * sum);
}

TEST_F(CApi, GathersRaysAndPolylines) {
  load();
  const auto given = rays(31);
  const gicube_ray_span spans[] = {{given.data(), 10}, {nullptr, 0}, {given.data() + 10, 21}};
  std::uint32_t ticket = 0;
  ASSERT_EQ(gicube_submit_gather(board_, spans, 3, nullptr, &ticket), GICUBE_OK) << gicube_last_error();
  std::vector<gicube_traced_ray> traced(31);
  ASSERT_EQ(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, traced.data(), 31, nullptr), GICUBE_OK);
  for (std::size_t i = 0; i < 31; ++i) EXPECT_EQ(traced[i].id, 1000 + i);

  const double points[] = {12, 12, 0, 12, 12, 16, 12, 12, 31};
  const gicube_polyline line{7, 0, points, 3};
  ASSERT_EQ(gicube_submit_polylines(board_, &line, 1, &ticket), GICUBE_OK) << gicube_last_error();
  ASSERT_EQ(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, traced.data(), 2, nullptr), GICUBE_OK)
      << gicube_last_error();
  EXPECT_GT(traced[1].opacity, traced[0].opacity);
  EXPECT_GT(traced[0].opacity, 0);
}

TEST(CRay, GoesFromOnePointToAnother) {
  const double from[] = {1, 2, 3}, to[] = {1, 2, 8};
  gicube_host_ray ray;
  ASSERT_EQ(gicube_ray_between(9, from, to, &ray), GICUBE_OK);
  EXPECT_EQ(ray.id, 9u);
  EXPECT_EQ(ray.position[2], 3);
  EXPECT_EQ(ray.length, 5);
  EXPECT_GT(ray.direction[2], 0);
  EXPECT_EQ(gicube_ray_between(9, nullptr, to, &ray), GICUBE_BAD_ARGUMENT);
}

TEST_F(CApi, PollTellsOfBatchesThatReceiveThenGives) {
  load();
  gicube_batch_report report = made(gicube_batch_report_init);
  ASSERT_EQ(gicube_poll(board_, &report), GICUBE_OK);
  EXPECT_EQ(report.ticket, 0u);
  const auto given = rays(100);
  std::uint32_t first = 0, second = 0;
  ASSERT_EQ(gicube_submit(board_, given.data(), 60, nullptr, &first), GICUBE_OK);
  ASSERT_EQ(gicube_submit(board_, given.data(), 40, nullptr, &second), GICUBE_OK);
  std::vector<gicube_traced_ray> traced(60);
  EXPECT_EQ(gicube_receive(board_, second, 1, traced.data(), 40, nullptr), GICUBE_DEADLINE_PASSED);
  ASSERT_EQ(gicube_host_compute(board_, 1'000'000'000), GICUBE_OK);
  ASSERT_EQ(gicube_poll(board_, &report), GICUBE_OK);
  EXPECT_EQ(report.ticket, first);
  EXPECT_EQ(report.rays, 60u);
  std::int32_t cancelled = 7;
  EXPECT_EQ(gicube_cancel(board_, first, &cancelled), GICUBE_OK);
  EXPECT_EQ(cancelled, 0);
  EXPECT_EQ(gicube_receive(board_, first, GICUBE_NO_DEADLINE, traced.data(), 59, nullptr), GICUBE_BAD_ARGUMENT);
  EXPECT_EQ(gicube_receive(board_, first, GICUBE_NO_DEADLINE, traced.data(), 60, nullptr), GICUBE_OK);
  EXPECT_EQ(traced[59].id, 1059u);
  EXPECT_EQ(gicube_receive(board_, first, GICUBE_NO_DEADLINE, traced.data(), 60, nullptr), GICUBE_BAD_ARGUMENT);
  ASSERT_EQ(gicube_poll(board_, &report), GICUBE_OK);
  EXPECT_EQ(report.ticket, second);
  EXPECT_EQ(gicube_receive(board_, second, GICUBE_NO_DEADLINE, traced.data(), 40, nullptr), GICUBE_OK);
  ASSERT_EQ(gicube_poll(board_, &report), GICUBE_OK);
  EXPECT_EQ(report.ticket, 0u);
}

TEST_F(CApi, ReadsAndWritesBoxesOfTheVolume) {
  load();
  double low = 1, high = 0;
  ASSERT_EQ(gicube_value_range(board_, &low, &high), GICUBE_OK);
  EXPECT_EQ(low, 0);
  EXPECT_EQ(high, 255);
  const gicube_box box{{9, 9, 9}, {2, 2, 1}};
  std::vector<float> values(4);
  ASSERT_EQ(gicube_read_volume(board_, &box, values.data(), 4), GICUBE_OK) << gicube_last_error();
  EXPECT_NEAR(values[0], 136, 0.1);
  EXPECT_NEAR(values[1], 140, 0.1);
  values = {0, 50, 100, 255};
  ASSERT_EQ(gicube_write_volume(board_, &box, values.data(), 4), GICUBE_OK) << gicube_last_error();
  std::vector<float> read(4);
  ASSERT_EQ(gicube_read_volume(board_, &box, read.data(), 4), GICUBE_OK);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(read[i], values[i], 0.1);
  EXPECT_EQ(gicube_read_volume(board_, &box, values.data(), 5), GICUBE_BAD_ARGUMENT);
  EXPECT_STREQ(gicube_last_error_field(), "count");
}

TEST_F(CApi, FindsTheFactorsOfPairsOfTheCppApi) {
  load();
  gicube_element elements[2] = {};
  for (gicube_element& element : elements) {
    element.kind = GICUBE_ELEMENT_PATCH;
    element.origin[0] = element.origin[1] = 10;
    element.u[0] = element.v[1] = 4;
  }
  elements[1].origin[2] = 31;
  std::swap(elements[1].u, elements[1].v);  // faces the first one
  const gicube_element_pair pair{0, 1, 5, 0};
  gicube_pair_request request = made(gicube_pair_request_init);
  request.rays = 64;
  gicube_pair_factor factor{};
  ASSERT_EQ(gicube_pair_factors(board_, elements, 2, &pair, 1, &request, nullptr, nullptr, &factor, 1), GICUBE_OK)
      << gicube_last_error();
  Board board = twin(voxels_);
  const std::vector<Element> same{{ElementKind::kPatch, {10, 10, 0}, {4, 0, 0}, {0, 4, 0}, {}},
                                  {ElementKind::kPatch, {10, 10, 31}, {0, 4, 0}, {4, 0, 0}, {}}};
  const std::vector<ElementPair> pairs{{0, 1, 5}};
  PairRequest how;
  how.rays = 64;
  const PairFactor expected = board.pair_factors(same, pairs, how).at(0);
  EXPECT_EQ(factor.transported, expected.transported);
  EXPECT_EQ(factor.geometric, expected.geometric);
  EXPECT_EQ(factor.standard_error, expected.standard_error);
  EXPECT_GT(factor.geometric, factor.transported);
  EXPECT_EQ(gicube_pair_factors(board_, elements, 2, &pair, 1, &request, nullptr, nullptr, &factor, 2),
            GICUBE_BAD_ARGUMENT);
  EXPECT_STREQ(gicube_last_error_field(), "count");
  elements[1].kind = 2;
  EXPECT_EQ(gicube_pair_factors(board_, elements, 2, &pair, 1, &request, nullptr, nullptr, &factor, 1),
            GICUBE_BAD_ARGUMENT);
  EXPECT_STREQ(gicube_last_error_field(), "elements[1].kind");
}

// The board dies with its 40th message; a new one has the volume again, and the rays that were under way.
TEST(CReopen, GoesOnOnANewBoardWithTheVolumeAndTheRaysThatWereUnderWay) {
  setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1);
  const reference::TemporaryDirectory folder;
  const std::string plan = folder.file("plan.textproto");
  std::ofstream(plan) << "fault { direction: up message: 40 kind: kill }\n";
  gicube_open_options options = made(gicube_open_options_init);
  options.keep_volume = 1;
  const std::string capture = folder.file("session.capture");
  options.capture = capture.c_str();
  gicube_board* board = nullptr;
  ASSERT_EQ(gicube_open(("emu:?faults=" + plan).c_str(), &options, &board), GICUBE_OK) << gicube_last_error();
  const std::vector<std::uint8_t> voxels = cube();
  gicube_volume volume = made(gicube_volume_init);
  volume.type = GICUBE_SAMPLE_UINT8;
  for (std::int32_t& edge : volume.dims) edge = kEdge;
  volume.samples = voxels.data();
  volume.sample_bytes = voxels.size();
  ASSERT_EQ(gicube_load_volume(board, &volume, nullptr, nullptr), GICUBE_OK) << gicube_last_error();
  gicube_host_ray ray{};
  ray.direction[2] = 1;
  gicube_traced_ray traced{};
  std::uint32_t ticket = 0;
  gicube_status status = GICUBE_OK;
  for (int i = 0; i < 100 && status == GICUBE_OK; ++i) {
    ray.id = static_cast<std::uint32_t>(i);
    status = gicube_submit(board, &ray, 1, nullptr, &ticket);
    if (status == GICUBE_OK) status = gicube_receive(board, ticket, GICUBE_NO_DEADLINE, &traced, 1, nullptr);
  }
  ASSERT_EQ(status, GICUBE_DEVICE_LOST);
  EXPECT_EQ(gicube_last_loss(), GICUBE_LOSS_CLOSED);
  gicube_reopened reopened{};
  ASSERT_EQ(gicube_reopen(board, &reopened), GICUBE_OK) << gicube_last_error();
  EXPECT_EQ(reopened.resumed, 0);
  EXPECT_EQ(reopened.volume, 1);
  ASSERT_EQ(gicube_receive(board, ticket, GICUBE_NO_DEADLINE, &traced, 1, nullptr), GICUBE_OK) << gicube_last_error();
  EXPECT_EQ(traced.id, ray.id);
  gicube_close(board);
  EXPECT_TRUE(std::ifstream(capture).good());
}

TEST_F(CApi, VerifiesTheVolume) {
  std::size_t damaged = 7;
  EXPECT_EQ(gicube_verify_volume(board_, nullptr, 0, &damaged), GICUBE_REJECTED);
  EXPECT_EQ(damaged, 0u);
  load();
  ASSERT_EQ(gicube_verify_volume(board_, nullptr, 0, &damaged), GICUBE_OK) << gicube_last_error();
  EXPECT_EQ(damaged, 0u);
  EXPECT_EQ(gicube_verify_volume(board_, nullptr, 1, &damaged), GICUBE_BAD_ARGUMENT);
}

TEST_F(CApi, IlluminatesAndScattersByTheCallersRoutine) {
  load();
  gicube_material material = made(gicube_material_init);
  material.scattering = 0.5;
  material.bsdf = GICUBE_BSDF_TRAP;
  material.routine = GICUBE_HOST_ROUTINE;
  ASSERT_EQ(gicube_set_material(board_, 0, &material), GICUBE_OK) << gicube_last_error();
  struct Asked {
    int calls = 0, stop_after = 1 << 30;
  } asked;
  const auto routine = [](void* user, const gicube_scatter_event* event, gicube_scatter_answer* answer) -> int {
    auto& state = *static_cast<Asked*>(user);
    EXPECT_EQ(event->size, sizeof *event);
    for (int axis = 0; axis < 3; ++axis) answer->direction[axis] = -event->direction[axis];
    return ++state.calls > state.stop_after;
  };
  ASSERT_EQ(gicube_set_scattering_routine(board_, routine, &asked, 100), GICUBE_OK);
  gicube_light light{};
  light.kind = GICUBE_LIGHT_POINT;
  light.power = 1;
  for (double& axis : light.position) axis = -20;
  const gicube_illumination settings = made(gicube_illumination_init);
  gicube_lighting_report report = made(gicube_lighting_report_init);
  ASSERT_EQ(gicube_illuminate(board_, &light, 1, &settings, nullptr, nullptr, &report), GICUBE_OK)
      << gicube_last_error();
  EXPECT_GT(asked.calls, 0);
  EXPECT_GT(report.emitted, 0);
  EXPECT_NEAR(report.emitted, report.deposited + report.escaped + report.scattered_away + report.clipped,
              1e-9 * report.emitted);
  EXPECT_EQ(gicube_lighting_warning(board_, report.warnings), nullptr);

  asked = {0, 3};
  EXPECT_EQ(gicube_illuminate(board_, &light, 1, &settings, nullptr, nullptr, &report), GICUBE_STOPPED);
  EXPECT_STREQ(gicube_last_error(), "the scattering routine ended the call");
  light.kind = 4;
  EXPECT_EQ(gicube_illuminate(board_, &light, 1, &settings, nullptr, nullptr, &report), GICUBE_BAD_ARGUMENT);
  EXPECT_STREQ(gicube_last_error_field(), "lights[0].kind");
}

TEST_F(CApi, AProgressCallbackCanEndTheCall) {
  const gicube_volume record = volume();
  const auto stop = [](void* user, std::uint32_t, std::uint32_t) { return ++*static_cast<int*>(user); };
  int calls = 0;
  EXPECT_EQ(gicube_load_volume(board_, &record, stop, &calls), GICUBE_STOPPED);
  EXPECT_EQ(calls, 1);
  load();  // the board is ready
}

TEST_F(CApi, CountersAreAListOfTheCallers) {
  load();
  gicube_counter_list* list = nullptr;
  ASSERT_EQ(gicube_get_counters(board_, &list), GICUBE_OK);
  ASSERT_GT(gicube_counters_count(list), 10u);
  std::uint64_t bytes = 0;
  EXPECT_EQ(gicube_counters_value(list, "bus.volume.bytes", &bytes), GICUBE_OK);
  EXPECT_GT(bytes, 0u);
  EXPECT_EQ(gicube_counters_value(list, "bus.tea.bytes", &bytes), GICUBE_UNSUPPORTED);
  EXPECT_EQ(bytes, 0u);
  const char *name = nullptr, *unit = nullptr;
  ASSERT_EQ(gicube_counters_at(list, 0, &name, &unit, &bytes), GICUBE_OK);
  EXPECT_STREQ(name, "bus.down.bytes");
  EXPECT_STREQ(unit, "byte");
  EXPECT_EQ(gicube_counters_at(list, gicube_counters_count(list), &name, nullptr, nullptr), GICUBE_BAD_ARGUMENT);
  gicube_counters_free(list);
  gicube_counters_free(nullptr);
  EXPECT_EQ(gicube_counters_count(nullptr), 0u);
}

TEST_F(CApi, FlagsAndCodebookAndShading) {
  std::vector<double> codebook(3 * 3);
  codebook[3] = 1;
  codebook[7] = 1;
  EXPECT_EQ(gicube_set_gradient_codebook(board_, codebook.data(), 3), GICUBE_OK) << gicube_last_error();
  EXPECT_EQ(gicube_set_gradient_codebook(board_, codebook.data(), 2049), GICUBE_BAD_ARGUMENT);
  load();
  std::int32_t blocks[3] = {};
  ASSERT_EQ(gicube_get_blocks(board_, blocks), GICUBE_OK);
  EXPECT_EQ(blocks[0], 1);
  std::uint8_t flag = 7;
  ASSERT_EQ(gicube_get_empty_flags(board_, &flag, 1), GICUBE_OK);
  EXPECT_EQ(flag, 0);
  flag = 1;
  ASSERT_EQ(gicube_set_empty_flags(board_, &flag, 1), GICUBE_OK);
  EXPECT_EQ(gicube_get_empty_flags(board_, &flag, 2), GICUBE_BAD_ARGUMENT);
  gicube_shading shading = made(gicube_shading_init);
  EXPECT_EQ(shading.diffuse, 0.7);
  EXPECT_EQ(gicube_set_shading(board_, &shading), GICUBE_OK);
  shading.ambient = 3;
  EXPECT_EQ(gicube_set_shading(board_, &shading), GICUBE_BAD_ARGUMENT);
}

}  // namespace
}  // namespace gicube
