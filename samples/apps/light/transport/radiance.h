// Pictures of radiance from independent passes.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "light/transport/optics.h"

namespace gicube::samples {

inline Rgb product(const Rgb& a, const Rgb& b, double factor) {
  return {a[0] * b[0] * factor, a[1] * b[1] * factor, a[2] * b[2] * factor};
}
inline void add(Rgb& sum, const Rgb& value, double factor = 1) {
  for (std::size_t c = 0; c < 3; ++c) sum[c] += value[c] * factor;
}

// Rows from the top. A white surface has the radiance L if a power of pi L falls on a unit of its area (a square of the
// smallest voxel edge).
struct RadiancePicture {
  int width = 0, height = 0;
  std::uint64_t passes = 0;
  std::vector<Rgb> mean, error;  // standard errors from the passes' scatter; infinite for one pass
};

class RadianceSum {
 public:
  RadianceSum(int width, int height)
      : picture_{width,
                 height,
                 0,
                 std::vector<Rgb>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
                 {}},
        squares_(picture_.mean.size()) {}

  std::size_t pixels() const { return squares_.size(); }
  std::uint64_t passes() const { return picture_.passes; }
  void add(const std::vector<Rgb>& pass) {
    const auto n = static_cast<double>(++picture_.passes);
    for (std::size_t i = 0; i < pass.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {  // Welford's method, which avoids cancellation
        const double off = pass[i][c] - picture_.mean[i][c];
        picture_.mean[i][c] += off / n;
        squares_[i][c] += off * (pass[i][c] - picture_.mean[i][c]);
      }
    }
  }
  RadiancePicture picture() const {
    RadiancePicture out = picture_;
    out.error = squares_;
    const auto n = static_cast<double>(out.passes);
    for (Rgb& pixel : out.error) {
      for (double& part : pixel) part = n < 2 ? std::numeric_limits<double>::infinity() : std::sqrt(part / (n - 1) / n);
    }
    return out;
  }

 private:
  RadiancePicture picture_;
  std::vector<Rgb> squares_;
};

}  // namespace gicube::samples
