// Photon mapping (Jensen 1996; media Jensen and Christensen 1998): light's paths leave photons where they interact, and
// the light scattered to the eye is found from the density of those round a place.
//
// Each pass has photons of its own. Light that comes straight from a light is found by shadow rays; photons are what
// was reflected, refracted or scattered before. Their density is even over the ball that holds the neighbours: light is
// blurred by so much, which more photons make less, and more passes do not.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "light/transport/eye.h"
#include "light/transport/paths.h"
#include "light/transport/radiance.h"

namespace gicube::samples {

struct Photon {
  Vec3 place, direction;  // in which it came
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
  // The photons nearest to a place, at most `count`, none beyond `radius`; and the radius of the ball that their
  // density is of: that of the farthest, which is left out then, or `radius` if there are fewer.
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
  int neighbours = 60;              // of a density
  double radius = 8;                // greatest, in smallest voxel edges
  int max_scatterings = 32;         // of a photon
  double step = 0.5;                // voxels between the board's samples
  std::uint64_t seed = 0;
};

struct PhotonStatistics {
  std::uint64_t emitted = 0, on_surfaces = 0, in_media = 0;  // kept
  std::uint64_t rays = 0;                                    // of the board, all kinds
  // Densities of photons in media; those whose ball reaches beyond the volume, where no photons are, and that are too
  // low.
  std::uint64_t looks_in_media = 0, beyond_faces = 0;
};

class PhotonMapping {
 public:
  // All must outlive it. Throws InputError as Eye().
  PhotonMapping(Board& board, const Medium& medium, const Lights& lights, const View& view,
                const PhotonSettings& settings);

  // New photons, and one path of the eye for each pixel.
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
