// Queues: all rays meet in one block, because the camera or a light stands in it or a caustic is focused there.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "stability.h"

namespace gicube::stability {
namespace {

constexpr int kSize = 32;
constexpr Vec3 kMeeting{12.3, 11.6, 12.9};  // in the middle of one block of 8^3

// Whatever is asked of a board, by all boards alike: the functional level, and cycle levels with short queues, with
// long ones and with none that overflow.
struct Cost {
  std::uint64_t overflows = 0;
  Picoseconds time = 0;
};

class StabilityOfQueues : public testing::Test {
 protected:
  static Board functional() { return loaded(""); }
  static Board cycle(const char* queues) { return loaded(std::string("&fidelity=cycle&set=") + queues); }
  static Board loaded(const std::string& options) {
    Board board = Board::open(small_board(options));
    load_fog(board, {kSize, kSize, kSize}, 0.02);
    Material mist;
    mist.scattering = 0.5;
    mist.bsdf = Bsdf::kIsotropic;
    board.set_material(mist);
    return board;
  }
  // Runs `work` on a board and counts what it cost; `work` returns what must be the same on every board.
  template <typename Progress>
  static auto measured(Board& board, const Progress& work, Cost& run) {
    const Counters before = board.counters();
    const Picoseconds begin = board.now();
    auto result = work(board);
    run = {(board.counters() - before).value("dsp.overflows"), board.now() - begin};
    return result;
  }
  // Queues of 8 rays lose none and do not stop; what the overflow costs stands in the counters.
  template <typename Progress>
  static void expect_no_loss(const Progress& work, const std::string& name) {
    Board plain = functional(), ideal = cycle("ideal.queues=1"), narrow = cycle("asic.queue_rays=8");
    const auto expected = work(plain);
    Cost without, with;
    EXPECT_EQ(measured(ideal, work, without), expected);
    EXPECT_EQ(measured(narrow, work, with), expected);
    EXPECT_EQ(without.overflows, 0u);
    EXPECT_GT(with.overflows, 0u);
    EXPECT_GT(with.time, without.time);
    record(name + "_overflows", static_cast<double>(with.overflows));
    record(name + "_time_over_that_of_queues_without_end", ratio(with.time, without.time));
  }
};

TEST_F(StabilityOfQueues, ACameraInABlockLosesNoRay) {
  const auto picture = [](Board& board) {
    View view;
    view.eye = kMeeting;
    view.look_at = kMeeting + Vec3{1, 0.7, 0.4};
    view.fov_degrees = 100;
    view.width = view.height = 40;
    view.shade = false;
    return board.render(view).pixels;
  };
  expect_no_loss(picture, "camera_inside");
}

TEST_F(StabilityOfQueues, ALightInABlockLosesNoEnergy) {
  const auto light = [](Board& board) {
    const std::vector<Light> lamp{PointLight{kMeeting, 1000}};
    const LightingReport report = board.illuminate(lamp, {});
    EXPECT_NEAR(report.deposited + report.escaped + report.scattered_away + report.clipped, report.emitted,
                1e-9 * report.emitted);
    return board.read_irradiance();
  };
  expect_no_loss(light, "light_inside");
}

TEST_F(StabilityOfQueues, ACausticThroughOneBlockBringsEveryRayBackOnce) {
  std::vector<HostRay> rays;
  constexpr std::uint32_t kRays = 3000;
  for (std::uint32_t i = 0; i < kRays; ++i) {
    const double z = 1 - 2 * (i + 0.5) / kRays, around = 2.399963 * i, across = std::sqrt(1 - z * z);
    const Vec3 out{across * std::cos(around), across * std::sin(around), z};
    rays.push_back(ray_between(i, kMeeting + 11.0 * out, kMeeting - 11.0 * out));
  }
  const auto focus = [&](Board& board) { return board.receive(board.submit(rays, {.type = RayType::kSegment})).rays; };
  expect_no_loss(focus, "caustic");
  Board narrow = cycle("asic.queue_rays=1");
  const std::vector<TracedRay> back = focus(narrow);
  ASSERT_EQ(back.size(), rays.size());
  for (std::uint32_t i = 0; i < kRays; ++i) ASSERT_EQ(back[i].id, i);
}

}  // namespace
}  // namespace gicube::stability
