// Damage anywhere in a mesh's file ends in an error that names it, or in a mesh, never in a crash.
#include "../damage.h"
#include "gicube/scene/error.h"
#include "scene/geometry/mesh_distance.h"
#include "scene/geometry/mesh_file.h"
#include "test.h"
#include "test_meshes.h"

namespace gicube::scene {
namespace {

constexpr int kRounds = 2000;  // chosen: a second with sanitizers
constexpr std::string_view kLikely = "0123456789-. \nef";

std::string as_obj(const Mesh& mesh) {
  std::string text;
  for (const Vec3& p : mesh.points) {
    text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    text += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " + std::to_string(c + 1) + "\n";
  }
  return text;
}

std::string as_ply(const Mesh& mesh, bool ascii) {
  std::string text = std::string("ply\nformat ") + (ascii ? "ascii" : "binary_little_endian") +
                     " 1.0\nelement vertex " + std::to_string(mesh.points.size()) +
                     "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                     std::to_string(mesh.triangles.size()) + "\nproperty list uchar uint vertex_indices\nend_header\n";
  const auto put = [&text, ascii](auto value) {
    if (ascii) {
      text += std::to_string(value) + " ";
    } else {
      text.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  };
  for (const Vec3& p : mesh.points) put(p.x), put(p.y), put(p.z);
  for (const auto& triangle : mesh.triangles) {
    put(std::uint8_t{3});
    for (const std::uint32_t corner : triangle) put(corner);
  }
  return text;
}

template <typename Parse>
void damage(const std::string& whole, const Parse& parse) {
  EXPECT_NEAR(MeshDistance(parse(whole), "whole").at({0, 0, 0.2}).distance, -0.8, 1e-6);
  std::mt19937 random(11);
  int refused = 0;
  for (int round = 0; round < kRounds; ++round) {
    try {
      const Distance d = MeshDistance(parse(damaged(whole, kLikely, random)), "damaged").at({0.1, 0.2, 0.3});
      EXPECT_TRUE(std::isfinite(d.distance));
    } catch (const FileError&) {
      ++refused;
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, kRounds / 10);
  EXPECT_LT(refused, kRounds);
}

TEST(DamagedMeshes, OfObjAreReadOrRefused) {
  damage(as_obj(cube_mesh()), [](const std::string& text) { return parse_obj(text, "a.obj"); });
}

TEST(DamagedMeshes, OfAsciiPlyAreReadOrRefused) {
  damage(as_ply(cube_mesh(), true), [](const std::string& text) { return parse_ply(text, "a.ply"); });
}

TEST(DamagedMeshes, OfBinaryPlyAreReadOrRefused) {
  damage(as_ply(cube_mesh(), false), [](const std::string& text) { return parse_ply(text, "a.ply"); });
}

}  // namespace
}  // namespace gicube::scene
