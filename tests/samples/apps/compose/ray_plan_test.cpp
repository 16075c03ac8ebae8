#include "compose/ray_plan.h"

#include "test.h"

namespace gicube::samples {
namespace {

// Along x; one unit of the common space is `scale` voxels.
Span span(std::size_t volume, double near, double far, double scale = 1) {
  return {volume, near, far, {-near * scale, 0, 0}, {scale, 0, 0}};
}
SurfacePoint surface(double distance, double opacity) { return {distance, {{opacity, 0, 0}, opacity}}; }

RayPlan planned(const std::vector<Span>& spans, const std::vector<SurfacePoint>& surfaces, double overlap_step = 1) {
  RayPlan plan;
  plan_ray(spans, surfaces, overlap_step, plan);
  return plan;
}

TEST(RayPlan, OfOneVolumeIsOneSegment) {
  const RayPlan plan = planned({span(3, 2, 12, 4)}, {});
  ASSERT_EQ(plan.segments.size(), 1u);
  EXPECT_EQ(plan.segments[0].volume, 3u);
  EXPECT_EQ(plan.segments[0].from, (Vec3{0, 0, 0}));
  EXPECT_EQ(plan.segments[0].to, (Vec3{40, 0, 0}));
  EXPECT_EQ(plan.layers.size(), 1u);
}

TEST(RayPlan, CutsASegmentAtEachSurfaceAndEndsAtAnOpaqueOne) {
  const RayPlan plan = planned({span(0, 2, 12)}, {surface(1, 0.5), surface(5, 0.25), surface(9, 1), surface(10, 0.5)});
  std::vector<double> looks;
  for (const Layer& layer : plan.layers) looks.push_back(layer.segments > 0 ? -1 : layer.surface.opacity);
  EXPECT_EQ(looks, (std::vector<double>{0.5, -1, 0.25, -1, 1}));
  ASSERT_EQ(plan.segments.size(), 2u);
  EXPECT_EQ(plan.segments[0].to, (Vec3{3, 0, 0}));
  EXPECT_EQ(plan.segments[1].from, (Vec3{3, 0, 0}));
  EXPECT_EQ(plan.segments[1].to, (Vec3{7, 0, 0}));
}

TEST(RayPlan, KeepsSurfacesOutsideOfAllVolumes) {
  const RayPlan plan = planned({span(0, 2, 4)}, {surface(1, 0.5), surface(7, 0.5)});
  ASSERT_EQ(plan.layers.size(), 3u);
  EXPECT_EQ(plan.layers[1].segments, 1u);
  EXPECT_EQ(planned({span(0, 2, 4)}, {surface(1, 1)}).segments.size(), 0u);
  EXPECT_EQ(planned({}, {}).layers.size(), 0u);
}

TEST(RayPlan, CutsOverlapsIntoPiecesOfTheFinestVolume) {
  // Alone 0..4, both 4..10 with 2 voxels a unit in the finer, alone 10..12.
  const RayPlan plan = planned({span(0, 0, 10), span(1, 4, 12, 2)}, {}, 1);
  ASSERT_EQ(plan.layers.size(), 1u + 12u + 1u);
  EXPECT_EQ(plan.segments.size(), 1u + 24u + 1u);
  for (std::size_t i = 1; i < 13; ++i) EXPECT_EQ(plan.layers[i].segments, 2u);
  double along = 0;  // the pieces of the finer one follow each other without a gap
  for (const PlannedSegment& segment : plan.segments) {
    if (segment.volume != 1) continue;
    EXPECT_DOUBLE_EQ(segment.from.x, along);
    along = segment.to.x;
  }
  EXPECT_DOUBLE_EQ(along, 16);
}

TEST(RayPlan, LeavesOutPiecesThatOnlyRoundingMakes) {
  EXPECT_EQ(planned({span(0, 1, 5), span(1, 1 + 1e-13, 5)}, {}, 100).layers.size(), 1u);
}

Premultiplied medium(double depth, double red, double blue) {
  const double opacity = -std::expm1(-depth);
  return {{red * opacity, 0, blue * opacity}, opacity};
}

TEST(Mixed, IsExactForUniformMedia) {
  // Of two uniform media the light is (1 - T) times the mean colour by optical depth.
  for (const double a : {1e-9, 0.01, 0.5, 4.0}) {
    for (const double b : {1e-9, 0.02, 1.0, 9.0}) {
      const std::vector<Premultiplied> media{medium(a, 1, 0), medium(b, 0, 0.5)};
      const Premultiplied sum = mixed(media);
      const double opacity = -std::expm1(-a - b);
      EXPECT_NEAR(sum.opacity, opacity, 1e-15);
      EXPECT_NEAR(sum.colour[0], opacity * a / (a + b), 1e-13);
      EXPECT_NEAR(sum.colour[2], opacity * 0.5 * b / (a + b), 1e-13);
    }
  }
}

TEST(Mixed, LeavesAnOpaqueMediumAloneAndSharesAmongSeveral) {
  const Premultiplied red{{1, 0, 0}, 1}, blue{{0, 0, 1}, 1};
  const std::vector<Premultiplied> one{red, medium(2, 0, 1)}, two{red, blue}, none{{}, {}};
  EXPECT_EQ(mixed(one), red);
  EXPECT_EQ(mixed(two), (Premultiplied{{0.5, 0, 0.5}, 1}));
  EXPECT_EQ(mixed(none), (Premultiplied{}));
}

TEST(Mixed, DoesNotDependOnTheOrder) {
  const std::vector<Premultiplied> ab{medium(0.3, 1, 0), medium(0.7, 0, 1)}, ba{ab[1], ab[0]};
  EXPECT_NEAR(mixed(ab).colour[0], mixed(ba).colour[0], 1e-16);
  EXPECT_NEAR(mixed(ab).opacity, mixed(ba).opacity, 1e-16);
}

TEST(Over, IsPorterAndDuffs) {
  EXPECT_EQ(over({{0.25, 0, 0}, 0.5}, {{0, 0.5, 0}, 0.75}), (Premultiplied{{0.25, 0.25, 0}, 0.875}));
}

}  // namespace
}  // namespace gicube::samples
