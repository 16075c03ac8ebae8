// Four scans whose objects and line integrals are known in closed form, for judging reconstructions: ellipsoids and
// boxes anywhere, detectors off centre with pixels that are not square, and the mean of the object in each voxel as the
// truth.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cone_beam/geometry.h"

namespace gicube::reference {

struct Solid {
  enum class Shape { kEllipsoid, kBox } shape = Shape::kEllipsoid;
  double value = 0;  // added to what it overlaps
  Vec3 half;         // axes or edges
  Vec3 centre;
  double turned = 0;  // about z, radians
};

struct FdkScan {
  std::string name;
  samples::ConeGeometry geometry;
  std::vector<Solid> object;
};

// `size` voxels along x; the detectors see all of the volume from every view.
std::vector<FdkScan> fdk_scans(int size);
// Five ellipsoids and a box; pixels of 0.5 to 2 voxels, the same for each seed, or of the width and height given.
FdkScan random_fdk_scan(int size, unsigned seed, std::optional<std::array<double, 2>> pixel = {});

samples::Projections project(const FdkScan& scan);
// Over 6^3 places in each voxel, x fastest.
std::vector<double> mean_in_voxels(const FdkScan& scan);

}  // namespace gicube::reference
