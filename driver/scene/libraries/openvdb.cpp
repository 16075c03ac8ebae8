// libgicube-openvdb.so: reads and writes OpenVDB grids of floats.
// Templates of the library and those instantiated here share variables, such as the names of grids, only if they are
// visible.
#pragma GCC visibility push(default)
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#pragma GCC visibility pop

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <functional>
#include <span>
#include <utility>

#include "scene/libraries/each_library.h"

namespace gicube::scene {
namespace {

constexpr std::uint64_t kMaxRatio = 4096;  // chosen: voxels per byte of the file, since a tile may have 4096^3 voxels

Vec3 vec(const openvdb::Vec3d& v) { return {v.x(), v.y(), v.z()}; }

// The grid that `part` names, or "density", or the first one of floats.
std::string choose(const std::filesystem::path& file, openvdb::io::File& opened, const std::string& part,
                   std::vector<FileFault>& warnings) {
  std::vector<std::string> names;
  std::string list;
  const auto grids = opened.readAllGridMetadata();
  for (const auto& grid : *grids) {
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", grid->getName(), grid->valueType());
    if (grid->isType<openvdb::FloatGrid>()) names.push_back(grid->getName());
  }
  if (!part.empty()) {
    if (std::ranges::find(names, part) == names.end())
      fail(file, "part", "a grid of floats: " + list, '"' + part + '"');
    return part;
  }
  if (names.empty()) fail(file, "grid", "one of floats", list.empty() ? "none" : list);
  const auto density = std::ranges::find(names, "density");
  const std::string chosen = density != names.end() ? *density : names.front();
  if (names.size() > 1) warnings.push_back({file, "grid", "a part, one of " + list, "none; " + chosen + " is taken"});
  return chosen;
}

LibraryVolume read_grid(const std::filesystem::path& file, const std::string& part) {
  LibraryVolume out;
  std::error_code none;
  const std::uint64_t in_file = std::filesystem::file_size(file, none);
  openvdb::io::File opened(file.string());
  opened.open(false);  // no delayed loading: the file may change meanwhile
  const std::string name = choose(file, opened, part, out.warnings);
  const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(opened.readGrid(name));
  if (!grid->transform().isLinear()) fail(file, name, "a linear transform", grid->transform().mapType());
  const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
  if (box.empty()) fail(file, name, "active voxels", "none");
  for (int i = 0; i < 3; ++i) {
    const std::int64_t size = std::int64_t{box.max()[i]} - box.min()[i] + 1;
    out.layout.dims[static_cast<std::size_t>(i)] = static_cast<int>(std::clamp<std::int64_t>(size, 0, kMaxFileDim + 1));
  }
  out.layout.type = StoredType::kFloat32;
  const auto bytes = sane_bytes(out.layout, sizeof(float));
  if (!bytes || *bytes / sizeof(float) > in_file * kMaxRatio)
    fail(file, name,
         fmt::format("1..{} voxels a side, at most {} bytes, {} for each of the file's", kMaxFileDim, kMaxVolumeBytes,
                     kMaxRatio),
         fmt::format("{}", fmt::join(out.layout.dims, " x ")));
  const openvdb::Vec3d origin = grid->transform().indexToWorld(box.min());
  std::array<double, 3> edges{};
  for (int i = 0; i < 3; ++i) {
    openvdb::Coord next = box.min();
    next[i] += 1;
    const Vec3 edge = vec(grid->transform().indexToWorld(next) - origin);
    out.layout.placement.directions[static_cast<std::size_t>(i)] = edge;
    edges[static_cast<std::size_t>(i)] = length(edge);
  }
  out.layout.spacing = {edges[0], edges[1], edges[2]};
  out.layout.placement.axes = WorldAxes::kWorld;
  out.layout.placement.origin = vec(origin);
  allow_time_for(*bytes);
  out.samples.resize(*bytes);
  // Voxels that are not stored get the grid's background.
  openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box, reinterpret_cast<float*>(out.samples.data()));
  openvdb::tools::copyToDense(*grid, dense);
  if (grid->getGridClass() == openvdb::GRID_LEVEL_SET) {
    out.warnings.push_back({file, name, "densities", "a level set; its distances are made positive inside"});
    const std::span values(dense.data(), out.samples.size() / sizeof(float));
    std::ranges::transform(values, values.begin(), std::negate<>());
  }
  return out;
}

void write_grid(const FloatVolume& volume, const std::filesystem::path& file) {
  const auto [x, y, z] = volume.dims;
  const openvdb::CoordBBox box(0, 0, 0, x - 1, y - 1, z - 1);
  // Dense takes a pointer to mutable values, but does not change them here.
  auto* const values = const_cast<float*>(volume.values.data());  // NOLINT(*-const-cast)
  const openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box, values);
  // The background is the first corner's value, because most volumes are empty there. The far corners are active so
  // that the box keeps its size.
  const float background = volume.values.front();
  const auto grid = openvdb::FloatGrid::create(background);
  openvdb::tools::copyFromDense(dense, *grid, 0.0F);
  grid->tree().setValueOn({0, 0, 0}, background);
  grid->tree().setValueOn({x - 1, y - 1, z - 1}, volume.values.back());
  const auto& d = volume.directions;
  const Vec3 &s = volume.spacing, &o = volume.origin;
  grid->setTransform(openvdb::math::Transform::createLinearTransform(
      openvdb::Mat4d(s.x * d[0].x, s.x * d[0].y, s.x * d[0].z, 0.0, s.y * d[1].x, s.y * d[1].y, s.y * d[1].z, 0.0,
                     s.z * d[2].x, s.z * d[2].y, s.z * d[2].z, 0.0, o.x, o.y, o.z, 1.0)));
  grid->setName("density");
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  openvdb::io::File(file.string()).write({grid});
}

}  // namespace
}  // namespace gicube::scene

extern "C" __attribute__((visibility("default"))) const gicube::scene::VolumeLibrary* gicube_openvdb() {
  using namespace gicube::scene;
  static const EachLibrary library("OpenVDB", openvdb::initialize, read_grid, write_grid);
  return &library;
}
