#include "form_factors/exchange/elements.h"

#include <algorithm>
#include <bit>

namespace gicube::samples {
namespace {

// Bits of x, y and z in turn: the order in which an octree's leaves follow each other.
std::uint64_t octree_place(const GridCell& voxel) {
  std::uint64_t place = 0;
  for (unsigned bit = 0; bit < 21; ++bit) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      place |= (std::uint64_t{static_cast<unsigned>(voxel[axis])} >> bit & 1) << (3 * bit + axis);
    }
  }
  return place;
}

std::array<double, 3> array_of(Vec3 v) { return {v.x, v.y, v.z}; }
Vec3 vec3_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

// Faces of positive facing have u x v along their axis.
Element box_element(const std::array<double, 3>& low, const std::array<double, 3>& high, std::uint8_t facing) {
  const auto side = [&](std::size_t axis) {
    std::array<double, 3> v{};
    v[axis] = high[axis] - low[axis];
    return vec3_of(v);
  };
  if (facing == kMedium) return {ElementKind::kBox, vec3_of(low), side(0), side(1), side(2)};
  const std::size_t axis = facing / 2u, next = (axis + 1) % 3, third = (axis + 2) % 3;
  const bool positive = facing % 2 == 1;
  return {ElementKind::kPatch, vec3_of(low), side(positive ? next : third), side(positive ? third : next), {}};
}

class LeafMaker {
 public:
  LeafMaker(const Medium& medium, const SceneSetup& setup, const Emissions& emissions)
      : medium_(medium), setup_(setup), emissions_(emissions), edges_(array_of(medium.edges)) {}

  void add(const GridCell& voxel) {
    for (std::uint8_t facing = 0; facing < kMedium; ++facing) add_face(voxel, facing);
    const double kappa = mean_kappa(medium_, voxel);
    if (!(kappa > 0)) return;
    Leaf leaf = begin(voxel, kMedium, medium_.tags[medium_.at(voxel)]);
    leaf.kappa = kappa;
    leaf.weight *= 4 * kappa;
    for (double& channel : leaf.emission) channel /= 4 * kappa;  // was power of a unit of volume
    leaves_[kMedium].push_back(leaf);
  }

  std::vector<Leaf> finish() {
    std::vector<Leaf> all;
    for (auto& tree : leaves_) {
      std::vector<std::pair<std::uint64_t, std::size_t>> order;
      for (std::size_t i = 0; i < tree.size(); ++i) order.emplace_back(octree_place(tree[i].cell), i);
      std::sort(order.begin(), order.end());
      for (const auto& [place, i] : order) all.push_back(tree[i]);
      tree.clear();
    }
    return all;
  }

 private:
  void add_face(const GridCell& voxel, std::uint8_t facing) {
    const std::size_t axis = facing / 2u;
    GridCell behind = voxel;
    behind[axis] += facing % 2 == 0 ? 1 : -1;
    if (behind[axis] < 0 || behind[axis] >= medium_.dims[axis]) {
      leaves_[facing].push_back(begin(voxel, facing, kOutside));
    } else if (medium_.solid[medium_.at(behind)] != 0) {
      leaves_[facing].push_back(begin(voxel, facing, medium_.tags[medium_.at(behind)]));
    }
  }

  // With its area or volume for a weight.
  Leaf begin(const GridCell& voxel, std::uint8_t facing, std::uint8_t tag) const {
    std::array<double, 3> low, high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::max(voxel[axis] - 0.5, 0.0);
      high[axis] = std::min(voxel[axis] + 0.5, medium_.dims[axis] - 1.0);
    }
    if (facing != kMedium) (facing % 2 == 0 ? low : high)[facing / 2u] = (facing % 2 == 0 ? high : low)[facing / 2u];
    Leaf leaf;
    leaf.element = box_element(low, high, facing);
    leaf.facing = facing;
    leaf.tag = tag;
    leaf.cell = voxel;
    leaf.weight = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (facing == kMedium || axis != facing / 2u) leaf.weight *= (high[axis] - low[axis]) * edges_[axis];
    }
    if (tag < emissions_.size()) leaf.emission = emissions_[tag].power;
    if (tag < setup_.optics.size()) {
      const Colour& factors = setup_.scattering_colours[tag];
      for (std::size_t c = 0; c < 3; ++c) leaf.albedo[c] = setup_.optics[tag].scattering * factors[c];
    }
    return leaf;
  }

  const Medium& medium_;
  const SceneSetup& setup_;
  const Emissions& emissions_;
  std::array<double, 3> edges_;
  std::array<std::vector<Leaf>, 7> leaves_;
};

// Both ends of the box of a leaf.
void widen(Cluster& cluster, const Leaf& leaf, bool fresh) {
  const auto low = array_of(leaf.element.origin);
  const auto high = array_of(leaf.element.origin + leaf.element.u + leaf.element.v + leaf.element.w);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cluster.low[axis] = fresh ? low[axis] : std::min(cluster.low[axis], low[axis]);
    cluster.high[axis] = fresh ? high[axis] : std::max(cluster.high[axis], high[axis]);
  }
}

class ForestMaker {
 public:
  ForestMaker(std::vector<Leaf> leaves, Vec3 edges, int leaf_voxels) : leaf_bits_(bits_of(leaf_voxels)) {
    forest_.leaves = std::move(leaves);
    forest_.edges = edges;
    forest_.measures.push_back(0);
    for (const Leaf& leaf : forest_.leaves) {
      places_.push_back(octree_place(leaf.cell));
      forest_.measures.push_back(forest_.measures.back() + leaf.weight / (leaf.facing == kMedium ? 4 : 1));
    }
  }

  Forest finish() {
    const auto& leaves = forest_.leaves;
    for (std::uint32_t first = 0; first < leaves.size();) {
      std::uint32_t last = first;
      while (last < leaves.size() && leaves[last].facing == leaves[first].facing) ++last;
      forest_.roots.push_back(static_cast<std::uint32_t>(forest_.clusters.size()));
      forest_.clusters.push_back(cluster(first, last, kNone));
      first = last;
    }
    for (std::uint32_t i = 0; i < forest_.clusters.size(); ++i) divide(i);
    return std::move(forest_);
  }

 private:
  static unsigned bits_of(int leaf_voxels) {
    return 3 * static_cast<unsigned>(std::bit_width(static_cast<unsigned>(leaf_voxels)) - 1);
  }

  Cluster cluster(std::uint32_t first, std::uint32_t last, std::uint32_t parent) const {
    Cluster out;
    out.first = first;
    out.last = last;
    out.parent = parent;
    out.facing = forest_.leaves[first].facing;
    double least = forest_.leaves[first].kappa, most = least;
    for (std::uint32_t i = first; i < last; ++i) {
      const Leaf& leaf = forest_.leaves[i];
      widen(out, leaf, i == first);
      least = std::min(least, leaf.kappa);
      most = std::max(most, leaf.kappa);
      out.weight += leaf.weight;
      out.measure += out.facing == kMedium ? leaf.weight / (4 * leaf.kappa) : leaf.weight;
    }
    const auto edges = array_of(forest_.edges);
    double box = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (out.facing == kMedium || axis != out.facing / 2u) box *= (out.high[axis] - out.low[axis]) * edges[axis];
    }
    const bool flat = out.facing == kMedium || out.low[out.facing / 2u] == out.high[out.facing / 2u];
    constexpr double kAlike = 1e-9;  // rounding of the sums
    out.full = flat && most - least <= kAlike * most && box - out.measure <= kAlike * box;
    return out;
  }

  // Into the parts of the first digit, of 8, in which its leaves' places differ.
  void divide(std::uint32_t index) {
    const std::uint32_t first = forest_.clusters[index].first, last = forest_.clusters[index].last;
    const std::uint64_t differ = places_[first] ^ places_[last - 1];
    const auto top = static_cast<unsigned>(std::bit_width(differ));
    if (top <= leaf_bits_) return;
    const unsigned digit = (top - 1) / 3 * 3;
    const auto child = static_cast<std::uint32_t>(forest_.clusters.size());
    for (std::uint32_t begin = first; begin < last;) {
      std::uint32_t end = begin;
      while (end < last && places_[end] >> digit == places_[begin] >> digit) ++end;
      forest_.clusters.push_back(cluster(begin, end, index));
      begin = end;
    }
    forest_.clusters[index].child = child;
    forest_.clusters[index].children = static_cast<std::uint32_t>(forest_.clusters.size()) - child;
  }

  unsigned leaf_bits_;
  Forest forest_;
  std::vector<std::uint64_t> places_;
};

}  // namespace

std::vector<Leaf> make_leaves(const Medium& medium, const SceneSetup& setup, const Emissions& emissions) {
  LeafMaker maker(medium, setup, emissions);
  for_each_voxel({}, medium.dims, [&](const GridCell& voxel) {
    if (medium.solid[medium.at(voxel)] == 0) maker.add(voxel);
  });
  return maker.finish();
}

Forest make_forest(std::vector<Leaf> leaves, Vec3 edges, int leaf_voxels) {
  return ForestMaker(std::move(leaves), edges, leaf_voxels).finish();
}

Element element_of(const Cluster& cluster) { return box_element(cluster.low, cluster.high, cluster.facing); }

bool may_see(const Cluster& a, const Cluster& b) {
  if (a.facing != kMedium && a.facing == b.facing) return false;
  const auto before = [](const Cluster& face, const Cluster& other) {
    if (face.facing == kMedium) return true;
    const std::size_t axis = face.facing / 2u;
    return face.facing % 2 == 1 ? other.high[axis] > face.low[axis] : other.low[axis] < face.high[axis];
  };
  return before(a, b) && before(b, a);
}

}  // namespace gicube::samples
