#include "gicube/scene/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <ranges>

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "gicube/scene/voxeliser.h"
#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

constexpr double kVisible = 0.005;  // chosen: like visible_box()
constexpr int kMaxDepth = 64;       // chosen: of nodes within nodes
constexpr double kMinScale = 1e-9;  // chosen: of all transforms together; numbers beyond it lose digits
constexpr double kMaxEdge = 1e9;    // chosen: of a world, likewise

// Runs `call`, and prefixes its exceptions with the node's name.
template <typename Call>
auto named(const std::string& name, const Call& call) {
  try {
    return call();
  } catch (const InputError& error) {
    throw InputError(within("node[" + name + "]", error));
  }
}

// Collects the contents of all nodes.
class Walk {
 public:
  Walk(const WorldGrid& grid, const std::vector<SceneMaterial>& materials, int threads)
      : materials_(materials), dims_(grid.dims), threads_(threads) {
    to_voxels_ = compose(scaling((1 / grid.voxel) * Vec3{1, 1, 1}), translation(-1 * grid.low));
    ranges_.resize(materials.size());
    used_by_solid_.resize(materials.size());
  }

  void visit(const Node& node, const Affine& parent, const std::string& parent_name, const std::string& material,
             int depth) {
    const std::string name = node.name.empty() ? parent_name + "/unnamed" : node.name;
    if (depth > kMaxDepth) throw InputError("node[" + name + "]", "at most 64 levels", "more");
    const Affine map = named(name, [&] { return placed(parent, node.transforms); });
    const std::string& own = node.material.empty() ? material : node.material;
    if (!std::holds_alternative<Group>(node.content)) {
      if (!node.children.empty()) throw InputError("node[" + name + "]", "children or a content", "both");
      named(name, [&] { std::visit([&](const auto& content) { add(content, map, find(own)); }, node.content); });
    }
    for (const Node& child : node.children) visit(child, map, name, own, depth + 1);
  }

  std::vector<PlacedSolid> solids;
  std::vector<PlacedScan> scans;

  // The value range of the scan with this material.
  const std::optional<ValueRange>& range_of(std::size_t material) const { return ranges_[material]; }
  // The material's function in that scan's values.
  const TransferFunctionFile& settled(std::size_t material, const TransferFunctionFile& own) const {
    const auto found = settled_.find(material);
    return found != settled_.end() ? found->second : own;
  }

 private:
  static Affine placed(const Affine& parent, const std::vector<Transform>& transforms) {
    const Affine map = compose(parent, map_of(transforms));
    const double size = std::cbrt(std::abs(determinant(map))), where = length(map.offset);
    if (!(size >= kMinScale && size <= 1 / kMinScale) || !(where <= 1 / kMinScale)) {
      throw InputError("transform", fmt::format("a scale from {} to {}, no further away", kMinScale, 1 / kMinScale),
                       fmt::format("{} at a distance of {}", size, where));
    }
    return map;
  }

  std::size_t find(const std::string& name) const {
    const auto found = std::ranges::find(materials_, name, &SceneMaterial::name);
    if (found != materials_.end()) return static_cast<std::size_t>(found - materials_.begin());
    const auto names = fmt::format("{}", fmt::join(materials_ | std::views::transform(&SceneMaterial::name), ", "));
    throw InputError("material", names.empty() ? "a material of the scene, which has none" : "one of " + names,
                     in_quotes(name));
  }

  void add(const Group&, const Affine&, std::size_t) {}

  void add(const Shape& shape, const Affine& map, std::size_t material) {
    const SceneMaterial& made_of = materials_[material];
    if (ranges_[material]) throw InputError("material", "one that no scan is made of", in_quotes(made_of.name));
    used_by_solid_[material] = true;
    const bool fog = look_as<FogLook>(made_of) != nullptr;
    for (Field& field : fields_of(shape)) {
      solids.push_back({std::move(field), compose(to_voxels_, map), static_cast<std::uint8_t>(made_of.tag), fog});
    }
  }

  void add(const Hypertexture& content, const Affine& map, std::size_t material) {
    const TransferFunctionFile& function = function_of(materials_[material], material);
    const ScanField density = density_of(content);  // checks it
    const Affine to_node = inverse(compose(to_voxels_, map));
    take(place_density(
             dims_, [&](Vec3 p) { return density(to_node.point(p)); }, threads_),
         {0, 1}, function, material);
  }

  void add(const ScanContent& content, const Affine& map, std::size_t material) {
    const TransferFunctionFile& function = function_of(materials_[material], material);
    const Volume scan = read_volume(content.source);
    const ValueRange range = value_range_of(scan);
    if (!(range.low < range.high)) throw InputError(scan.source, "more than one value", "one");
    settled_[material] = in_values_of(survey_of(scan), range, function);
    take(place_scan(scan, range, compose(to_voxels_, map)), range, settled_[material], material);
  }

  // The transfer function of a material for scans and hypertextures.
  const TransferFunctionFile& function_of(const SceneMaterial& made_of, std::size_t material) const {
    const auto* function = look_as<TransferFunctionFile>(made_of);
    if (function != nullptr && !used_by_solid_[material]) return *function;
    throw InputError("material", "one with a transfer function, that no solid is made of", in_quotes(made_of.name));
  }

  void take(PlacedScan placed, const ValueRange& range, const TransferFunctionFile& function, std::size_t material) {
    const SceneMaterial& made_of = materials_[material];
    if (ranges_[material] && !(*ranges_[material] == range)) {
      throw InputError("material", "another one for each scan", in_quotes(made_of.name) + " twice");
    }
    ranges_[material] = range;
    placed.tag = static_cast<std::uint8_t>(made_of.tag);
    placed.visible = first_visible(in_values_of(range, function), range);
    scans.push_back(std::move(placed));
  }

  // The least density that shows anything.
  static double first_visible(const TransferFunction& function, const ValueRange& range) {
    for (int i = 0; i <= 4095; ++i) {
      if (function.opacity_at(range.low + (range.high - range.low) * i / 4095) > kVisible) return i / 4095.0;
    }
    return 2;  // nothing
  }

  const std::vector<SceneMaterial>& materials_;
  Affine to_voxels_;
  Dims dims_;
  int threads_;
  std::vector<std::optional<ValueRange>> ranges_;        // by material
  std::map<std::size_t, TransferFunctionFile> settled_;  // of scans, by material: in their values
  std::vector<bool> used_by_solid_;
};

// Fog beside solids: its extinction is proportional to its density, up to the highest that balance_fog() makes.
TransferFunctionFile beside_solids(const FogLook& fog, double voxel) {
  TransferFunctionFile look{{{{0, fog.colour}}, {{0, 0}}}};
  const double full = std::round(kFogBesideSolids * kMaxDensity);
  constexpr int kPoints = 20;  // chosen: of ten times its own density
  for (int i = 1; i <= kPoints; ++i) {
    const double density = std::min(i * full / 2, kMaxDensity);
    look.function.opacities.push_back({density, 1 - std::exp(-fog.extinction * voxel * density / full)});
  }
  return look;
}

// Converts a function from a scan's values to its densities.
TransferFunctionFile in_densities(const TransferFunctionFile& file, const ValueRange& range) {
  TransferFunctionFile result{in_values_of(range, file)};
  const auto density = [&range](double value) { return kMaxDensity * (value - range.low) / (range.high - range.low); };
  for (ColourPoint& point : result.function.colours) point.value = density(point.value);
  for (OpacityPoint& point : result.function.opacities) point.value = density(point.value);
  return result;
}

void check_materials(const std::vector<SceneMaterial>& materials) {
  for (std::size_t i = 0; i < materials.size(); ++i) {
    check(materials[i]);
    for (std::size_t k = 0; k < i; ++k) {
      if (materials[k].tag == materials[i].tag) {
        throw InputError("material[" + materials[i].name + "].tag", "another than that of " + materials[k].name,
                         std::to_string(materials[i].tag));
      }
      if (materials[k].name == materials[i].name) {
        throw InputError("material[" + materials[i].name + "].name", "a name of its own", "the same twice");
      }
    }
  }
}

}  // namespace

WorldGrid grid_of(const World& world) {
  const Vec3 edge = world.high - world.low;
  for (const double length : {edge.x, edge.y, edge.z}) {
    if (!(length >= 1 / kMaxEdge && length <= kMaxEdge)) {
      throw InputError("world.high", fmt::format("{} to {} more than world.low on each axis", 1 / kMaxEdge, kMaxEdge),
                       fmt::format("{} more", length));
    }
  }
  if (world.size < kMinWorldSize || world.size > kMaxWorldSize) {
    throw InputError("world.size", fmt::format("{} to {} voxels", kMinWorldSize, kMaxWorldSize),
                     std::to_string(world.size));
  }
  WorldGrid grid;
  grid.low = world.low;
  grid.voxel = std::max({edge.x, edge.y, edge.z}) / (world.size - 1);
  const auto voxels = [&grid](double length) {
    return std::max(static_cast<int>(std::lround(length / grid.voxel)) + 1, 2);
  };
  grid.dims = {voxels(edge.x), voxels(edge.y), voxels(edge.z)};
  return grid;
}

BuiltWorld build(const World& world, const std::vector<SceneMaterial>& materials, int threads) {
  BuiltWorld built;
  built.grid = grid_of(world);
  check_materials(materials);
  Walk walk(built.grid, materials, threads);
  walk.visit(world.root, {}, "world", "", 0);
  built.voxels = voxelise(built.grid, walk.solids, walk.scans, threads, world.densities);
  built.looks.assign(4, {{{{0, {1, 1, 1}}}, {{0, 0}}}});
  for (std::size_t i = 0; i < materials.size(); ++i) {
    TransferFunctionFile& look = built.looks[static_cast<std::size_t>(materials[i].tag)];
    const MaterialLook own = materials[i].look.value_or(SolidLook{});
    look = transfer_function_of(own, built.grid.voxel);
    if (walk.range_of(i)) {
      look = in_densities(walk.settled(i, look), *walk.range_of(i));
    } else if (look.scale != TransferScale::kAbsolute) {
      look = {in_values_of({0, kMaxDensity}, look)};
    }
    if (const auto* fog = std::get_if<FogLook>(&own); fog != nullptr && built.voxels.fog_density != kFogDensity) {
      look = beside_solids(*fog, built.grid.voxel);
    }
  }
  return built;
}

}  // namespace gicube::scene
