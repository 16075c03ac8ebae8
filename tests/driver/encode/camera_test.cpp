#include "encode/camera.h"

#include "test.h"

namespace gicube {
namespace {

Vec3 to_vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }
Vec3 times(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

void expect_near(Vec3 got, Vec3 expected, double tolerance = 1e-12) {
  EXPECT_NEAR(got.x, expected.x, tolerance);
  EXPECT_NEAR(got.y, expected.y, tolerance);
  EXPECT_NEAR(got.z, expected.z, tolerance);
}

// The ray through an image point, as command.h says the DSP makes it; voxel space.
struct Line {
  Vec3 origin, direction;
};

Line line_at(const wire::RenderCommand& command, double x, double y) {
  const Vec3 offset = x * to_vector(command.du) + y * to_vector(command.dv);
  const Vec3 origin = to_vector(command.origin), forward = to_vector(command.forward);
  if (command.projection == wire::Projection::kPerspective) return {origin, forward + offset};
  return {origin + offset, forward};
}

double distance_to(Line line, Vec3 p) {
  return length(cross(p - line.origin, line.direction)) / length(line.direction);
}

View skew_view() {
  View view;
  view.eye = {10, -20, 70};
  view.look_at = {31, 12, 5};
  view.up = {0.1, 1, 0.2};
  view.width = 320;
  view.height = 200;
  return view;
}

const std::vector<Vec3> kSpacings{{1, 1, 1}, {1, 1.5, 4}, {64, 1, 1}};

TEST(Camera, TheMiddleOfTheImageLooksAtLookAt) {
  for (const Vec3 spacing : kSpacings) {
    for (const double height : {0.0, 50.0}) {
      View view = skew_view();
      view.orthographic_height = height;
      const Line middle = line_at(viewing_command(view, spacing), 160, 100);
      EXPECT_LT(distance_to(middle, view.look_at), 1e-9);
      EXPECT_LT(distance_to(middle, view.eye), 1e-9);
      EXPECT_GT(dot(middle.direction, view.look_at - view.eye), 0);
    }
  }
}

TEST(Camera, PerspectiveCornersOfAPlainViewByHand) {
  View view;
  view.eye = {0, 0, 10};
  view.look_at = {0, 0, 0};
  view.fov_degrees = 90;
  view.width = 200;
  view.height = 100;
  const auto command = viewing_command(view, {1, 1, 1});
  EXPECT_EQ(command.projection, wire::Projection::kPerspective);
  // Seen along -z with y up, x is to the right. Half the height is tan 45 = 1 at distance 1; the width is twice that.
  expect_near(line_at(command, 0, 0).direction, {-2, 1, -1});
  expect_near(line_at(command, 200, 0).direction, {2, 1, -1});
  expect_near(line_at(command, 0, 100).direction, {-2, -1, -1});
  expect_near(line_at(command, 200, 100).direction, {2, -1, -1});
  expect_near(line_at(command, 37, 11).origin, {0, 0, 10});
}

TEST(Camera, OrthographicHeightIsTheImagesHeight) {
  View view;
  view.eye = {5, 5, -10};
  view.look_at = {5, 5, 0};
  view.orthographic_height = 8;
  view.width = 40;
  view.height = 20;
  const auto command = viewing_command(view, {1, 1, 1});
  EXPECT_EQ(command.projection, wire::Projection::kOrthographic);
  // Seen along +z with y up, right = forward x up is -x.
  expect_near(line_at(command, 0, 0).origin, {5 + 8, 5 + 4, -10});
  expect_near(line_at(command, 40, 20).origin, {5 - 8, 5 - 4, -10});
  expect_near(line_at(command, 3, 4).direction, {0, 0, 1});
}

TEST(Camera, OrthographicHeightIsInTheSmallestEdges) {
  View view;
  view.eye = {5, 5, -10};
  view.look_at = {5, 5, 0};
  view.orthographic_height = 8;
  // Voxels twice as high: the image shows half as many of them.
  const auto command = viewing_command(view, {1, 2, 1});
  EXPECT_NEAR(line_at(command, 0, 0).origin.y - line_at(command, 0, 512).origin.y, 4, 1e-12);
  EXPECT_NEAR(line_at(command, 0, 0).origin.x - line_at(command, 512, 0).origin.x, 8, 1e-12);
}

TEST(Camera, TheFieldOfViewIsVerticalAndPhysical) {
  for (const Vec3 spacing : kSpacings) {
    const View view = skew_view();
    const auto command = viewing_command(view, spacing);
    const Vec3 top = times(spacing, line_at(command, 160, 0).direction);
    const Vec3 bottom = times(spacing, line_at(command, 160, 200).direction);
    EXPECT_NEAR(std::acos(dot(normalise(top), normalise(bottom))) * 180 / std::numbers::pi, 30, 1e-9);
  }
}

TEST(Camera, PixelsArePhysicalSquaresWithUpUpwards) {
  for (const Vec3 spacing : kSpacings) {
    for (const double height : {0.0, 50.0}) {
      View view = skew_view();
      view.orthographic_height = height;
      const auto command = viewing_command(view, spacing);
      const Vec3 du = times(spacing, to_vector(command.du)), dv = times(spacing, to_vector(command.dv));
      const Vec3 forward = times(spacing, view.look_at - view.eye), up = times(spacing, view.up);
      EXPECT_NEAR(length(du) / length(dv), 1, 1e-12);
      EXPECT_NEAR(dot(normalise(du), normalise(dv)), 0, 1e-12);
      EXPECT_NEAR(dot(normalise(du), normalise(forward)), 0, 1e-12);
      EXPECT_NEAR(dot(normalise(dv), normalise(forward)), 0, 1e-12);
      EXPECT_LT(dot(dv, up), 0);                  // rows run downwards
      EXPECT_GT(dot(du, cross(forward, up)), 0);  // columns to the right
      EXPECT_NEAR(dot(normalise(du), normalise(up)), 0, 1e-12);
    }
  }
}

// The image point at which a voxel-space point appears, orthographic.
std::array<double, 2> project(const wire::RenderCommand& command, Vec3 spacing, Vec3 p) {
  const Vec3 from = times(spacing, p - to_vector(command.origin));
  const Vec3 du = times(spacing, to_vector(command.du)), dv = times(spacing, to_vector(command.dv));
  return {dot(from, du) / dot(du, du), dot(from, dv) / dot(dv, dv)};
}

TEST(Camera, APhysicalSphereIsACircleInTheImage) {
  const Vec3 spacing{1, 2, 3};
  View view = skew_view();
  view.orthographic_height = 40;
  const auto command = viewing_command(view, spacing);
  double greatest = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double z = 1 - (2 * i + 1.0) / 20'000, r = std::sqrt(1 - z * z), angle = i * 2.399963;
    const Vec3 on_sphere{r * std::cos(angle) * 10 / spacing.x, r * std::sin(angle) * 10 / spacing.y,
                         z * 10 / spacing.z};
    const auto [x, y] = project(command, spacing, view.look_at + on_sphere);
    // Radius 10 edges at 200 rows for 40 edges: no point is farther than 50 pixels from the middle.
    EXPECT_LT(std::hypot(x - 160, y - 100), 50 + 1e-9);
    greatest = std::max(greatest, std::hypot(x - 160, y - 100));
  }
  EXPECT_GT(greatest, 49.99);
}

TEST(Camera, CarriesTheImagesFields) {
  View view = skew_view();
  view.samples_per_axis = 4;
  view.filter = PixelFilter::kTent;
  const auto command = viewing_command(view, {1, 1, 1});
  EXPECT_EQ(command.width, 320);
  EXPECT_EQ(command.height, 200);
  EXPECT_EQ(command.samples_per_axis, 4);
  EXPECT_EQ(command.filter, wire::Filter::kTent);
  view.filter = PixelFilter::kBox;
  EXPECT_EQ(viewing_command(view, {1, 1, 1}).filter, wire::Filter::kBox);
}

TEST(Camera, TowardsEyeIsPhysicalAndUnit) {
  View view;
  view.eye = {3, 0, 1};
  view.look_at = {0, 0, 0};
  expect_near(towards_eye(view, {1, 1, 1}), (1 / std::sqrt(10)) * Vec3{3, 0, 1});
  expect_near(towards_eye(view, {1, 1, 4}), {0.6, 0, 0.8});
}

}  // namespace
}  // namespace gicube
