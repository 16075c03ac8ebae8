// Filtered backprojection by the board: the method of Feldkamp, Davis and Kress (1984), its backprojection by
// energy-depositing rays that nothing weakens [P §5.6]. docs/guide/cone_beam.md derives the weights.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "cone_beam/redundancy.h"
#include "cone_beam/view_rays.h"

struct fftw_plan_s;  // FFTW's own

namespace gicube::samples {

enum class Window { kRamLak, kSheppLogan, kHann };

// Filters rows of samples that are `pitch` apart: circular convolution by FFTW, padded so that no row meets itself.
// One filter may be used from several threads at once.
class RampFilter {
 public:
  RampFilter(int samples, double pitch, Window window);
  // Both of `samples` values.
  void apply(const double* row, double* out) const;
  // The most that values of at most 1 become.
  double gain() const;

 private:
  int samples_;
  std::size_t padded_;
  std::vector<double> response_;  // real, at the transform's frequencies
  struct End {
    void operator()(fftw_plan_s* plan) const;
  };
  std::unique_ptr<fftw_plan_s, End> forward_, backward_;
};

// The words that rays leave their values in.
enum class Accumulator {
  kSums,  // signed, 36 bits: the volume's own words
  // Irradiance words, 11 bits without a sign (32 of a board with the wide datapath): positive values in one pass,
  // negative ones in another, each scaled to the words, read back and added up on the host before they are full.
  kIrradiance,
};

struct FdkSettings {
  Window window = Window::kRamLak;
  int rays = 0;     // 1..4: a pixel's along both detector axes; 0: by the size of pixels and voxels, rays_of()
  double step = 1;  // 1/64..16 voxels between deposits
  // 0..1/4: what each voxel takes from either neighbour on an axis, against the blur of splatting; nothing:
  // sharpening_of().
  std::optional<double> sharpen{};
  // Whether the ripples of rows of rays that lie unevenly against voxels are divided out (normalise()).
  bool normalise = true;
  Accumulator accumulator = Accumulator::kSums;
  int read_every = 8;  // kIrradiance: views, at least 1, after which the words are read back and cleared
  // kIrradiance, 4..32: bits of the words that are used; 0: all that there are.
  int bits = 0;
  // kIrradiance, > 0: what full words stand for, over a bound of what a voxel can get. Less makes rounding finer, and
  // clips, which Reconstruction::clipped tells.
  double headroom = 1;
};

// How many voxels a pixel is wide or high at the axis, whichever is more.
double voxels_of_a_pixel(const ConeGeometry& geometry);
// settings.rays along both axes or, if that is 0, the fewest whose error is about that of double precision, 1 to 4
// along each: docs/guide/cone_beam.md has the rule.
PixelRays rays_of(const FdkSettings& settings, const ConeGeometry& geometry);
// settings.sharpen on each axis or, if it is not given, the strength that suits the number of rays.
std::array<double, 3> sharpening_of(const FdkSettings& settings, const ConeGeometry& geometry);

// One view's projections, cosine-weighted, shared out (WeightedRows), and filtered: what the rays of widened(geometry,
// displaced) leave in a unit of volume. `filter`: of widened(geometry, displaced).
std::vector<double> filtered_view(const Projections& projections, const ConeGeometry& geometry, std::size_t view,
                                  const RampFilter& filter, PixelRays rays, bool displaced = false);
RampFilter ramp_filter(const ConeGeometry& geometry, Window window);

// v (1 + 2 part) - part (both neighbours), along each axis by its part; the ends are their own neighbours.
void sharpen(std::vector<float>& values, const Dims& dims, const std::array<double, 3>& parts);

// Some views at a time into irradiance words [P §4.2]: their positive values in one pass, their negative ones in a
// second one, the words' unit chosen for each pass by the greatest that a voxel can get of it. The words are read after
// each pass; the host adds up.
Reconstruction backproject_into_irradiance(Board& board, const Projector& projector, const FdkSettings& settings,
                                           const ViewDensities& filtered, const Progress& progress);

// Rows of rays that lie unevenly against voxels leave ripples along the axis of rotation, which all views have in
// common. Divides the values by what an even volume's rays would leave over what they should, as the geometry alone
// tells: only voxels that every view sees whole, since the others have less for another reason.
void normalise(Reconstruction& made, const ConeGeometry& geometry, const FdkSettings& settings);

// Loads an empty volume of geometry.volume's dims into the board, and leaves the sums there.
// Views with poses of their own are resampled first: facing(). Throws BadArgument (geometry, projections, settings, a
// source off the circle, a short scan by a displaced detector), what the board throws.
Reconstruction reconstruct_fdk(Board& board, const ConeGeometry& geometry, const Projections& projections,
                               const FdkSettings& settings = {}, const Progress& progress = {});

}  // namespace gicube::samples
