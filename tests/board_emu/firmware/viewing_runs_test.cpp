// Rays that processors extrapolate, against those that the DSP makes one by one.
#include "firmware/viewing_runs.h"

#include "commands_rig.h"
#include "firmware/framebuffer.h"
#include "firmware/ray_sources/image_rays.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr int kEdge = 65, kImage = 96;
constexpr double kUnits = wire::kVoxel;

struct Image {
  explicit Image(wire::RenderCommand view, const RunRules& rules = {}) : command(view) {
    frame.extent = {(kEdge - 1) << 14, (kEdge - 1) << 14, (kEdge - 1) << 14};
    frame.lifetime = 7;
    rays.emplace(command, frame, framebuffer, rules);
  }
  std::vector<std::optional<wire::Ray>> all() {
    std::vector<std::optional<wire::Ray>> out;
    RayCounters counters;
    for (std::uint64_t i = 0; i < rays->count(); ++i) out.push_back(rays->make(i, counters));
    return out;
  }
  std::uint64_t runs() const {
    std::uint64_t count = 0;
    for (std::uint64_t i = 0; i < rays->count(); i = rays->run_end(i)) ++count;
    return count;
  }

  wire::RenderCommand command;
  Frame frame;
  Framebuffer framebuffer;
  std::optional<ImageRays> rays;
};

wire::RenderCommand view_of(const char* kind) {
  wire::RenderCommand view = corner_view({kEdge, kEdge, kEdge}, kImage);
  if (std::string(kind) == "parallel") {
    view.projection = wire::Projection::kOrthographic;
    view.origin = {-10, -20, -30};
    view.forward = {0.4, 0.5, 0.6};
    view.du = {0.9, -0.5, -0.2};
    view.dv = {-0.1, 0.8, -0.6};
  }
  return view;
}

// Voxels, on an axis, by which a ray lies off at its start or where it has gone all its way.
double error(const wire::Ray& a, const wire::Ray& b, double way) {
  double most = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    most =
        std::max(most, std::abs(static_cast<double>(a.position[axis]) - b.position[axis]) / kUnits +
                           way * std::abs(a.direction[axis] - b.direction[axis]) / (1 << wire::kDirectionFractionBits));
  }
  return most;
}

class Runs : public testing::TestWithParam<const char*> {};

TEST_P(Runs, HaveRaysThatLieWhereTheyWouldAloneToWithinTheError) {
  const auto alone = Image(view_of(GetParam())).all();
  // Both are rounded to words: half a unit at the start, and half a unit of the direction all the way.
  const double rounding = 2 / kUnits + kEdge * 1.8 * 2 / (1 << wire::kDirectionFractionBits);
  for (const std::uint32_t units : {16u, 256u, 1024u, 16384u}) {
    const auto extrapolated = Image(view_of(GetParam()), {64, units}).all();
    double most = 0;
    for (std::size_t i = 0; i < alone.size(); ++i) {
      ASSERT_EQ(alone[i].has_value(), extrapolated[i].has_value()) << i;
      if (!alone[i]) continue;
      EXPECT_EQ(alone[i]->u, extrapolated[i]->u);
      EXPECT_EQ(alone[i]->v, extrapolated[i]->v);
      EXPECT_EQ(alone[i]->lifetime, extrapolated[i]->lifetime);
      most = std::max(most, error(*alone[i], *extrapolated[i], kEdge * 1.8));
    }
    EXPECT_LT(most, 1.5 * units / kUnits + rounding) << units;
  }
}

TEST_P(Runs, AreTheFewerTheMoreTheyMayErr) {
  std::uint64_t before = kImage * kImage + 1;
  for (const std::uint32_t units : {1u, 256u, 16384u}) {
    const std::uint64_t runs = Image(view_of(GetParam()), {64, units}).runs();
    EXPECT_LE(runs, before);
    before = runs;
  }
  EXPECT_LT(before, kImage * kImage / 6u);
}

TEST_P(Runs, AreTheSameRaysInTilesAndOneByOne) {
  for (const std::uint32_t length : {4u, 24u, 64u}) {
    Image one(view_of(GetParam()), {length, 1024}), tiles(view_of(GetParam()), {length, 1024});
    std::vector<wire::Ray> expected, got;
    for (const auto& ray : one.all()) {
      if (ray) expected.push_back(*ray);
    }
    for (std::size_t b = 0; b < tiles.rays->divide(1); ++b) {
      const auto batch = tiles.rays->make_batch(b);
      got.insert(got.end(), batch->rays.begin(), batch->rays.end());
    }
    const auto by_place = [](const wire::Ray& a, const wire::Ray& b) {
      return std::pair(a.v, a.u) < std::pair(b.v, b.u);
    };
    std::ranges::sort(expected, by_place);
    std::ranges::sort(got, by_place);
    EXPECT_EQ(got, expected);
    EXPECT_EQ(one.framebuffer.packed(), tiles.framebuffer.packed()) << "of those that miss";
  }
}

TEST_P(Runs, EndWhereTheNextRayEntersByAnotherFace) {
  Image image(view_of(GetParam()), {64, 16384});
  const auto face = [&image](std::uint64_t i) {
    const Line line =
        viewing_line(image.command, static_cast<double>(i % kImage) + 0.5, static_cast<double>(i / kImage) + 0.5);
    const auto where = entry(line, image.frame.extent, {});
    return where ? where->face : -2;
  };
  for (std::uint64_t i = 0; i < image.rays->count(); i = image.rays->run_end(i)) {
    EXPECT_EQ(face(i), face(image.rays->run_end(i) - 1)) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Views, Runs, testing::Values("perspective", "parallel"),
                         [](const auto& test) { return std::string(test.param); });

TEST(ViewingRuns, OfParallelRaysThroughAFaceAreAsLongAsTheyMayBe) {
  Image image(view_of("parallel"), {64, 1});
  std::uint64_t longest = 0;
  for (std::uint64_t i = 0; i < image.rays->count(); i = image.rays->run_end(i))
    longest = std::max(longest, image.rays->run_end(i) - i);
  EXPECT_GE(longest, 16u);
}

TEST(ViewingRuns, OfFewerThanFourRaysAreNone) {
  Image image(view_of("perspective"), {64, 1});
  for (std::uint64_t i = 0; i < image.rays->count(); i = image.rays->run_end(i)) {
    const std::uint64_t length = image.rays->run_end(i) - i;
    EXPECT_TRUE(length == 1 || length >= 4 ||
                !viewing_ray(viewing_line(image.command, static_cast<double>(i % kImage) + 0.5,
                                          static_cast<double>(i / kImage) + 0.5),
                             0, 0, image.frame.extent, {}))
        << length;
    EXPECT_EQ(image.rays->making(i).loop == &kMakeRun, length > 1);
  }
}

}  // namespace
}  // namespace gicube::emu
