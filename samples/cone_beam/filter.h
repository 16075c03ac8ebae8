// What Feldkamp, Davis and Kress (1984) do to projections before they are backprojected: cosine weights, weights of rays
// that a short scan measures twice, and the ramp filter along detector rows.
#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <vector>

#include "cone_beam/geometry.h"

struct fftw_plan_s;  // FFTW's own

namespace gicube::samples {

enum class Window { kRamLak, kSheppLogan, kHann };

// Filters rows of samples that are `pitch` apart: circular convolution by FFTW, padded so that no row meets itself.
// One filter may be used from several threads at once.
class RampFilter {
 public:
  // `fine`: as many results a sample, evenly around it (1: at the samples; 2: a quarter before and behind). What lies
  // between samples is interpolated by the transform itself, exactly for a row of limited band.
  RampFilter(int samples, double pitch, Window window, int fine = 1);
  // `row`: samples; `out`: fine x samples.
  void apply(const double* row, double* out) const;

 private:
  int samples_;
  int fine_;
  std::size_t padded_;
  std::vector<double> response_;              // real, at the transform's frequencies
  std::vector<std::complex<double>> shifts_;  // of each of the fine results, then by frequency
  struct End {
    void operator()(fftw_plan_s* plan) const;
  };
  std::unique_ptr<fftw_plan_s, End> forward_, backward_;
};

// Of each angle: the arc that it stands for, times one half where every ray is measured twice (a whole turn).
std::vector<double> arc_weights(const ConeGeometry& geometry);
// The arc that all angles stand for.
double arc_of(const ConeGeometry& geometry);
// Whether the angles don't make a whole turn: then short_scan_weight() shares twice measured rays out.
bool is_short_scan(const ConeGeometry& geometry);
// Parker's weight (1982) in a scan over `arc`, at least pi and twice the largest fan angle, of the rays at `fan` in the view
// `angle` after the first. They are measured again at angle + pi + 2 fan, from -fan; the weights of both sum to one, and rise
// and fall smoothly. Column u of a detector has fan = -atan(u / source_to_detector).
double short_scan_weight(double angle, double fan, double arc);

}  // namespace gicube::samples
