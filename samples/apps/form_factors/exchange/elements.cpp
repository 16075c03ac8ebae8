#include "form_factors/exchange/elements.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace gicube::samples {
namespace {

// Interleaves the bits of x, y and z: the order of an octree's leaves.
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

// Share of a face's area in the area of the surface that its staircase follows. If the faces were on the surface, this
// would be the cosine between the surface's normal and the face's axis (Gauss's theorem). They are up to half a voxel
// off, and an edge or a small ball has more area outside. So a factor for each solid scales the sum to the mean over
// the levels of density within half a voxel on both sides of its surface, which is right to second order in the voxel.
// A solid inside an equally dense one has no step of density; its normals are those of its voxels' outline.
class SurfaceShares {
 public:
  SurfaceShares(const Medium& medium, const SceneSetup& setup) : medium_(medium), setup_(setup) {
    for_each_face([&](const GridCell& open, const GridCell& solid, std::size_t axis) {
      outlines_[tag(medium.at(solid))] += area(solid, axis) * outline_cosine(open, solid, axis);
    });
    if (setup.gradients.empty()) return;
    const std::vector<float> densities = values_of(setup.volume);
    const auto level = [&](std::size_t at) { return std::clamp(2 * densities[at] / kMaxDensity - 0.5, 0.0, 1.0); };
    for_each_voxel({}, medium.dims, [&](const GridCell& cell) {
      const std::size_t here = medium.at(cell);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        GridCell next = cell;
        if (++next[axis] == medium.dims[axis]) continue;
        const std::size_t there = medium.at(next);
        const double rise = level(there) - level(here);
        const bool solid_here = medium.solid[here] != 0, is_face = solid_here != (medium.solid[there] != 0);
        if (rise == 0 && !is_face) continue;
        const double of_face = area(cell, axis);
        if (rise != 0)
          levels_[tag(rise > 0 ? there : here)] += std::abs(rise) * of_face * cosine(here, there, axis, rise > 0);
        if (is_face) faces_[tag(solid_here ? here : there)] += of_face * cosine(here, there, axis, !solid_here);
      }
    });
  }

  // 1 if the surface's direction is unknown.
  double of(const GridCell& open, const GridCell& solid, std::size_t axis) const {
    const std::size_t outside = medium_.at(open), inside = medium_.at(solid), solid_tag = tag(inside);
    constexpr double kMostHidden = 0.75;  // chosen: below this share of its outline the step is hidden
    if (solid_tag != kNoSolid && levels_[solid_tag] < kMostHidden * outlines_[solid_tag])
      return outline_cosine(open, solid, axis);
    if (setup_.gradients.empty() || gradient(outside) + gradient(inside) == Vec3{}) return 1;
    const double cosine_there = cosine(outside, inside, axis, solid[axis] > open[axis]);
    return solid_tag != kNoSolid && faces_[solid_tag] > 0 ? cosine_there * levels_[solid_tag] / faces_[solid_tag]
                                                          : cosine_there;
  }

 private:
  static constexpr std::size_t kNoSolid = 4;  // tags are 0..3
  std::size_t tag(std::size_t at) const {
    const std::size_t tag = setup_.tags.empty() ? 0 : setup_.tags[at];  // an edge in fog is fog in the medium
    return tag < setup_.looks.size() && std::holds_alternative<SolidLook>(setup_.looks[tag]) ? tag : kNoSolid;
  }
  Vec3 gradient(std::size_t at) const {
    const float* g = &setup_.gradients[3 * at];
    return {g[0], g[1], g[2]};
  }
  // Cosine between the gradient of two neighbours and the axis, along which the density must rise, or otherwise fall;
  // else 0. At an edge one of them has the gradient of the other side.
  double cosine(std::size_t a, std::size_t b, std::size_t axis, bool rises) const {
    constexpr double kEdge = 0.72;  // chosen: cosine of the angle between both; slightly above that of 45 degrees
    const auto along = [&](Vec3 g) {
      const double size = length(g);
      return size > 0 ? std::max(0.0, (rises ? 1 : -1) * array_of(g)[axis] / size) : 0;
    };
    const Vec3 at_a = gradient(a), at_b = gradient(b);
    return dot(at_a, at_b) < kEdge ? std::max(along(at_a), along(at_b)) : along(at_a + at_b);
  }

  // Area of a voxel's side perpendicular to an axis; half or a quarter of it at the volume's edges.
  double area(const GridCell& cell, std::size_t axis) const {
    double area = 1;
    for (std::size_t other = 0; other < 3; ++other) {
      const bool at_end = cell[other] == 0 || cell[other] == medium_.dims[other] - 1;
      if (other != axis) area *= (at_end ? 0.5 : 1) * medium_.edges[other];
    }
    return area;
  }
  // Calls use(open, solid, axis) for each face of a solid.
  template <typename Use>
  void for_each_face(const Use& use) const {
    for_each_voxel({}, medium_.dims, [&](const GridCell& cell) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        GridCell next = cell;
        if (++next[axis] == medium_.dims[axis]) continue;
        const bool here = medium_.solid[medium_.at(cell)] != 0, there = medium_.solid[medium_.at(next)] != 0;
        if (here != there) here ? use(next, cell, axis) : use(cell, next, axis);
      }
    });
  }
  // Cosine between the face's axis and the direction away from the middle of the solid's voxels nearby.
  double outline_cosine(const GridCell& open, const GridCell& solid, std::size_t axis) const {
    constexpr int kReach = 2;  // chosen: a ball of three voxels' radius has its area within 11%, of six within 4%
    const std::uint8_t tag = medium_.tags[medium_.at(solid)];
    Vec3 away{};
    for (const GridCell& middle : {open, solid}) {
      for (int z = -kReach; z <= kReach; ++z) {
        for (int y = -kReach; y <= kReach; ++y) {
          for (int x = -kReach; x <= kReach; ++x) {
            GridCell cell{middle[0] + x, middle[1] + y, middle[2] + z};
            for (std::size_t i = 0; i < 3; ++i) cell[i] = std::clamp(cell[i], 0, medium_.dims[i] - 1);
            const std::size_t at = medium_.at(cell);
            if (medium_.solid[at] != 0 && medium_.tags[at] == tag)
              away = away - Vec3{x * medium_.edges[0], y * medium_.edges[1], z * medium_.edges[2]};
          }
        }
      }
    }
    const double size = length(away), along = array_of(away)[axis] * (open[axis] > solid[axis] ? 1 : -1);
    return size > 0 ? std::max(0.0, along / size) : 1;
  }

  const Medium& medium_;
  const SceneSetup& setup_;
  std::array<double, kNoSolid + 1> levels_{}, faces_{}, outlines_{};  // areas by tag
};

}  // namespace

std::vector<Leaf> make_leaves(const Medium& medium, const SceneSetup& setup, const Emissions& emissions) {
  std::array<std::vector<Leaf>, 7> trees;  // by facing
  const SurfaceShares shares(medium, setup);
  // Weighted by its area or volume.
  const auto add = [&](const GridCell& voxel, std::uint8_t facing, std::uint8_t tag) -> Leaf& {
    std::array<double, 3> low, high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::max(voxel[axis] - 0.5, 0.0);
      high[axis] = std::min(voxel[axis] + 0.5, medium.dims[axis] - 1.0);
    }
    if (facing != kMedium) (facing % 2 == 0 ? low : high)[facing / 2u] = (facing % 2 == 0 ? high : low)[facing / 2u];
    Leaf leaf{.element = box_element(low, high, facing), .facing = facing, .tag = tag, .cell = voxel, .weight = 1};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (facing == kMedium || axis != facing / 2u) leaf.weight *= (high[axis] - low[axis]) * medium.edges[axis];
    }
    if (tag < emissions.size()) leaf.emission = facing == kMedium ? emissions[tag].volume : emissions[tag].surface;
    if (tag < setup.optics.size()) {
      const Colour& factors = setup.scattering_colours[tag];
      for (std::size_t c = 0; c < 3; ++c) leaf.albedo[c] = setup.optics[tag].scattering * factors[c];
    }
    return trees[facing].emplace_back(leaf);
  };
  for_each_voxel({}, medium.dims, [&](const GridCell& voxel) {
    if (medium.solid[medium.at(voxel)] != 0) return;
    for (std::uint8_t facing = 0; facing < kMedium; ++facing) {
      const GridCell behind = voxel_behind({.element = {}, .facing = facing, .cell = voxel});
      const int place = behind[facing / 2u];
      if (place < 0 || place >= medium.dims[facing / 2u]) {
        add(voxel, facing, kOutside);
      } else if (medium.solid[medium.at(behind)] != 0) {
        Leaf& leaf = add(voxel, facing, medium.tags[medium.at(behind)]);
        leaf.share = shares.of(voxel, behind, facing / 2u);
        for (double& channel : leaf.emission) channel *= leaf.share;
      }
    }
    const double kappa = mean_kappa(medium, voxel);
    if (!(kappa > 0)) return;
    Leaf& leaf = add(voxel, kMedium, medium.tags[medium.at(voxel)]);
    leaf.kappa = kappa;
    leaf.weight *= 4 * kappa;
    const auto* fog = leaf.tag < setup.looks.size() ? std::get_if<FogLook>(&setup.looks[leaf.tag]) : nullptr;
    const double full = fog != nullptr ? fog->extinction * setup.grid.voxel : kappa;  // a fog's ramp is partly fog
    for (double& channel : leaf.emission) channel /= 4 * full;                        // was power of a unit of volume
  });
  std::vector<Leaf> all;
  for (const auto& tree : trees) {
    std::vector<std::pair<std::uint64_t, std::size_t>> order;
    for (std::size_t i = 0; i < tree.size(); ++i) order.emplace_back(octree_place(tree[i].cell), i);
    std::ranges::sort(order);
    for (const auto& [place, i] : order) all.push_back(tree[i]);
  }
  return all;
}

Forest make_forest(std::vector<Leaf> leaves, const Edges& edges, int leaf_voxels) {
  Forest forest{.leaves = std::move(leaves), .clusters = {}, .roots = {}, .measures = {0}, .edges = edges};
  std::vector<std::uint64_t> places;
  for (const Leaf& leaf : forest.leaves) {
    places.push_back(octree_place(leaf.cell));
    forest.measures.push_back(forest.measures.back() + leaf.weight / (leaf.facing == kMedium ? 4 : 1));
  }
  const auto add = [&](std::uint32_t first, std::uint32_t last, std::uint32_t parent) {
    Cluster out{.first = first, .last = last, .parent = parent, .facing = forest.leaves[first].facing};
    double low = forest.leaves[first].kappa, high = low;
    for (std::uint32_t i = first; i < last; ++i) {
      const Leaf& leaf = forest.leaves[i];
      const auto& [kind, origin, u, v, w] = leaf.element;
      const auto from = array_of(origin), to = array_of(origin + u + v + w);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        out.low[axis] = i == first ? from[axis] : std::min(out.low[axis], from[axis]);
        out.high[axis] = i == first ? to[axis] : std::max(out.high[axis], to[axis]);
      }
      low = std::min(low, leaf.kappa);
      high = std::max(high, leaf.kappa);
      out.weight += leaf.weight;
      out.measure += out.facing == kMedium ? leaf.weight / (4 * leaf.kappa) : leaf.weight;
    }
    double box = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (out.facing == kMedium || axis != out.facing / 2u) box *= (out.high[axis] - out.low[axis]) * edges[axis];
    }
    const bool flat = out.facing == kMedium || out.low[out.facing / 2u] == out.high[out.facing / 2u];
    constexpr double kAlike = 1e-9;  // rounding of the sums
    out.full = flat && high - low <= kAlike * high && box - out.measure <= kAlike * box;
    forest.clusters.push_back(out);
  };
  const auto size = [&] { return static_cast<std::uint32_t>(forest.clusters.size()); };
  const auto count = static_cast<std::uint32_t>(forest.leaves.size());
  for (std::uint32_t first = 0, last = 0; first < count; first = last) {
    while (last < count && forest.leaves[last].facing == forest.leaves[first].facing) ++last;
    forest.roots.push_back(size());
    add(first, last, kNone);
  }
  const unsigned leaf_bits = 3 * static_cast<unsigned>(std::bit_width(static_cast<unsigned>(leaf_voxels)) - 1);
  for (std::uint32_t i = 0; i < size(); ++i) {
    // Divides at the first octal digit in which the places of its leaves differ.
    const std::uint32_t last = forest.clusters[i].last, child = size();
    const auto top = static_cast<unsigned>(std::bit_width(places[forest.clusters[i].first] ^ places[last - 1]));
    if (top <= leaf_bits) continue;
    const unsigned digit = (top - 1) / 3 * 3;
    for (std::uint32_t begin = forest.clusters[i].first, end = begin; begin < last; begin = end) {
      while (end < last && places[end] >> digit == places[begin] >> digit) ++end;
      add(begin, end, i);
    }
    forest.clusters[i].child = child;
    forest.clusters[i].children = size() - child;
  }
  return forest;
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
