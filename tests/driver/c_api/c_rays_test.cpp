// Rays of a C program come back as those of a C++ program, bit by bit.
#include "c_board.h"

#include <poll.h>
#include <unistd.h>

#include <utility>

namespace gicube::c_api_test {
namespace {

TEST_F(CApi, TracesTheRaysOfTheCppApi) {
  load();
  const auto given = rays(5000);
  std::uint32_t ticket = 0;
  ASSERT_OK(gicube_submit(board_, given.data(), given.size(), nullptr, &ticket));
  std::vector<gicube_traced_ray> traced(given.size());
  gicube_batch_report report = made(gicube_batch_report_init);
  ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, traced.data(), traced.size(), &report));
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
    ASSERT_OK(gicube_submit(board_, given.data(), given.size(), &request, &ticket));
    ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, into->data(), into->size(), nullptr));
  }
  const std::size_t middle = 12 * 31 + 12;
  EXPECT_GT(whole[middle].opacity, half[middle].opacity);
  EXPECT_GT(half[middle].opacity, 0);
  EXPECT_EQ(half[middle].colour[0], 0);

  ASSERT_OK(gicube_clear_irradiance(board_, 0.5));
  request.type = GICUBE_RAY_DEPOSIT;
  ASSERT_OK(gicube_submit(board_, given.data(), given.size(), &request, &ticket));
  gicube_batch_report report = made(gicube_batch_report_init);
  ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, nullptr, 0, &report));
  EXPECT_EQ(report.deposited, 1);
  EXPECT_EQ(report.rays, 0u);
  EXPECT_GT(report.lighting.deposited, 0);
  EXPECT_GT(report.escaped_by_face[5], 0);  // the rays go along z
  EXPECT_EQ(report.escaped_by_face[5], report.lighting.escaped);
  std::vector<float> irradiance(voxels_.size());
  ASSERT_OK(gicube_read_irradiance(board_, nullptr, irradiance.data(), irradiance.size()));
  double sum = 0;
  for (const float value : irradiance) sum += value;
  EXPECT_NEAR(sum, report.lighting.deposited, 1e-3 * sum);
}

TEST_F(CApi, HasADescriptorOfEachBatchThatPollCanWaitFor) {
  load();
  const auto given = rays(5000);
  std::uint32_t ticket = 0;
  int descriptor = 0;
  EXPECT_EQ(gicube_batch_descriptor(board_, 77, &descriptor), GICUBE_BAD_ARGUMENT);
  EXPECT_EQ(descriptor, -1);
  ASSERT_OK(gicube_submit(board_, given.data(), given.size(), nullptr, &ticket));
  EXPECT_EQ(gicube_batch_descriptor(board_, ticket, nullptr), GICUBE_BAD_ARGUMENT);
  const auto wait = [&] {
    ASSERT_OK(gicube_batch_descriptor(board_, ticket, &descriptor));
    pollfd waits{descriptor, POLLIN, 0};
    EXPECT_EQ(::poll(&waits, 1, -1), 1);
    EXPECT_EQ(::close(descriptor), 0);
  };
  wait();
  gicube_batch_report report = made(gicube_batch_report_init);
  ASSERT_OK(gicube_host_compute(board_, 1'000'000'000'000));
  ASSERT_OK(gicube_poll(board_, &report));
  ASSERT_EQ(report.ticket, ticket);
  wait();  // of one that has arrived, too
  std::vector<gicube_traced_ray> traced(given.size());
  EXPECT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, traced.data(), traced.size(), nullptr));
}

TEST_F(CApi, ProjectsAndBackprojects) {
  load();
  auto given = rays(500);
  for (gicube_host_ray& ray : given) ray.length = 16, ray.energy = -2;
  gicube_ray_request request = made(gicube_ray_request_init);
  request.type = GICUBE_RAY_INTEGRAL;
  std::uint32_t ticket = 0;
  std::vector<gicube_traced_ray> traced(given.size());
  ASSERT_OK(gicube_submit(board_, given.data(), given.size(), &request, &ticket));
  ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, traced.data(), traced.size(), nullptr));
  EXPECT_GT(traced[12 * 31 + 12].integral, 0);

  request.type = GICUBE_RAY_BACKPROJECT;
  EXPECT_EQ(request.words, GICUBE_WORDS_SUMS);
  ASSERT_OK(gicube_clear_sums(board_, 1e-5));
  ASSERT_OK(gicube_submit(board_, given.data(), given.size(), &request, &ticket));
  gicube_batch_report report = made(gicube_batch_report_init);
  ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, nullptr, 0, &report));
  EXPECT_EQ(report.backprojected, 1);
  EXPECT_EQ(report.deposits.rays, 500u);
  EXPECT_NEAR(report.deposits.kept, -2 * 16 * 500, 1e-3);
  const gicube_box all{{0, 0, 0}, {32, 32, 32}};
  std::vector<float> sums(voxels_.size());
  ASSERT_OK(gicube_read_sums(board_, &all, sums.data(), sums.size()));
  double sum = 0;
  for (const float value : sums) sum += value;
  EXPECT_NEAR(sum, report.deposits.kept, 1e-3);
  EXPECT_EQ(gicube_read_sums(board_, &all, sums.data(), 5), GICUBE_BAD_ARGUMENT);
}

TEST_F(CApi, GathersRaysOfSeveralPlaces) {
  load();
  const auto given = rays(31);
  const gicube_ray_span spans[] = {{given.data(), 10}, {nullptr, 0}, {given.data() + 10, 21}};
  std::uint32_t ticket = 0;
  ASSERT_OK(gicube_submit_gather(board_, spans, 3, nullptr, &ticket));
  std::vector<gicube_traced_ray> traced(31);
  ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, traced.data(), 31, nullptr));
  for (std::size_t i = 0; i < 31; ++i) EXPECT_EQ(traced[i].id, 1000 + i);
}

TEST_F(CApi, AddsTheLegsOfLinesUp) {
  load();
  for (const bool polled : {false, true}) {
    const double points[] = {12, 12, 0, 12, 12, 16, 12, 12, 31};
    const gicube_polyline lines[] = {{7, 0, points, 3}, {8, 0, points, 2}};
    std::uint32_t ticket = 0;
    ASSERT_OK(gicube_submit_polylines(board_, lines, 2, &ticket));
    gicube_batch_report report = made(gicube_batch_report_init);
    ASSERT_OK(gicube_host_compute(board_, 1'000'000'000'000));
    if (polled) {
      ASSERT_OK(gicube_poll(board_, &report));
    }
    std::vector<gicube_traced_ray> traced(3), segment(1);
    ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, traced.data(), 3, nullptr));
    gicube_host_ray second{};
    ASSERT_OK(gicube_ray_between(7, points + 3, points + 6, &second));
    gicube_ray_request request = made(gicube_ray_request_init);
    request.type = GICUBE_RAY_SEGMENT;
    ASSERT_OK(gicube_submit(board_, &second, 1, &request, &ticket));
    ASSERT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, segment.data(), 1, nullptr));
    EXPECT_EQ(traced[1].opacity, traced[0].opacity + (1 - traced[0].opacity) * segment[0].opacity);
    EXPECT_GT(traced[0].opacity, 0);
    EXPECT_EQ(traced[2].opacity, traced[0].opacity);
    EXPECT_EQ(traced[2].id, 8u);
  }
}

TEST_F(CApi, SamplesRaysAsTheRequestSaysOrElseAsTheLastView) {
  load();
  const gicube_host_ray ray{1, 0, {16, 16, 0}, {0, 0, 1}, 0, 0};
  gicube_ray_request request = made(gicube_ray_request_init);
  const auto opacity = [&] {
    std::uint32_t ticket = 0;
    gicube_traced_ray traced{};
    EXPECT_OK(gicube_submit(board_, &ray, 1, &request, &ticket));
    EXPECT_OK(gicube_receive(board_, ticket, GICUBE_NO_DEADLINE, &traced, 1, nullptr));
    return traced.opacity;
  };
  const double whole = opacity();
  gicube_view cut = made(gicube_view_init), plain = cut;
  const gicube_cut_plane plane{{0, 0, 1}, 16};
  cut.cut_planes = &plane;
  cut.cut_plane_count = 1;
  request.sampled_as = &cut;
  const double part = opacity();
  EXPECT_LT(part, whole);
  request.sampled_as = nullptr;
  EXPECT_EQ(opacity(), whole);
  cut.eye[2] = -60;
  ASSERT_OK(gicube_render_to_framebuffer(board_, &cut, nullptr, nullptr));
  EXPECT_EQ(opacity(), part);
  request.sampled_as = &plain;
  EXPECT_EQ(opacity(), whole);
}

TEST(CRay, GoesFromOnePointToAnother) {
  const double from[] = {1, 2, 3}, to[] = {1, 2, 8};
  gicube_host_ray ray;
  ASSERT_OK(gicube_ray_between(9, from, to, &ray));
  EXPECT_EQ(ray.id, 9u);
  EXPECT_EQ(ray.position[2], 3);
  EXPECT_EQ(ray.length, 5);
  EXPECT_GT(ray.direction[2], 0);
  EXPECT_EQ(gicube_ray_between(9, nullptr, to, &ray), GICUBE_BAD_ARGUMENT);
}

TEST_F(CApi, PollTellsOfBatchesThatReceiveThenGives) {
  load();
  gicube_batch_report report = made(gicube_batch_report_init);
  ASSERT_OK(gicube_poll(board_, &report));
  EXPECT_EQ(report.ticket, 0u);
  const auto given = rays(100);
  std::uint32_t first = 0, second = 0;
  ASSERT_OK(gicube_submit(board_, given.data(), 60, nullptr, &first));
  ASSERT_OK(gicube_submit(board_, given.data(), 40, nullptr, &second));
  std::vector<gicube_traced_ray> traced(60);
  EXPECT_EQ(gicube_receive(board_, second, 1, traced.data(), 40, nullptr), GICUBE_DEADLINE_PASSED);
  ASSERT_OK(gicube_host_compute(board_, 1'000'000'000));
  ASSERT_OK(gicube_poll(board_, &report));
  EXPECT_EQ(report.ticket, first);
  EXPECT_EQ(report.rays, 60u);
  std::int32_t cancelled = 7;
  EXPECT_OK(gicube_cancel(board_, first, &cancelled));
  EXPECT_EQ(cancelled, 0);
  EXPECT_EQ(gicube_receive(board_, first, GICUBE_NO_DEADLINE, traced.data(), 59, nullptr), GICUBE_BAD_ARGUMENT);
  EXPECT_OK(gicube_receive(board_, first, GICUBE_NO_DEADLINE, traced.data(), 60, nullptr));
  EXPECT_EQ(traced[59].id, 1059u);
  EXPECT_EQ(gicube_receive(board_, first, GICUBE_NO_DEADLINE, traced.data(), 60, nullptr), GICUBE_BAD_ARGUMENT);
  ASSERT_OK(gicube_poll(board_, &report));
  EXPECT_EQ(report.ticket, second);
  EXPECT_OK(gicube_receive(board_, second, GICUBE_NO_DEADLINE, traced.data(), 40, nullptr));
  ASSERT_OK(gicube_poll(board_, &report));
  EXPECT_EQ(report.ticket, 0u);
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
  ASSERT_OK(gicube_pair_factors(board_, elements, 2, &pair, 1, &request, nullptr, nullptr, &factor, 1));
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
  EXPECT_EQ(factor.clear, 0);
  const gicube_colour_point white{0, {1, 1, 1}};
  const gicube_opacity_point invisible{0, 0};
  ASSERT_OK(gicube_set_transfer_function(board_, 0, &white, 1, &invisible, 1));
  ASSERT_OK(gicube_pair_factors(board_, elements, 2, &pair, 1, &request, nullptr, nullptr, &factor, 1));
  EXPECT_EQ(factor.clear, 1);
  EXPECT_EQ(static_cast<float>(factor.transported), static_cast<float>(factor.geometric));
  EXPECT_REFUSED(gicube_pair_factors(board_, elements, 2, &pair, 1, &request, nullptr, nullptr, &factor, 2), "count");
  elements[1].kind = 4;
  EXPECT_REFUSED(gicube_pair_factors(board_, elements, 2, &pair, 1, &request, nullptr, nullptr, &factor, 1),
                 "elements[1].kind");
}

}  // namespace
}  // namespace gicube::c_api_test
