// The C ABI does what the C++ API does, bit by bit.
#include "c_board.h"

#include <algorithm>
#include <fstream>
#include <numeric>

#include "temporary_directory.h"

namespace gicube::c_api_test {
namespace {

TEST_F(CApi, RendersTheBitsOfTheCppApiInTheSameTime) {
  load();
  const gicube_view record = view();
  std::vector<gicube_pixel> pixels(40 * 30);
  ASSERT_OK(gicube_render(board_, &record, pixels.data(), pixels.size(), nullptr, nullptr));
  Board board = twin(voxels_);
  const Image image = board.render(twin_view());
  expect_same(pixels, image);
  EXPECT_GT(std::ranges::count_if(pixels, [](const gicube_pixel& pixel) { return pixel.alpha > 0; }), 50);
  std::uint64_t now = 0;
  EXPECT_OK(gicube_now(board_, &now));
  EXPECT_EQ(now, board.now());
  std::int32_t width = 0, height = 0;
  EXPECT_OK(gicube_get_framebuffer_size(board_, &width, &height));
  EXPECT_EQ(width, 40);
  EXPECT_EQ(height, 30);
}

// A mirror whose face z = 8 shows a lamp.
TEST_F(CApi, ShowsLampsAsTheCppApiDoes) {
  load();
  gicube_material mirror = made(gicube_material_init);
  mirror.scattering = 1;
  mirror.bsdf = GICUBE_BSDF_SPECULAR;
  mirror.seen_through_scattering = 1;
  ASSERT_OK(gicube_set_material(board_, 0, &mirror));
  const double power = 4 * 3.14159 * 90 * 90;
  const gicube_lamp lamp{{GICUBE_LIGHT_SPHERE, 0, {-66, -36, -64}, {}, {}, 90, power}, {0.25, 0.5, 1}};
  gicube_view record = view();
  record.scatter = 1;
  record.lamps = &lamp;
  record.lamp_count = 1;
  std::vector<gicube_pixel> pixels(40 * 30);
  ASSERT_OK(gicube_render(board_, &record, pixels.data(), pixels.size(), nullptr, nullptr));
  Board board = twin(voxels_);
  board.set_material({.scattering = 1, .bsdf = Bsdf::kSpecular, .seen_through_scattering = true});
  View same = twin_view();
  same.scatter = true;
  same.lamps = {{SphereLight{{-66, -36, -64}, 90, power}, {0.25, 0.5, 1}}};
  const Image image = board.render(same);
  expect_same(pixels, image);
  EXPECT_TRUE(std::ranges::any_of(pixels, [](const auto& each) { return each.alpha == 4095 && each.blue == 255; }));
}

TEST_F(CApi, ReadsAndWritesBoxesOfTheVolume) {
  load();
  double low = 1, high = 0;
  ASSERT_OK(gicube_value_range(board_, &low, &high));
  EXPECT_EQ(low, 0);
  EXPECT_EQ(high, 255);
  const gicube_box box{{9, 9, 9}, {2, 2, 1}};
  std::vector<float> values(4);
  ASSERT_OK(gicube_read_volume(board_, &box, values.data(), 4));
  EXPECT_NEAR(values[0], 136, 0.1);
  EXPECT_NEAR(values[1], 140, 0.1);
  values = {0, 50, 100, 255};
  ASSERT_OK(gicube_write_volume(board_, &box, values.data(), 4));
  std::vector<float> read(4);
  ASSERT_OK(gicube_read_volume(board_, &box, read.data(), 4));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(read[i], values[i], 0.1);
  EXPECT_REFUSED(gicube_read_volume(board_, &box, values.data(), 5), "count");
}

// The board dies with its 40th message; a new one has the volume again, and the rays that were under way.
TEST(CReopen, GoesOnOnANewBoardWithTheVolumeAndTheRaysThatWereUnderWay) {
  const reference::TemporaryDirectory folder;
  const std::string plan = folder.file("plan.textproto");
  std::ofstream(plan) << "fault { direction: up message: 40 kind: kill }\n";
  gicube_open_options options = made(gicube_open_options_init);
  options.keep_volume = 1;
  const std::string capture = folder.file("session.capture");
  options.capture = capture.c_str();
  gicube_board* board = nullptr;
  ASSERT_OK(gicube_open(("emu:?faults=" + plan).c_str(), &options, &board));
  const std::vector<std::uint8_t> voxels = cube();
  gicube_volume volume = made(gicube_volume_init);
  volume.type = GICUBE_SAMPLE_UINT8;
  for (std::int32_t& edge : volume.dims) edge = kEdge;
  volume.samples = voxels.data();
  volume.sample_bytes = voxels.size();
  ASSERT_OK(gicube_load_volume(board, &volume, nullptr, nullptr));
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
  ASSERT_OK(gicube_reopen(board, &reopened));
  EXPECT_EQ(reopened.resumed, 0);
  EXPECT_EQ(reopened.volume, 1);
  ASSERT_OK(gicube_receive(board, ticket, GICUBE_NO_DEADLINE, &traced, 1, nullptr));
  EXPECT_EQ(traced.id, ray.id);
  gicube_close(board);
  EXPECT_TRUE(std::ifstream(capture).good());
}

TEST(COpen, TakesTheFilesOfTokenAndCertificatesFromItsOptions) {
  gicube_open_options options = made(gicube_open_options_init);
  gicube_board* board = nullptr;
  options.token_file = "/nowhere/token";
  EXPECT_REFUSED(gicube_open("tcp:127.0.0.1:1", &options, &board), "token_file");
  options.token_file = nullptr;
  options.ca_file = "/nowhere/ca";
  EXPECT_REFUSED(gicube_open("tls:127.0.0.1:1", &options, &board), "ca_file");
}

TEST_F(CApi, SavesTheBoardAndGoesOnFromTheFile) {
  const reference::TemporaryDirectory folder;
  const std::string saved = folder.file("saved");
  load();
  gicube_host_ray ray{};
  ray.id = 7;
  ray.position[0] = ray.position[1] = 16;
  ray.direction[2] = 1;
  std::uint32_t ticket = 0;
  ASSERT_OK(gicube_submit(board_, &ray, 1, nullptr, &ticket));
  EXPECT_EQ(gicube_save(board_, nullptr), GICUBE_BAD_ARGUMENT);
  ASSERT_OK(gicube_save(board_, saved.c_str()));
  gicube_traced_ray here, there;
  ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, &here, 1, nullptr));
  EXPECT_EQ(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, &there, 1, nullptr), GICUBE_BAD_ARGUMENT);
  ASSERT_OK(gicube_restore(board_, saved.c_str()));
  ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, &there, 1, nullptr));
  EXPECT_EQ(there.id, 7u);
  EXPECT_EQ(there.opacity, here.opacity);
  EXPECT_REFUSED(gicube_restore(board_, "/nowhere/saved"), "file");
  gicube_open_options options = made(gicube_open_options_init);
  options.go_on = 1;
  gicube_board* other = nullptr;
  EXPECT_EQ(gicube_open("emu:", &options, &other), GICUBE_OPEN_FAILED);
  EXPECT_OK(gicube_open(("emu:?restore=" + saved).c_str(), nullptr, &other));
  gicube_close(other);
}

TEST_F(CApi, VerifiesTheVolume) {
  std::size_t damaged = 7;
  EXPECT_EQ(gicube_verify_volume(board_, nullptr, 0, &damaged), GICUBE_REJECTED);
  EXPECT_EQ(damaged, 0u);
  load();
  ASSERT_OK(gicube_verify_volume(board_, nullptr, 0, &damaged));
  EXPECT_EQ(damaged, 0u);
  EXPECT_EQ(gicube_verify_volume(board_, nullptr, 1, &damaged), GICUBE_BAD_ARGUMENT);
}

TEST_F(CApi, IlluminatesAndScattersByTheCallersRoutine) {
  load();
  gicube_material material = made(gicube_material_init);
  material.scattering = 0.5;
  material.bsdf = GICUBE_BSDF_TRAP;
  material.routine = GICUBE_HOST_ROUTINE;
  ASSERT_OK(gicube_set_material(board_, 0, &material));
  struct Asked {
    int calls = 0, stop_after = 1 << 30;
  } asked;
  const auto routine = [](void* user, const gicube_scatter_event* event, gicube_scatter_answer* answer) -> int {
    auto& state = *static_cast<Asked*>(user);
    EXPECT_EQ(event->size, sizeof *event);
    for (int axis = 0; axis < 3; ++axis) answer->direction[axis] = -event->direction[axis];
    return ++state.calls > state.stop_after;
  };
  ASSERT_OK(gicube_set_scattering_routine(board_, routine, &asked, 100));
  gicube_light light{};
  light.kind = GICUBE_LIGHT_POINT;
  light.power = 1;
  for (double& axis : light.position) axis = -20;
  const gicube_illumination settings = made(gicube_illumination_init);
  gicube_lighting_report report = made(gicube_lighting_report_init);
  ASSERT_OK(gicube_illuminate(board_, &light, 1, &settings, nullptr, nullptr, &report));
  EXPECT_GT(asked.calls, 0);
  EXPECT_GT(report.emitted, 0);
  EXPECT_NEAR(report.emitted, report.deposited + report.escaped + report.scattered_away + report.clipped,
              1e-9 * report.emitted);
  EXPECT_NEAR(std::accumulate(report.escaped_by_face, report.escaped_by_face + 6, 0.0), report.escaped,
              1e-9 * report.escaped);
  EXPECT_EQ(gicube_lighting_warning(board_, report.warnings), nullptr);

  asked = {0, 3};
  EXPECT_EQ(gicube_illuminate(board_, &light, 1, &settings, nullptr, nullptr, &report), GICUBE_STOPPED);
  EXPECT_STREQ(gicube_last_error(), "the scattering routine ended the call");
  light.kind = 4;
  EXPECT_REFUSED(gicube_illuminate(board_, &light, 1, &settings, nullptr, nullptr, &report), "lights[0].kind");
}

TEST_F(CApi, SaysWhyNothingIsVisibleUntilSomethingIs) {
  const gicube_volume record = volume();
  ASSERT_OK(gicube_load_volume(board_, &record, nullptr, nullptr));
  const gicube_view camera = view();
  std::vector<gicube_pixel> pixels(40 * 30);
  EXPECT_EQ(gicube_why_invisible(board_), nullptr);  // there is no picture
  ASSERT_OK(gicube_render(board_, &camera, pixels.data(), pixels.size(), nullptr, nullptr));
  EXPECT_STREQ(gicube_why_invisible(board_), "nothing is visible in the picture: no transfer function is set");
  ASSERT_OK(make_visible());
  ASSERT_OK(gicube_render(board_, &camera, pixels.data(), pixels.size(), nullptr, nullptr));
  EXPECT_EQ(gicube_why_invisible(board_), nullptr);
}

TEST_F(CApi, LightHasThreeColoursOnABoardOfThreeIrradianceWords) {
  gicube_close(board_);
  ASSERT_OK(gicube_open("emu:?set=asic.irradiance_words=3", nullptr, &board_));
  load();
  gicube_light light{};
  light.kind = GICUBE_LIGHT_POINT;
  light.power = 1;
  for (double& axis : light.position) axis = -20;
  const double colour[] = {1, 0.5, 0.25};
  gicube_illumination settings = made(gicube_illumination_init);
  settings.light_colours = colour;
  settings.light_colour_count = 1;
  gicube_lighting_report report = made(gicube_lighting_report_init);
  ASSERT_OK(gicube_illuminate(board_, &light, 1, &settings, nullptr, nullptr, &report));
  EXPECT_NEAR(report.colours[1].emitted, report.colours[0].emitted / 2, 0.02 * report.colours[0].emitted);
  EXPECT_NEAR(report.colours[0].emitted + report.colours[1].emitted + report.colours[2].emitted, report.emitted,
              1e-9 * report.emitted);
  const gicube_box box{{8, 8, 8}, {16, 16, 16}};
  std::vector<float> values(3 * 16 * 16 * 16);
  EXPECT_REFUSED(gicube_read_irradiance(board_, &box, values.data(), values.size() / 3), "count");
  ASSERT_OK(gicube_read_irradiance(board_, &box, values.data(), values.size()));
  EXPECT_GT(*std::max_element(values.begin(), values.end()), 0);
  ASSERT_OK(gicube_write_irradiance(board_, &box, values.data(), values.size()));
  settings.light_colours = nullptr;
  EXPECT_REFUSED(gicube_illuminate(board_, &light, 1, &settings, nullptr, nullptr, &report), "settings.light_colours");
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
  ASSERT_OK(gicube_get_counters(board_, &list));
  ASSERT_GT(gicube_counters_count(list), 10u);
  std::uint64_t bytes = 0;
  EXPECT_OK(gicube_counters_value(list, "bus.volume.bytes", &bytes));
  EXPECT_GT(bytes, 0u);
  EXPECT_EQ(gicube_counters_value(list, "bus.tea.bytes", &bytes), GICUBE_UNSUPPORTED);
  EXPECT_EQ(bytes, 0u);
  const char *name = nullptr, *unit = nullptr;
  ASSERT_OK(gicube_counters_at(list, 0, &name, &unit, &bytes));
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
  EXPECT_OK(gicube_set_gradient_codebook(board_, codebook.data(), 3));
  EXPECT_EQ(gicube_set_gradient_codebook(board_, codebook.data(), 2049), GICUBE_BAD_ARGUMENT);
  load();
  std::int32_t blocks[3] = {};
  ASSERT_OK(gicube_get_blocks(board_, blocks));
  EXPECT_EQ(blocks[0], 1);
  std::uint8_t flag = 7;
  ASSERT_OK(gicube_get_empty_flags(board_, &flag, 1));
  EXPECT_EQ(flag, 0);
  flag = 1;
  ASSERT_OK(gicube_set_empty_flags(board_, &flag, 1));
  EXPECT_EQ(gicube_get_empty_flags(board_, &flag, 2), GICUBE_BAD_ARGUMENT);
  gicube_shading shading = made(gicube_shading_init);
  EXPECT_EQ(shading.diffuse, 0.7);
  EXPECT_OK(gicube_set_shading(board_, &shading));
  shading.ambient = 3;
  EXPECT_EQ(gicube_set_shading(board_, &shading), GICUBE_BAD_ARGUMENT);
}

}  // namespace
}  // namespace gicube::c_api_test
