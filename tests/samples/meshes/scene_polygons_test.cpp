// Which nodes of a scene stay polygons.
#include "meshes/scene_polygons.h"

#include <gtest/gtest.h>

#include "gicube/scene/error.h"
#include "meshes/triangulate.h"

namespace gicube::samples {
namespace {

const std::string kMaterials = R"(
  material { name: "white" solid { } scattering: 0.5 scattering_colour { green: 0.5 blue: 0 } bsdf: "diffuse" }
  material { name: "lamp" solid { } emission: 3 emission_colour { red: 1 green: 1 blue: 0.5 } }
  material { name: "fog" fog { extinction: 1 } } )";

Scene scene_of(const std::string& nodes) {
  return parse_scene("world { size: 9 " + nodes + " }" + kMaterials, "x", ".");
}

TEST(Polygons, AreTheBoxesAndMeshesOfSolidsWithTheirTransforms) {
  Scene scene = scene_of(
      "node { transform { translate { x: 5 } } material: \"white\" child { name: \"a\" transform { scale { all: 2 } } "
      "box { } } "
      "child { name: \"b\" material: \"lamp\" box { high { z: 2 } } } }"
      "node { material: \"fog\" sphere { radius: 0.5 } }");
  const auto surfaces = take_polygons(scene);
  ASSERT_EQ(surfaces.size(), 2u);
  EXPECT_EQ(surfaces[0].name, "a");
  double low = 99, high = -99;
  for (const Vec3& point : surfaces[0].mesh.points) low = std::min(low, point.x), high = std::max(high, point.x);
  EXPECT_EQ(low, 3);
  EXPECT_EQ(high, 7);
  EXPECT_EQ(surfaces[0].albedo, (std::array{0.5, 0.25, 0.0}));
  EXPECT_EQ(surfaces[1].emission, (std::array{3.0, 3.0, 1.5}));
  EXPECT_EQ(surfaces[1].albedo, (std::array{0.0, 0.0, 0.0}));
  EXPECT_TRUE(std::holds_alternative<Group>(scene.world->root.children[0].children[0].content));
  EXPECT_TRUE(std::holds_alternative<Shape>(scene.world->root.children[1].content));
}

TEST(Polygons, AreClosedIfEachEdgeHasTwoTriangles) {
  Mesh box = mesh_of(BoxShape{{0, 0, 0}, {1, 2, 3}});
  EXPECT_TRUE(is_closed(box));
  EXPECT_TRUE(is_closed(refined(box, 0.5)));
  box.triangles.pop_back();
  EXPECT_FALSE(is_closed(box));
  box = mesh_of(BoxShape{{0, 0, 0}, {1, 2, 3}});
  std::swap(box.triangles[0][0], box.triangles[0][1]);  // turned round
  EXPECT_FALSE(is_closed(box));
}

TEST(Polygons, RefuseByName) {
  const auto refused = [](const std::string& nodes, const std::string& materials = "") {
    try {
      Scene scene = parse_scene("world { size: 9 " + nodes + " }" + kMaterials + materials, "x", ".");
      take_polygons(scene);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_EQ(refused("node { name: \"ball\" material: \"white\" sphere { } }"),
            "node[ball]: shape: expected a mesh or a box without rounding, of a solid, got another one");
  EXPECT_EQ(refused("node { name: \"m\" material: \"mirror\" box { } }",
                    "material { name: \"mirror\" solid { } scattering: 1 bsdf: \"specular\" }"),
            "node[m]: material.bsdf: expected diffuse, got another one");
  EXPECT_EQ(refused("node { name: \"m\" material: \"veil\" box { } }",
                    "material { name: \"veil\" solid { opacity: 0.5 } scattering: 1 bsdf: \"diffuse\" }"),
            "node[m]: material.opacity: expected 1, got 0.500000");
  EXPECT_EQ(refused("node { material: \"fog\" box { } }"),
            "world.node: expected at least one mesh or box of a solid, got none");
}

}  // namespace
}  // namespace gicube::samples
