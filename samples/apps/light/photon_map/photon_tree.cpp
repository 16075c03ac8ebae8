#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

#include "light/photon_map/photon_map.h"

namespace gicube::samples {
namespace {

struct Cloud {
  std::vector<Photon> photons;

  std::size_t kdtree_get_point_count() const { return photons.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    const Vec3& p = photons[i].place;
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;  // nanoflann computes it
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3>;

}  // namespace

struct PhotonTree::Index {
  explicit Index(std::vector<Photon> photons) : cloud{std::move(photons)}, tree(3, cloud) {}
  Cloud cloud;
  Tree tree;
};

PhotonTree::PhotonTree(std::vector<Photon> photons) : index_(std::make_unique<Index>(std::move(photons))) {}
PhotonTree::~PhotonTree() = default;
PhotonTree::PhotonTree(PhotonTree&&) noexcept = default;
PhotonTree& PhotonTree::operator=(PhotonTree&&) noexcept = default;

std::size_t PhotonTree::size() const { return index_->cloud.photons.size(); }

PhotonTree::Near PhotonTree::nearest(Vec3 place, std::size_t count, double radius) const {
  Near out{{}, radius};
  if (size() == 0) return out;
  std::vector<std::uint32_t> which(count);
  std::vector<double> squares(count);
  const std::array<double, 3> query{place.x, place.y, place.z};
  const std::size_t found = index_->tree.knnSearch(query.data(), count, which.data(), squares.data());
  // The farthest photon lies on the surface of the ball. With count - 1 photons the density is unbiased.
  std::size_t kept = found;
  if (found == count && squares[count - 1] < radius * radius) {
    out.radius = std::sqrt(squares[count - 1]);
    kept = count - 1;
  }
  for (std::size_t i = 0; i < kept && squares[i] < radius * radius; ++i) {
    out.photons.push_back(&index_->cloud.photons[which[i]]);
  }
  return out;
}

}  // namespace gicube::samples
