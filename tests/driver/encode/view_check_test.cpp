#include "encode/camera.h"
#include "refusal.h"
#include "test.h"

namespace gicube {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

// The refusal of an otherwise good view after `edit`.
template <typename Edit>
std::string refusal_after(Edit&& edit) {
  View view;
  view.eye = {0, 0, 100};
  edit(view);
  return refusal([&view] { check(view); });
}

TEST(ViewCheck, AcceptsTheLimits) {
  EXPECT_EQ(refusal_after([](View&) {}), "accepted");
  EXPECT_EQ(refusal_after([](View& view) {
              view.width = 1;
              view.height = 4095;
              view.samples_per_axis = 4;
              view.step = 1.0 / 64;
              view.opacity_threshold = 0;
              view.cut_planes.assign(6, CutPlane{{0, 0, 1e-200}, 0});
            }),
            "accepted");
  EXPECT_EQ(refusal_after([](View& view) {
              view.step = 16;
              view.opacity_threshold = 1;
              view.orthographic_height = 1;
              view.fov_degrees = 0;  // not used
            }),
            "accepted");
}

TEST(ViewCheck, NamesWhatIsWrongWithTheCamera) {
  EXPECT_EQ(refusal_after([](View& view) { view.eye.x = kNan; }), "eye.x: expected -1000000000..1000000000, got nan");
  EXPECT_EQ(refusal_after([](View& view) { view.look_at.z = 2e9; }),
            "look_at.z: expected -1000000000..1000000000, got 2000000000");
  EXPECT_EQ(refusal_after([](View& view) { view.look_at = view.eye; }),
            "look_at: expected a point other than the eye, got the eye");
  EXPECT_EQ(refusal_after([](View& view) { view.up.y = kNan; }), "up.y: expected a finite number, got nan");
  EXPECT_EQ(refusal_after([](View& view) { view.up = {}; }),
            "up: expected a direction across the line of sight, got the zero vector");
  EXPECT_EQ(refusal_after([](View& view) {
              view.up = {0, 0, -3};
            }),
            "up: expected a direction across the line of sight, got one along the line of sight");
  EXPECT_EQ(refusal_after([](View& view) { view.fov_degrees = 0; }),
            "fov_degrees: expected between 0 and 180, exclusive, got 0");
  EXPECT_EQ(refusal_after([](View& view) { view.fov_degrees = 180; }),
            "fov_degrees: expected between 0 and 180, exclusive, got 180");
  EXPECT_EQ(refusal_after([](View& view) { view.fov_degrees = kNan; }),
            "fov_degrees: expected between 0 and 180, exclusive, got nan");
  EXPECT_EQ(refusal_after([](View& view) { view.orthographic_height = -1; }),
            "orthographic_height: expected 0..1000000000, got -1");
}

TEST(ViewCheck, NamesWhatIsWrongWithImageAndSampling) {
  EXPECT_EQ(refusal_after([](View& view) { view.width = 0; }), "width: expected 1..4095, got 0");
  EXPECT_EQ(refusal_after([](View& view) { view.height = 4096; }), "height: expected 1..4095, got 4096");
  EXPECT_EQ(refusal_after([](View& view) { view.samples_per_axis = 3; }),
            "samples_per_axis: expected 1, 2 or 4, got 3");
  EXPECT_EQ(refusal_after([](View& view) { view.filter = static_cast<PixelFilter>(7); }),
            "filter: expected kBox or kTent, got 7");
  EXPECT_EQ(refusal_after([](View& view) { view.step = 0; }), "step: expected 0.015625..16, got 0");
  EXPECT_EQ(refusal_after([](View& view) { view.step = kNan; }), "step: expected 0.015625..16, got nan");
  EXPECT_EQ(refusal_after([](View& view) { view.opacity_threshold = 1.01; }),
            "opacity_threshold: expected 0..1, got 1.01");
}

// Every number of a view, its limits, and the next ones beyond.
TEST(ViewCheck, TakesTheLimitsOfEachNumberAndNothingBeyond) {
  struct Case {
    const char* name;
    void (*set)(View&, double);
    double low, high, below, above;
  };
  constexpr double kFar = 1e9, kBeyond = 1e9 + 1e-6;
  const Case cases[] = {
      {"eye.x", [](View& v, double x) { v.eye.x = x; }, -kFar, kFar, -kBeyond, kBeyond},
      {"eye.y", [](View& v, double x) { v.eye.y = x; }, -kFar, kFar, -kBeyond, kBeyond},
      {"eye.z", [](View& v, double x) { v.eye.z = x; }, -kFar, kFar, -kBeyond, kBeyond},
      {"look_at.x", [](View& v, double x) { v.look_at.x = x; }, -kFar, kFar, -kBeyond, kBeyond},
      {"look_at.y", [](View& v, double x) { v.look_at.y = x; }, -kFar, kFar, -kBeyond, kBeyond},
      {"look_at.z", [](View& v, double x) { v.look_at.z = x; }, -kFar, kFar, -kBeyond, kBeyond},
      {"orthographic_height", [](View& v, double x) { v.orthographic_height = x; }, 0, kFar, -1e-9, kBeyond},
      {"width", [](View& v, double x) { v.width = static_cast<int>(x); }, 1, 4095, 0, 4096},
      {"height", [](View& v, double x) { v.height = static_cast<int>(x); }, 1, 4095, 0, 4096},
      {"step", [](View& v, double x) { v.step = x; }, 1.0 / 64, 16, 0.0156, 16.001},
      {"opacity_threshold", [](View& v, double x) { v.opacity_threshold = x; }, 0, 1, -0.001, 1.001},
      {"exposure", [](View& v, double x) { v.exposure = x; }, 0, 1e308, -1e-300,
       std::numeric_limits<double>::infinity()},
      {"lifetime", [](View& v, double x) { v.lifetime = static_cast<int>(x); }, 0, 1023, -1, 1024},
  };
  for (const Case& it : cases) {
    const auto with = [&it](double value) {
      return refusal_after([&](View& view) {
        view.up = {1e-4, 0.5, 0.7};
        it.set(view, value);
      });
    };
    EXPECT_EQ(with(it.low), "accepted") << it.name;
    EXPECT_EQ(with(it.high), "accepted") << it.name;
    EXPECT_EQ(with(it.below).substr(0, std::string(it.name).size() + 10), std::string(it.name) + ": expected");
    EXPECT_EQ(with(it.above).substr(0, std::string(it.name).size() + 10), std::string(it.name) + ": expected");
  }
  for (const int samples : {0, 1, 2, 3, 4, 5, 8}) {
    const bool good = samples == 1 || samples == 2 || samples == 4;
    EXPECT_EQ(refusal_after([&](View& view) { view.samples_per_axis = samples; }) == "accepted", good) << samples;
  }
  EXPECT_EQ(refusal_after([](View& view) { view.filter = PixelFilter::kTent; }), "accepted");
  EXPECT_EQ(refusal_after([](View& view) { view.up = {2e-6, 0, 1}; }), "accepted");
  EXPECT_NE(refusal_after([](View& view) { view.up = {0.5e-6, 0, 1}; }), "accepted");
}

TEST(ViewCheck, NamesTheCutPlaneThatIsWrong) {
  EXPECT_EQ(refusal_after([](View& view) {
              view.cut_planes.assign(7, CutPlane{{0, 0, 1}, 0});
            }),
            "cut_planes: expected at most 6, got 7");
  EXPECT_EQ(refusal_after([](View& view) {
              view.cut_planes = {{{1, 0, 0}, 3}, {{0, 0, 0}, 3}};
            }),
            "cut_planes[1].normal: expected any length but 0, got 0");
  EXPECT_EQ(refusal_after([](View& view) {
              view.cut_planes = {{{1, kNan, 0}, 3}};
            }),
            "cut_planes[0].normal.y: expected a finite number, got nan");
  EXPECT_EQ(refusal_after([](View& view) {
              view.cut_planes = {{{1, 0, 0}, kNan}};
            }),
            "cut_planes[0].offset: expected a finite number, got nan");
  EXPECT_EQ(refusal_after([](View& view) {
              view.cut_planes = {{{0, 0.5, 0}, 524288}};
            }),
            "cut_planes[0].offset: expected a plane within 1048576 voxels of the origin, got 1048576 voxels");
  EXPECT_EQ(refusal_after([](View& view) { view.cut_planes = {{{0, 0.5, 0}, 524287}}; }), "accepted");
}

}  // namespace
}  // namespace gicube
