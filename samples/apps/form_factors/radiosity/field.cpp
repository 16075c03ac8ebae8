#include "form_factors/radiosity/field.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "form_factors/exchange/elements.h"

namespace gicube::samples {
namespace {

constexpr int kWindow = 2;          // chosen: voxels to each side: steps of slopes down to 1:5 are seen whole
constexpr int kLayers = 2;          // chosen: of voxels that light is carried on to: samples touch so many
constexpr double kMinFacing = 0.1;  // chosen: least cosine between a face's axis and the surface's normal

Vec3 axis_of(std::uint8_t facing) {
  const double sign = facing % 2 == 0 ? -1 : 1;
  return {facing / 2 == 0 ? sign : 0, facing / 2 == 1 ? sign : 0, facing / 2 == 2 ? sign : 0};
}

class Writer {
 public:
  Writer(const RadiosityResult& result, const SceneSetup& setup)
      : result_(result),
        incident_(smoothed(result)),
        setup_(setup),
        dims_(setup.volume.dims),
        faces_(voxels(), kNone),
        next_(result.leaves.size(), kNone),
        state_(voxels(), kDark) {
    field_.dims = dims_;
    field_.channels = 3;
    field_.values.assign(3 * voxels(), 0);
    for (std::uint32_t i = 0; i < result.leaves.size(); ++i) {
      const Leaf& leaf = result.leaves[i];
      if (leaf.facing == kMedium || leaf.tag == kOutside) continue;
      std::uint32_t& first = faces_[at(voxel_behind(leaf))];
      next_[i] = first;
      first = i;
    }
  }

  LightField write() {
    for (std::uint32_t i = 0; i < result_.leaves.size(); ++i) {
      if (result_.leaves[i].facing == kMedium) set(at(result_.leaves[i].cell), sum(i), kMediumLight);
    }
    for_each_voxel({}, dims_, [&](const GridCell& cell) {
      if (faces_[at(cell)] != kNone) set(at(cell), surface(cell), kSurface);
    });
    for (std::uint8_t layer = 0; layer < kLayers; ++layer) carry(static_cast<std::uint8_t>(kSurface + layer));
    return std::move(field_);
  }

 private:
  // A surface's light replaces that of medium beside it, because its samples are much more opaque.
  static constexpr std::uint8_t kDark = 0, kMediumLight = 1, kSurface = 2;  // + layers

  std::size_t voxels() const { return at({0, 0, dims_[2]}); }
  std::size_t at(const GridCell& cell) const { return voxel_index(dims_, cell); }
  template <typename Visit>
  void around(const GridCell& cell, int reach, const Visit& visit) const {
    for_each_voxel({-reach, -reach, -reach}, {reach + 1, reach + 1, reach + 1}, [&](const GridCell& away) {
      const auto [x, y, z] = away;
      const GridCell other{cell[0] + x, cell[1] + y, cell[2] + z};
      const int weight = (reach + 1 - std::abs(x)) * (reach + 1 - std::abs(y)) * (reach + 1 - std::abs(z));
      const auto inside = [](int place, int dim) { return place >= 0 && place < dim; };
      if (std::ranges::equal(other, dims_, inside)) visit(at(other), static_cast<double>(weight));
    });
  }

  Power sum(std::uint32_t leaf) const {
    Power all = incident_[leaf];
    add(all, 1, result_.leaves[leaf].emission);
    return all;
  }

  void set(std::size_t voxel, const Power& light, std::uint8_t state) {
    for (std::size_t c = 0; c < 3; ++c) field_.values[3 * voxel + c] = static_cast<float>(std::max(0.0, light[c]));
    state_[voxel] = state;
  }

  // Outward normal; zero if unknown.
  Vec3 normal(const GridCell& cell) const {
    const std::size_t voxel = at(cell);
    if (!setup_.gradients.empty()) {
      const Vec3 inward{setup_.gradients[3 * voxel], setup_.gradients[3 * voxel + 1], setup_.gradients[3 * voxel + 2]};
      if (length(inward) > 0.5) return (-1 / length(inward)) * inward;
    }
    Vec3 areas;
    around(cell, kWindow, [&](std::size_t other, double weight) {
      for (std::uint32_t i = faces_[other]; i != kNone; i = next_[i]) {
        areas = areas + (weight * result_.leaves[i].weight) * axis_of(result_.leaves[i].facing);
      }
    });
    return length(areas) > 0 ? normalise(areas) : Vec3{};
  }

  // Light of the surrounding faces of one surface. Emitted light has no direction, and is from the voxel's own faces.
  Power surface(const GridCell& cell) const {
    const Vec3 n = normal(cell);
    Power flux{}, own{};
    double area = 0, own_area = 0, emitting = 0;
    around(cell, kWindow, [&](std::size_t other, double weight) {
      for (std::uint32_t i = faces_[other]; i != kNone; i = next_[i]) {
        const double facing = dot(n, axis_of(result_.leaves[i].facing));
        if (facing < kMinFacing) continue;
        const double of_face = weight * result_.leaves[i].weight;
        add(flux, of_face, incident_[i]);
        area += of_face * facing;
      }
    });
    for (std::uint32_t i = faces_[at(cell)]; i != kNone; i = next_[i]) {
      const double of_face = result_.leaves[i].weight;
      add(own, of_face, result_.leaves[i].emission);
      if (area == 0) add(flux, of_face, incident_[i]);  // a sheet whose sides cancel
      own_area += of_face;
      emitting += of_face * result_.leaves[i].share;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      flux[c] = flux[c] / (area > 0 ? area : own_area) + (emitting > 0 ? own[c] / emitting : 0);
    }
    return flux;
  }

  // Voxels without light, and those of medium, have the mean of the layer beside them.
  void carry(std::uint8_t layer) {
    std::vector<std::pair<std::size_t, Power>> found;
    for_each_voxel({}, dims_, [&](const GridCell& cell) {
      const std::uint8_t state = state_[at(cell)];
      // Medium has its own light except in the layer that touches the surface.
      if (state >= kSurface || (state == kMediumLight && layer > kSurface)) return;
      Power light{};
      double weights = 0;
      around(cell, 1, [&](std::size_t other, double weight) {
        if (state_[other] != layer) return;
        for (std::size_t c = 0; c < 3; ++c) light[c] += weight * double{field_.values[3 * other + c]};
        weights += weight;
      });
      if (weights == 0) return;
      for (double& part : light) part /= weights;
      found.emplace_back(at(cell), light);
    });
    for (const auto& [voxel, light] : found) set(voxel, light, static_cast<std::uint8_t>(layer + 1));
  }

  const RadiosityResult& result_;
  const std::vector<Power> incident_;  // smoothed
  const SceneSetup& setup_;
  const Dims dims_;
  std::vector<std::uint32_t> faces_;  // by solid voxel: the first of its faces, and
  std::vector<std::uint32_t> next_;   // by leaf: the next one of the same voxel
  std::vector<std::uint8_t> state_;
  LightField field_;
};

}  // namespace

LightField field_of(const RadiosityResult& result, const SceneSetup& setup) { return Writer(result, setup).write(); }

}  // namespace gicube::samples
