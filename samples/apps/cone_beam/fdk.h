// Filtered backprojection by the board: the method of Feldkamp, Davis and Kress (1984). Energy-depositing rays without
// attenuation backproject [P §5.6]. docs/guide/cone_beam.md derives the weights.
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

// Filters rows of samples that are `pitch` apart, by circular convolution with FFTW. Padding keeps a row's ends apart.
// Several threads may use one filter at once.
class RampFilter {
 public:
  RampFilter(int samples, double pitch, Window window);
  // `row` and `out`: `samples` values each.
  void apply(const double* row, double* out) const;
  // Greatest magnitude of filtered values if the values are at most 1.
  double gain() const;

 private:
  int samples_;
  std::size_t padded_;
  std::vector<double> response_;  // real, at the frequencies of the transform
  struct End {
    void operator()(fftw_plan_s* plan) const;
  };
  std::unique_ptr<fftw_plan_s, End> forward_, backward_;
};

// Words that accumulate the deposits.
enum class Accumulator {
  kSums,  // the volume's own words, signed, 36 bits
  // Irradiance words, unsigned, 11 bits (32 on a board with the wide datapath). One pass deposits positive values,
  // another one negative values. Each is scaled to the words; the host reads them back and adds them up before they are
  // full.
  kIrradiance,
};

struct FdkSettings {
  Window window = Window::kRamLak;
  int rays = 0;     // rays per pixel along each detector axis, 1..4; 0: rays_of() chooses
  double step = 1;  // 1/64..16 voxels between deposits
  // Part, 0..1/4, of each neighbour on an axis that is subtracted from a voxel, against the blur of splatting. Empty:
  // sharpening_of() chooses.
  std::optional<double> sharpen{};
  bool normalise = true;  // calls normalise()
  Accumulator accumulator = Accumulator::kSums;
  int read_every = 8;  // kIrradiance: views, at least 1, after which the words are read back and cleared
  int bits = 0;        // kIrradiance: bits of the words to use, 4..32; 0: all
  // kIrradiance, > 0: value of full words, relative to a bound of a voxel's value. Less makes rounding finer, and
  // clips: see Reconstruction::clipped.
  double headroom = 1;
};

// Width or height of a pixel at the axis in voxels, whichever is greater.
double voxels_of_a_pixel(const ConeGeometry& geometry);
// settings.rays along both axes. If that is 0, the fewest rays, 1 to 4 along each axis, whose error is about that of
// double precision; docs/guide/cone_beam.md has the rule.
PixelRays rays_of(const FdkSettings& settings, const ConeGeometry& geometry);
// settings.sharpen on each axis. If it is empty, the strength that suits the number of rays.
std::array<double, 3> sharpening_of(const FdkSettings& settings, const ConeGeometry& geometry);

// Weights a view's projections by cosines and by WeightedRows, and filters them. Returns the densities that the rays of
// widened(geometry, displaced) deposit. `filter`: of widened(geometry, displaced).
std::vector<double> filtered_view(const Projections& projections, const ConeGeometry& geometry, std::size_t view,
                                  const RampFilter& filter, PixelRays rays, bool displaced = false);
RampFilter ramp_filter(const ConeGeometry& geometry, Window window);

// Replaces each value v by v (1 + 2 part) - part (both neighbours), along each axis with its part. The ends are their
// own neighbours.
void sharpen(std::vector<float>& values, const Dims& dims, const std::array<double, 3>& parts);

// Backprojects a few views at a time into irradiance words [P §4.2]: their positive values in one pass, their negative
// ones in a second. Each pass has a unit that fits the greatest possible value of a voxel. The host reads the words
// after each pass and adds them up.
Reconstruction backproject_into_irradiance(Board& board, const Projector& projector, const FdkSettings& settings,
                                           const ViewDensities& filtered, const Progress& progress);

// Divides out ripples along the axis of rotation. All views share them; rows of rays at varying distances from voxel
// centres cause them. The divisor is the sum that a uniform volume's rays would deposit over the ideal one, from the
// geometry alone. Only voxels that every view sees completely are divided: the others have less for another reason.
void normalise(Reconstruction& made, const ConeGeometry& geometry, const FdkSettings& settings);

// Loads an empty volume of geometry.volume's dims into the board, and leaves the sums there. facing() first resamples
// views with their own poses. Throws BadArgument (geometry, projections, settings, a source off the circle, a short
// scan by a displaced detector), what the board throws.
Reconstruction reconstruct_fdk(Board& board, const ConeGeometry& geometry, const Projections& projections,
                               const FdkSettings& settings = {}, const Progress& progress = {});

}  // namespace gicube::samples
