#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "test.h"

namespace gicube::scene {
namespace {

// The greatest |x| and |y| of the box's corners in the image, 1 being its edge.
std::array<double, 2> seen_extent(const Dims& dims, Vec3 spacing, const View& view) {
  const double least = std::min({spacing.x, spacing.y, spacing.z});
  const auto physical = [&](Vec3 p) {
    return Vec3{p.x * spacing.x / least, p.y * spacing.y / least, p.z * spacing.z / least};
  };
  const Vec3 eye = physical(view.eye), forward = normalise(physical(view.look_at) - eye);
  const Vec3 right = normalise(cross(forward, view.up)), up = cross(right, forward);
  const double tangent = std::tan(view.fov_degrees * std::numbers::pi / 360);
  std::array<double, 2> extent{};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p = physical(
        {(corner & 1) * (dims[0] - 1.0), (corner >> 1 & 1) * (dims[1] - 1.0), (corner >> 2) * (dims[2] - 1.0)});
    const double depth = dot(p - eye, forward);
    EXPECT_GT(depth, 0);
    extent[0] = std::max(extent[0], std::abs(dot(p - eye, right)) / (depth * tangent * view.width / view.height));
    extent[1] = std::max(extent[1], std::abs(dot(p - eye, up)) / (depth * tangent));
  }
  return extent;
}

TEST(Camera, FitsTheWholeVolumeIntoTheImageWhenNothingIsAskedFor) {
  for (const Vec3 spacing : {Vec3{1, 1, 1}, Vec3{0.5, 0.5, 2}}) {
    for (const int width : {300, 512, 900}) {
      View view;
      view.width = width;
      const Dims dims{120, 200, 90};
      fit_camera({}, whole_box(dims), spacing, view);
      const auto [x, y] = seen_extent(dims, spacing, view);
      EXPECT_LT(std::max(x, y), 1);
      EXPECT_GT(std::max(x, y), 0.9);
      EXPECT_EQ(view.look_at, (Vec3{59.5, 99.5, 44.5}));
      EXPECT_LT(view.eye.y, 0);
    }
  }
}

TEST(Camera, TakesWhatIsAskedFor) {
  View view;
  CameraSettings camera;
  camera.eye = Vec3{1, 2, -300};
  camera.look_at = Vec3{1, 2, 3};
  camera.fov_degrees = 40;
  fit_camera(camera, whole_box({64, 64, 64}), {1, 1, 1}, view);
  EXPECT_EQ(view.eye, (Vec3{1, 2, -300}));
  EXPECT_EQ(view.look_at, (Vec3{1, 2, 3}));
  EXPECT_EQ(view.fov_degrees, 40);
  EXPECT_EQ(view.up, (Vec3{0, 1, 0})) << "+z is along the line of sight";
}

TEST(Camera, KeepsTheEyeBeforeTheBoxInOrthographicViews) {
  View view;
  CameraSettings camera;
  camera.orthographic_height = 50;
  fit_camera(camera, whole_box({100, 100, 100}), {1, 1, 1}, view);
  EXPECT_EQ(view.orthographic_height, 50);
  const Vec3 forward = normalise(view.look_at - view.eye);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p{(corner & 1) * 99.0, (corner >> 1 & 1) * 99.0, (corner >> 2) * 99.0};
    EXPECT_GT(dot(p - view.eye, forward), 0);
  }
}

TEST(Camera, RefusesAnImpossibleFieldOfView) {
  View view;
  CameraSettings camera;
  camera.fov_degrees = 180;
  EXPECT_THROW(fit_camera(camera, whole_box({64, 64, 64}), {1, 1, 1}, view), InputError);
}

TEST(Camera, HasItsLightAboveTheLeftShoulder) {
  View view;
  view.eye = {0, -100, 0};
  view.look_at = {0, 0, 0};
  view.up = {0, 0, 1};
  const Vec3 light = shoulder_light(view, {1, 1, 1});
  EXPECT_LT(light.x, 0);
  EXPECT_LT(light.y, -0.9);
  EXPECT_GT(light.z, 0);
}

TEST(SceneSetup, GivesTheBuckyballItsMaterialsLightAndCamera) {
  Scene scene;
  scene.volume.builtin = "buckyball";
  scene.volume.size = 32;
  SceneSetup setup = set_up(scene);
  EXPECT_EQ(setup.volume.dims, (Dims{32, 32, 32}));
  EXPECT_EQ(setup.materials.size(), 4u);
  EXPECT_EQ(setup.volume_view().tags.size(), 32u * 32 * 32);
  EXPECT_EQ(setup.volume_view().gradients.size(), 3u * 32 * 32 * 32);
  EXPECT_GT(length(setup.shading.light), 0);
  EXPECT_TRUE(setup.background.has_value());
  setup.free_voxels();
  EXPECT_TRUE(setup.volume_view().samples.empty());
}

TEST(SceneSetup, PutsTheUsersWishesFirst) {
  Scene scene;
  scene.volume.builtin = "buckyball";
  scene.volume.size = 32;
  scene.light = Vec3{0, 0, 1};
  scene.phong = Phong{0.1, 0.2, 0.3, 4};
  scene.transfer_function = find_preset("ramp");
  scene.volume.spacing = Vec3{1, 1, 2};
  const SceneSetup setup = set_up(scene);
  EXPECT_EQ(setup.shading.light, (Vec3{0, 0, 1}));
  EXPECT_EQ(setup.shading.phong.shininess, 4);
  EXPECT_EQ(setup.volume.spacing, (Vec3{1, 1, 2}));
  for (const TransferFunctionFile& material : setup.materials) EXPECT_EQ(material.scale, TransferScale::kNormalised);
}

TEST(SceneSetup, KnowsNoOtherBuiltin) {
  Scene scene;
  scene.volume.builtin = "teapot";
  EXPECT_THROW(set_up(scene), InputError);
}

}  // namespace
}  // namespace gicube::scene
