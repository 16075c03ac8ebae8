// The eye of a view, as the board's pictures have it: pixels of a perspective image.
#pragma once

#include <cstdint>
#include <optional>

#include "gicube/view.h"
#include "light/transport/medium.h"

namespace gicube::samples {

class Eye {
 public:
  // Throws InputError for a parallel view, which light can't be connected with.
  Eye(const View& view, const Medium& medium);

  Vec3 place() const { return eye_; }
  // Through image point (x, y), pixels from the top left corner; unit.
  Vec3 direction(double x, double y) const;
  // Direction of the `ray`th ray through a pixel (rows from the top); a pixel's rays are spread evenly.
  Vec3 direction(std::size_t pixel, int ray, std::uint64_t seed) const;
  std::optional<std::size_t> pixel_of(Vec3 direction) const;
  // Density of a direction whose image point is even over a pixel, per solid angle.
  double density(Vec3 direction) const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_, height_;
  Vec3 eye_, forward_, right_, up_;
  double pixel_;  // its edge at distance 1
};

}  // namespace gicube::samples
