// Projections of any volume by the board: rays that integrate the values along them.
#pragma once

#include <span>
#include <vector>

#include "cone_beam/geometry.h"
#include "gicube/board.h"

namespace gicube::samples {

// Brings one value a voxel onto the board, in 12 bits between the least (at most 0) and the greatest of them. Sums that the
// board holds are lost. Throws BadArgument (another number of values than voxels, one that is not finite).
void load_values(Board& board, const Grid& grid, std::span<const float> values);

// Views of what load_values() brought, one after the other; the board works at the next while one is received.
class Projector {
 public:
  // Samples are at most `step` voxels apart, 1/64..16.
  Projector(Board& board, const ConeGeometry& geometry, double step)
      : board_(board), geometry_(geometry), step_(step) {}

  void begin(double angle);
  // The line integrals of the oldest view begun, a pixel each.
  std::vector<float> next();
  std::uint64_t rays() const { return rays_; }

 private:
  struct View {
    Ticket ticket;
    std::vector<HostRay> rays;        // that meet the volume
    std::vector<std::size_t> pixels;  // theirs
  };
  Board& board_;
  const ConeGeometry& geometry_;
  double step_;
  std::vector<View> under_way_;
  std::uint64_t rays_ = 0;
};

// All views of a volume with geometry.volume's voxels, x fastest. What lies outside of it is nothing.
// Throws BadArgument (geometry, volume, step), what the board throws.
Projections project_by_board(Board& board, const ConeGeometry& geometry, std::span<const float> volume,
                             double step = 0.5, const Progress& progress = {});

}  // namespace gicube::samples
