#include "gicube/scene/light.h"

#include "gicube/scene/error.h"
#include "test.h"

namespace gicube::scene {
namespace {

std::string fault_of(const Light& light) {
  try {
    check(SceneLight{"", light, {1, 1, 1}});
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(SceneLight, IsCheckedByField) {
  const double nan = std::nan("");
  EXPECT_EQ(fault_of(PointLight{{1, 2, 3}, 1}), "none");
  EXPECT_THAT(fault_of(PointLight{{1, nan, 3}, 1}), StartsWith("point.position: expected finite numbers, got 1 nan 3"));
  EXPECT_THAT(fault_of(PointLight{{1, 2, 3}, 0}), StartsWith("power: expected a number above 0, got 0"));
  EXPECT_THAT(fault_of(DirectionalLight{{0, 0, 0}, 1}), StartsWith("towards: expected a direction"));
  EXPECT_THAT(fault_of(RectangleLight{{}, {1, 2, 0}, {2, 4, 0}, 1}), StartsWith("rectangle.edge_v"));
  EXPECT_THAT(fault_of(RectangleLight{{}, {0, 0, 0}, {2, 4, 0}, 1}), StartsWith("rectangle.edge_v"));
  EXPECT_THAT(fault_of(SphereLight{{}, 0, 1}), StartsWith("sphere.radius"));
  EXPECT_THAT(fault_of(SphereLight{{}, 1, nan}), StartsWith("power"));
}

TEST(SceneLight, StandsInVoxelsAndKeepsItsPower) {
  const WorldGrid grid{{-1, -2, -3}, 0.5, {5, 9, 13}};
  const auto point = std::get<PointLight>(in_voxels(PointLight{{0, 0, 0}, 7}, grid));
  EXPECT_EQ(point.position, (Vec3{2, 4, 6}));
  EXPECT_EQ(point.power, 7);
  const auto rectangle = std::get<RectangleLight>(in_voxels(RectangleLight{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, 7}, grid));
  EXPECT_EQ(rectangle.edge_u, (Vec3{2, 0, 0}));
  EXPECT_EQ(rectangle.power, 7);
  EXPECT_EQ(std::get<SphereLight>(in_voxels(SphereLight{{0, 0, 0}, 3, 7}, grid)).radius, 6);
  // A voxel's face is a quarter of a unit of area.
  EXPECT_EQ(std::get<DirectionalLight>(in_voxels(DirectionalLight{{0, 0, 1}, 8}, grid)).irradiance, 2);
}

TEST(SceneLight, IsScaledInItsPowerAlone) {
  const auto light = std::get<SphereLight>(scaled(SphereLight{{1, 2, 3}, 3, 8}, 0.25));
  EXPECT_EQ(light.power, 2);
  EXPECT_EQ(light.radius, 3);
  EXPECT_EQ(std::get<DirectionalLight>(scaled(DirectionalLight{{0, 0, 1}, 8}, 0.25)).irradiance, 2);
}

}  // namespace
}  // namespace gicube::scene
