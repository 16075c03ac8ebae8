// Calls of the C ABI that are started do what the blocking ones do, bit by bit and in the same simulated time.
#include <poll.h>
#include <unistd.h>

#include <algorithm>

#include "c_board.h"

namespace gicube::c_api_test {
namespace {

constexpr std::uint64_t kLong = 600'000;  // ms

void expect_ready(const gicube_pending* pending) {
  std::int32_t ready = 0;
  ASSERT_OK(gicube_pending_wait(pending, kLong, &ready));
  EXPECT_EQ(ready, 1);
}

TEST_F(CApi, StartedLoadingAndPictureHaveTheBitsAndTimesOfTheBlockingCalls) {
  const gicube_volume record = volume();
  gicube_pending* pending = nullptr;
  ASSERT_OK(gicube_start_load_volume(board_, &record, &pending));
  expect_ready(pending);
  ASSERT_OK(gicube_finish_load_volume(pending, GICUBE_NO_DEADLINE));
  gicube_pending_free(pending);
  ASSERT_OK(make_visible());

  const gicube_view picture = view();
  ASSERT_OK(gicube_start_render(board_, &picture, &pending));
  int descriptor = -1;
  ASSERT_OK(gicube_pending_descriptor(pending, &descriptor));
  pollfd waits{descriptor, POLLIN, 0};
  EXPECT_EQ(poll(&waits, 1, static_cast<int>(kLong)), 1);
  close(descriptor);
  std::uint32_t done = 0, all = 0;
  ASSERT_OK(gicube_pending_progress(pending, &done, &all));
  EXPECT_GT(all, 0u);
  EXPECT_EQ(done, all);
  std::vector<gicube_pixel> pixels(40 * 30);
  EXPECT_REFUSED(gicube_finish_render(pending, GICUBE_NO_DEADLINE, pixels.data(), 7), "count");
  EXPECT_EQ(gicube_finish_render(pending, 1, pixels.data(), pixels.size()), GICUBE_DEADLINE_PASSED);
  ASSERT_OK(gicube_finish_render(pending, GICUBE_NO_DEADLINE, pixels.data(), pixels.size()));
  EXPECT_EQ(gicube_finish_render(pending, GICUBE_NO_DEADLINE, pixels.data(), pixels.size()), GICUBE_BAD_ARGUMENT)
      << "the result can be taken once";
  gicube_pending_free(pending);

  Board board = twin(voxels_);
  expect_same(pixels, board.render(twin_view()));
  std::uint64_t now = 0;
  EXPECT_OK(gicube_now(board_, &now));
  EXPECT_EQ(now, board.now());
  std::int32_t width = 0, height = 0;
  EXPECT_OK(gicube_get_framebuffer_size(board_, &width, &height));
  EXPECT_EQ(width * height, 40 * 30);
}

TEST_F(CApi, StartedIlluminationHasTheReportOfTheBlockingCall) {
  load();
  const gicube_light light{GICUBE_LIGHT_POINT, 0, {-20, 16, 16}, {}, {}, 0, 100};
  gicube_illumination settings = made(gicube_illumination_init);
  settings.rays_per_face_voxel = 1;
  gicube_lighting_report reports[2] = {made(gicube_lighting_report_init), made(gicube_lighting_report_init)};
  ASSERT_OK(gicube_illuminate(board_, &light, 1, &settings, nullptr, nullptr, &reports[0]));
  gicube_pending* pending = nullptr;
  ASSERT_OK(gicube_start_illuminate(board_, &light, 1, &settings, &pending));
  EXPECT_REFUSED(gicube_finish_load_volume(pending, GICUBE_NO_DEADLINE), "pending");
  ASSERT_OK(gicube_finish_illuminate(pending, GICUBE_NO_DEADLINE, &reports[1]));
  gicube_pending_free(pending);
  EXPECT_GT(reports[0].rays, 0u);
  EXPECT_EQ(reports[0].rays, reports[1].rays);
  EXPECT_EQ(reports[0].deposited, reports[1].deposited);
  EXPECT_EQ(reports[0].escaped, reports[1].escaped);
}

TEST_F(CApi, StartedPairsHaveTheFactorsOfTheBlockingCall) {
  load();
  gicube_element elements[2] = {};
  for (gicube_element& each : elements) each.kind = GICUBE_ELEMENT_PATCH;
  const double origins[2][3] = {{4, 4, 4}, {4, 4, 27}};
  for (int i = 0; i < 2; ++i) {
    std::ranges::copy(origins[i], elements[i].origin);
    elements[i].u[i] = 3;  // the normals u x v face each other
    elements[i].v[1 - i] = 3;
  }
  const gicube_element_pair pair{0, 1, 5, 0};
  gicube_pair_factor factors[2] = {};
  ASSERT_OK(gicube_pair_factors(board_, elements, 2, &pair, 1, nullptr, nullptr, nullptr, &factors[0], 1));
  gicube_pending* pending = nullptr;
  ASSERT_OK(gicube_start_pair_factors(board_, elements, 2, &pair, 1, nullptr, &pending));
  ASSERT_OK(gicube_finish_pair_factors(pending, GICUBE_NO_DEADLINE, &factors[1], 1));
  gicube_pending_free(pending);
  EXPECT_GT(factors[0].geometric, 0);
  EXPECT_EQ(factors[0].geometric, factors[1].geometric);
  EXPECT_EQ(factors[0].transported, factors[1].transported);
}

TEST_F(CApi, StartedCallsSayAtTheirEndWhatWasWrongAndCanBeCancelled) {
  load();
  gicube_view wrong = view();
  wrong.width = -3;
  gicube_pending* pending = nullptr;
  gicube_pixel pixel;
  ASSERT_OK(gicube_start_render(board_, &wrong, &pending));
  EXPECT_REFUSED(gicube_finish_render(pending, GICUBE_NO_DEADLINE, &pixel, 1), "width");
  gicube_pending_free(pending);

  gicube_view large = view();
  large.width = large.height = 1024;
  large.step = 0.05;
  gicube_pending* first = nullptr;
  ASSERT_OK(gicube_start_render(board_, &large, &first));
  ASSERT_OK(gicube_start_render(board_, &large, &pending));
  std::int32_t cancelled = 0;
  ASSERT_OK(gicube_pending_cancel(pending, &cancelled));
  EXPECT_EQ(cancelled, 1) << "it waits for the first";
  std::vector<gicube_pixel> pixels(std::size_t{1024} * 1024);
  EXPECT_EQ(gicube_finish_render(pending, GICUBE_NO_DEADLINE, pixels.data(), pixels.size()), GICUBE_STOPPED);
  ASSERT_OK(gicube_pending_cancel(first, &cancelled));
  gicube_pending_free(pending);
  gicube_pending_free(first);
  EXPECT_REFUSED(gicube_pending_wait(nullptr, 0, &cancelled), "pending");
}

}  // namespace
}  // namespace gicube::c_api_test
