#include "scene/buckyball.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "scene/geometry/signed_distance.h"
#include "scene/geometry/voxel_world.h"
#include "scene/parallel.h"
#include "scene/program/input_error.h"
#include "scene/truncated_icosahedron.h"

namespace gicube::samples {
namespace {

constexpr int kCell = 8;  // voxels; solids are looked up a cell at a time

struct Solid {
  enum class Kind { kSphere, kCapsule, kBox } kind;
  Vec3 a, b;
  double radius;
  std::uint8_t tag;

  Distance distance(Vec3 p) const {
    switch (kind) {
      case Kind::kSphere: return sphere_distance(p, a, radius);
      case Kind::kCapsule: return capsule_distance(p, a, b, radius);
      case Kind::kBox: return box_distance(p, a, b, radius);
    }
    return {};
  }
};

// All solids in voxels. `scale` is the volume's edge.
std::vector<Solid> place_solids(const BuckyballShape& shape, double scale) {
  std::vector<Solid> solids;
  const Molecule molecule = truncated_icosahedron();
  const double turn = shape.turn_degrees * std::numbers::pi / 180, cosine = std::cos(turn), sine = std::sin(turn);
  std::vector<Vec3> atoms;
  for (const Vec3& p : molecule.atoms) {
    const Vec3 turned{cosine * p.x - sine * p.y, sine * p.x + cosine * p.y, p.z};
    atoms.push_back(scale * (shape.centre + shape.circumradius * turned));
    solids.push_back({Solid::Kind::kSphere, atoms.back(), {}, scale * shape.atom_radius, kAtom});
  }
  for (const auto& [from, to] : molecule.bonds) {
    solids.push_back({Solid::Kind::kCapsule, atoms[static_cast<std::size_t>(from)], atoms[static_cast<std::size_t>(to)],
                      scale * shape.bond_radius, kBond});
  }
  solids.push_back(
      {Solid::Kind::kBox, scale * shape.floor_low, scale * shape.floor_high, scale * shape.floor_rounding, kFloor});
  return solids;
}

// Fills the layers of cells that it is given; each voxel depends on its position alone.
class Voxeliser {
 public:
  Voxeliser(int size, const BuckyballShape& shape, Buckyball& target)
      : size_(size), shape_(shape), scale_(size - 1), solids_(place_solids(shape, scale_)), target_(target) {}

  int layers() const { return (size_ + kCell - 1) / kCell; }

  void fill_layer(int layer) {
    std::vector<const Solid*> near;
    const double reach = kNearVoxels + kCell * std::numbers::sqrt3 / 2;
    for (int y = 0; y < size_; y += kCell) {
      for (int x = 0; x < size_; x += kCell) {
        const Vec3 middle = Vec3{double(x), double(y), double(layer * kCell)} + 0.5 * (kCell - 1) * Vec3{1, 1, 1};
        near.clear();
        for (const Solid& solid : solids_) {
          if (solid.distance(middle).distance < reach) near.push_back(&solid);
        }
        if (!near.empty()) fill_cell({x, y, layer * kCell}, near);
      }
    }
  }

 private:
  void fill_cell(const Dims& first, const std::vector<const Solid*>& near) {
    for (int z = first[2]; z < std::min(first[2] + kCell, size_); ++z) {
      for (int y = first[1]; y < std::min(first[1] + kCell, size_); ++y) {
        for (int x = first[0]; x < std::min(first[0] + kCell, size_); ++x) fill_voxel(x, y, z, near);
      }
    }
  }

  void fill_voxel(int x, int y, int z, const std::vector<const Solid*>& near) {
    const Vec3 p{double(x), double(y), double(z)};
    Distance nearest{kNearVoxels, {}};
    const Solid* solid = nullptr;
    for (const Solid* candidate : near) {
      const Distance distance = candidate->distance(p);
      if (distance.distance < nearest.distance) nearest = distance, solid = candidate;
    }
    if (solid == nullptr) return;

    const auto size = static_cast<std::size_t>(size_);
    const std::size_t index =
        (static_cast<std::size_t>(z) * size + static_cast<std::size_t>(y)) * size + static_cast<std::size_t>(x);
    const double inside = std::clamp(0.5 - nearest.distance / kRampVoxels, 0.0, 1.0);
    const auto density = static_cast<std::uint16_t>(std::lround(kMaxDensity * inside));
    std::memcpy(&target_.volume.samples[2 * index], &density, sizeof density);
    target_.tags[index] = solid->tag == kFloor ? floor_tag(p) : solid->tag;
    if (!target_.gradients.empty() && nearest.distance > -kNearVoxels) {
      float* gradient = &target_.gradients[3 * index];
      gradient[0] = static_cast<float>(-nearest.away.x);
      gradient[1] = static_cast<float>(-nearest.away.y);
      gradient[2] = static_cast<float>(-nearest.away.z);
    }
  }

  std::uint8_t floor_tag(Vec3 p) const {
    const auto tile = [this](double v, double low, double high) {
      return static_cast<int>(std::floor((v / scale_ - low) / (high - low) * shape_.floor_tiles));
    };
    const int sum =
        tile(p.x, shape_.floor_low.x, shape_.floor_high.x) + tile(p.y, shape_.floor_low.y, shape_.floor_high.y);
    return (sum & 1) == 0 ? kFloor : kFloorDark;
  }

  int size_;
  BuckyballShape shape_;
  double scale_;  // voxels
  std::vector<Solid> solids_;
  Buckyball& target_;
};

}  // namespace

Buckyball make_buckyball(int size, bool gradients, int threads, const BuckyballShape& shape) {
  if (size < kMinBuckyballSize || size > kMaxBuckyballSize) {
    throw InputError("buckyball size",
                     std::to_string(kMinBuckyballSize) + " to " + std::to_string(kMaxBuckyballSize) + " voxels",
                     std::to_string(size));
  }
  Buckyball ball;
  const std::size_t voxels =
      static_cast<std::size_t>(size) * static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  ball.volume.type = SampleType::kUint12;
  ball.volume.dims = {size, size, size};
  ball.volume.source = "builtin:buckyball";
  ball.volume.samples.resize(voxels * bytes_per_sample(SampleType::kUint12));
  ball.tags.resize(voxels);
  if (gradients) ball.gradients.resize(voxels * 3);

  Voxeliser voxeliser(size, shape, ball);
  in_parallel(static_cast<std::size_t>(voxeliser.layers()), threads,
              [&](std::size_t layer) { voxeliser.fill_layer(static_cast<int>(layer)); });
  return ball;
}

Appearance buckyball_appearance(int size) {
  // Opaque within about one voxel around the surface, which is at half of the greatest density.
  const auto solid = [](const Colour& colour) {
    return TransferFunctionFile{{{{0, colour}}, {{0.3 * kMaxDensity, 0}, {0.7 * kMaxDensity, 1}}}, false};
  };
  Appearance look;
  look.materials = {solid({0.93, 0.52, 0.20}), solid({0.66, 0.69, 0.74}), solid({0.52, 0.60, 0.70}),
                    solid({0.36, 0.43, 0.54})};
  look.phong = {0.22, 0.74, 0.42, 28};
  look.light = Vec3{-0.55, -0.62, 0.78};
  const double scale = size - 1;
  look.camera.look_at = scale * Vec3{0.5, 0.5, 0.455};
  look.camera.eye = scale * Vec3{0.5, -1.83, 1.36};
  look.camera.up = Vec3{0, 0, 1};
  look.camera.fov_degrees = 30;
  look.background = Colour{0.075, 0.085, 0.11};
  return look;
}

}  // namespace gicube::samples
