// Scenes, compositions, transfer functions with the LUT that they become, and meshes with their distances.
#include <algorithm>
#include <cmath>

#include "compose/composition.h"
#include "encode/look_up_tables.h"
#include "gicube/error.h"
#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "gicube/scene/transfer_function_file.h"
#include "scene/geometry/mesh_distance.h"
#include "scene/geometry/mesh_file.h"
#include "scene/names.h"
#include "targets.h"

namespace gicube::fuzz {
namespace {

constexpr std::size_t kMaxTriangles = 500;  // chosen: keeps an input's distances below a millisecond

}  // namespace

void scene(Bytes input) {
  try {
    samples::parse_scene(std::string(text_of(input)), "input", "no/such/folder");
  } catch (const samples::InputError& error) {
    expect(std::string_view(error.what()).starts_with("input"), "a fault names its file first");
  }
}

void composition(Bytes input) {
  try {
    const auto read = samples::parse_composition(std::string(text_of(input)), "input", "no/such/folder");
    expect(read.volumes.size() + read.surfaces.size() + read.shells.size() > 0, "a composition has a part");
    expect(read.overlap_step > 0, "pieces of an overlap have a length");
  } catch (const samples::InputError& error) {
    expect(std::string_view(error.what()).starts_with("input"), "a fault names its file first");
  }
}

void transfer_function(Bytes input) {
  try {
    const auto file = samples::parse_transfer_function(text_of(input), "input");
    const ValueRange range{-1000, 3000};
    TransferFunction function = samples::in_values_of(range, file);
    check(function, 0);
    auto entries = segmentation_entries(function, range, {});
    expect(entries.size() == 4096, "a tag has 4096 entries");
    set_gains(entries, {0.5, 0.5, 0.5});
  } catch (const samples::InputError&) {
  } catch (const BadArgument&) {
  }
}

void mesh(Bytes input) {
  const std::string_view text = text_of(input);
  try {
    const samples::Mesh mesh =
        text.starts_with("ply") ? samples::parse_ply(text, "input") : samples::parse_obj(text, "input");
    expect(!mesh.triangles.empty(), "a mesh has a triangle");
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t corner : triangle) expect(corner < mesh.points.size(), "a corner is a point");
    }
    for (const auto& triangle : mesh.texture_triangles) {
      for (const std::uint32_t corner : triangle) expect(corner < mesh.texture.size(), "a corner has its coordinates");
    }
    if (mesh.triangles.size() > kMaxTriangles) return;
    const samples::MeshDistance distance(mesh, "input");
    expect(!std::isnan(distance.at({0.25, 0.5, 0.75}).distance), "a closed mesh has a distance everywhere");
  } catch (const samples::FileError&) {
  } catch (const samples::InputError&) {
  }
}

}  // namespace gicube::fuzz
