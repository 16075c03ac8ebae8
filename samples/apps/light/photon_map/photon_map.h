// Photon mapping (Jensen 1996; media Jensen and Christensen 1998): paths from lights store photons where they interact,
// and the light scattered to the eye is estimated from the density of photons around a point.
//
// Each pass has its own photons. Shadow rays find direct light; photons are light that was reflected, refracted or
// scattered before. The estimate assumes a uniform density over the ball of the neighbours, and so blurs the light by
// its radius. More photons reduce the blur, more passes do not.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "light/transport/eye.h"
#include "light/transport/paths.h"
#include "light/transport/radiance.h"

namespace gicube::samples {

struct Photon {
  Vec3 place, direction;  // along which it arrived
  Rgb power;
};

// Photons of one kind in a balanced kd-tree.
class PhotonTree {
 public:
  explicit PhotonTree(std::vector<Photon> photons);
  ~PhotonTree();
  PhotonTree(PhotonTree&&) noexcept;
  PhotonTree& operator=(PhotonTree&&) noexcept;

  std::size_t size() const;
  // The photons nearest to a point, at most `count` and none beyond `radius`, and the radius of their ball: the
  // distance of the farthest, which is then left out, or `radius` if there are fewer than `count`.
  struct Near {
    std::vector<const Photon*> photons;
    double radius = 0;
  };
  Near nearest(Vec3 place, std::size_t count, double radius) const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

struct PhotonSettings {
  std::uint64_t photons = 100'000;  // paths from lights, each pass
  int neighbours = 60;              // in a density estimate
  double radius = 8;                // of their ball, at most; in smallest voxel edges
  int max_scatterings = 32;         // of a photon
  double step = 0.5;                // voxels between the board's samples
  std::uint64_t seed = 0;
};

struct PhotonStatistics {
  std::uint64_t emitted = 0, on_surfaces = 0, in_media = 0;  // the last two: stored photons
  std::uint64_t rays = 0;                                    // of all kinds, traced by the board
  // Density estimates in media; and those that are too low, because their ball reaches beyond the volume, where no
  // photons are stored.
  std::uint64_t looks_in_media = 0, beyond_faces = 0;
};

class PhotonMapping {
 public:
  // The arguments must outlive it. Throws InputError as Eye().
  PhotonMapping(Board& board, const Medium& medium, const Lights& lights, const View& view,
                const PhotonSettings& settings);

  // Traces new photons, and one path from the eye for each pixel.
  void pass();
  RadiancePicture picture() const { return sum_.picture(); }
  const PhotonStatistics& statistics() const { return statistics_; }

 private:
  void shoot();
  void look(std::size_t first, std::size_t count, std::vector<Rgb>& pixels);
  Rgb gathered(const Vertex& vertex);

  const Medium& medium_;
  const Lights& lights_;
  Eye eye_;
  PhotonSettings settings_;
  Flights flights_;
  Paths paths_;
  PhotonTree surfaces_, media_;
  RadianceSum sum_;
  PhotonStatistics statistics_;
};

}  // namespace gicube::samples
