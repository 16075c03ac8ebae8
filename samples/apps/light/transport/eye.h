// The eye of a view, with the perspective pixels of the board's pictures.
#pragma once

#include <optional>

#include "gicube/view.h"
#include "light/transport/medium.h"

namespace gicube::samples {

class Eye {
 public:
  // Throws InputError for a parallel view, because light paths can't be connected with its eye.
  Eye(const View& view, const Medium& medium);

  Vec3 place() const { return eye_; }
  // Unit vector through image point (x, y), in pixels from the top left corner.
  Vec3 direction(double x, double y) const;
  std::optional<std::size_t> pixel_of(Vec3 direction) const;
  // Density, per solid angle, of a direction whose image point is uniform over a pixel.
  double density(Vec3 direction) const;
  std::size_t width() const { return static_cast<std::size_t>(width_); }
  std::size_t pixels() const { return width() * static_cast<std::size_t>(height_); }

 private:
  int width_, height_;
  Vec3 eye_, forward_, right_, up_;
  double pixel_;  // its edge at distance 1
};

}  // namespace gicube::samples
